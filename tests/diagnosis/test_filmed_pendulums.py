"""Pendulums that swing out before a camera: two laws, which a mode or a disturbance imitates without an input."""

import math

import numpy as np
import pandas as pd
import pytest

import camid

FRAME, COUNT, FINE = 1.0 / 50.0, 1500, 30
EXPOSURE = FRAME / 3.0
PIXELS = 420.0
ZERO = 500.0


def angles(start, frequency, damping, drag=0.0, friction=0.0):
    """Angle at fine instants in rad by fourth-order Runge–Kutta steps; dry friction is steep about rest."""
    step = FRAME / FINE

    def derivative(angle, rate):
        dry = friction * math.tanh(rate / 0.004)
        return rate, -(frequency**2) * math.sin(angle) - damping * rate - drag * abs(rate) * rate - dry

    angle, rate, found = start, 0.0, [start]
    for _ in range(COUNT * FINE):
        a1, r1 = derivative(angle, rate)
        a2, r2 = derivative(angle + 0.5 * step * a1, rate + 0.5 * step * r1)
        a3, r3 = derivative(angle + 0.5 * step * a2, rate + 0.5 * step * r2)
        a4, r4 = derivative(angle + step * a3, rate + step * r3)
        angle += step * (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0
        rate += step * (r1 + 2.0 * r2 + 2.0 * r3 + r4) / 6.0
        found.append(angle)
    return np.array(found)


def filmed(positions, seed):
    """Means over the exposure that ends with each frame, with noise of half a percent."""
    open_for = round(EXPOSURE / FRAME * FINE)
    sums = np.concatenate([[0.0], np.cumsum(0.5 * (positions[1:] + positions[:-1]))])
    ends = np.arange(1, COUNT + 1) * FINE
    means = (sums[ends] - sums[ends - open_for]) / open_for
    noise = 0.005 * np.std(means) * np.random.default_rng([49, seed]).standard_normal(COUNT)
    return pd.DataFrame({"t": FRAME * np.arange(1, COUNT + 1), "x": ZERO + means + noise})


BELIEVED = {
    "schema": 1,
    "time": {"column": "t"},
    "input": None,
    "plant": {"transfer_function": {"numerator": [1.0], "denominator": [1.0, 0.08, 17.0]}},
    "sensor": {"column": "x", "kind": "camera", "exposure": EXPOSURE},
    "initial_state": "estimate",
}


def parameter(found, identifier, name):
    finding = next(f for f in found.findings if f.identifier == identifier)
    return finding.parameters[name]


@pytest.mark.parametrize(("start", "seed"), [(0.9, 1), pytest.param(0.6, 0, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_gravity_and_drag(start, seed):
    drag = 0.05
    found = camid.diagnose(filmed(PIXELS * angles(start, 4.4, 0.03, drag=drag), seed), BELIEVED)
    assert {f.identifier for f in found.findings} == {"pendulum-gravity", "quadratic-drag"}
    amplitude = parameter(found, "pendulum-gravity", "amplitude")
    assert abs(amplitude.value - PIXELS) < 4.0 * amplitude.standard_deviation
    coefficient = parameter(found, "quadratic-drag", "coefficient")
    assert abs(coefficient.value - drag / PIXELS) < 4.0 * coefficient.standard_deviation


@pytest.mark.slow
@pytest.mark.parametrize(("start", "seed"), [(0.8, 3), (0.55, 2)])
def test_gravity_and_friction_of_the_pivot(start, seed):
    friction = 0.05
    found = camid.diagnose(filmed(PIXELS * angles(start, 4.1, 0.02, friction=friction), seed), BELIEVED)
    assert {f.identifier for f in found.findings} == {"pendulum-gravity", "coulomb-friction"}
    force = parameter(found, "coulomb-friction", "force")
    assert abs(force.value - friction * PIXELS) < 4.0 * force.standard_deviation
    assert force.standard_deviation < 0.03 * force.value


@pytest.mark.slow
def test_a_bob_that_is_seen_from_the_side():
    """Its position is the sine of its angle: to the third order what a lens does."""
    found = camid.diagnose(filmed(PIXELS * np.sin(angles(0.55, 4.1, 0.02, friction=0.05)), 4), BELIEVED)
    names = {f.identifier for f in found.findings}
    assert {"coulomb-friction", "lens-distortion"} <= names
    assert names & {"pendulum-gravity", "cubic-stiffness"}
    bend = parameter(found, "lens-distortion", "k1")
    assert bend.value == pytest.approx(-1.0 / (6.0 * PIXELS**2), rel=0.1)
