"""An actuator whose force depends on where it is: rigs by another integrator."""

import numpy as np
import pandas as pd
import pytest

import camid

PERIOD, COUNT, PARTS = 0.02, 1500, 40
SIMULATION = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [33.0], "denominator": [1.0, 2.4, 36.0]}},
    "sensor": {"column": "y", "kind": "instant"},
}


def recording(gain, levels=(-2.0, -1.0, 0.5, 1.0, 2.0)):
    """A mass on a spring, driven by a force that is a function of its position times the command; Verlet's steps."""
    random = np.random.default_rng(np.random.SeedSequence(31))
    signal = np.repeat(random.choice(levels, COUNT // 15), 15)
    step, position, velocity, positions = PERIOD / PARTS, 0.0, 0.0, []
    for held in signal:
        positions.append(position)
        for _ in range(PARTS):
            middle = position + 0.5 * step * velocity
            force = 40.0 * (held * gain(middle) - middle)
            velocity = ((1.0 - 1.5 * step) * velocity + step * force) / (1.0 + 1.5 * step)
            position = middle + 0.5 * step * velocity
    output = np.array(positions) + 0.01 * random.standard_normal(COUNT)
    return pd.DataFrame({"t": PERIOD * np.arange(COUNT), "u": signal, "y": output})


@pytest.mark.parametrize(
    ("gain", "truth"),
    [
        pytest.param(lambda y: 1.0 + 0.12 * y, {"slope": 0.12}, marks=pytest.mark.slow),
        (lambda y: 1.0 + 0.03 * y - 0.04 * y * y, {"slope": 0.03, "curvature": -0.04}),
    ],
)
def test_it_is_found_with_its_numbers(gain, truth):
    found = camid.diagnose(recording(gain), SIMULATION)
    (finding,) = found.findings
    assert (finding.identifier, found.verdict) == ("position-dependent-gain", "explained")
    assert found.location.place == "actuator"
    assert set(finding.parameters) == set(truth)
    for name, true in truth.items():
        estimate = finding.parameters[name]
        assert abs(estimate.value - true) < 4.0 * estimate.standard_deviation < 0.5 * abs(true)
    assert camid.diagnose(recording(gain), found.improved).verdict == "adequate"


def test_a_gain_that_stays_is_none():
    found = camid.diagnose(recording(lambda y: 1.0), SIMULATION)
    assert (found.verdict, found.findings) == ("adequate", [])
