"""A camera that was moved between two recordings: each has a zero of its own."""

import numpy as np
import pandas as pd
import pytest

import camid
from tests.support.runge_kutta import positions

PERIOD, PARTS, ROWS, NOISE = 0.02, 20, 800, 0.003
SIMULATION = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [36.0], "denominator": [1.0, 3.5, 66.0]}},
    "sensor": {"column": "y", "kind": "instant"},
    "effects": [],
}


def recording(size, seed, *, zero=0.0, friction=0.0, unequal=1.0):
    """Of a mass on a spring under a random telegraph signal of a size."""
    random = np.random.default_rng(seed)
    signal = size * np.repeat(random.choice([-1.0, 1.0], ROWS // 8), 8)

    def rate(state, drive):
        position, velocity = state
        force = drive * (unequal if drive < 0.0 else 1.0) - friction * np.tanh(velocity / 0.02)
        return np.array([velocity, 40.0 * force - 4.0 * velocity - 60.0 * position])

    seen = positions(rate, signal, PERIOD, PARTS) + zero + NOISE * random.standard_normal(ROWS)
    return pd.DataFrame({"t": PERIOD * np.arange(ROWS), "u": signal, "y": seen})


def diagnosis(*recordings):
    return camid.diagnose(list(recordings), SIMULATION, time_limit=None)


def said(found):
    """What is said of a zero of its own: number of the recording, value and standard deviation."""
    words = [warning.split() for warning in found.warnings if "a zero of its own" in warning]
    return [(int(w[1]), float(w[3]), float(w[5])) for w in words]


@pytest.mark.slow
def test_zeros_that_differ_are_no_effect():
    tables = [recording(1.0, 1), recording(1.0, 2, zero=-0.3), recording(1.0, 3, zero=0.05)]
    found = diagnosis(*tables)
    assert found.verdict == "adequate"
    zeros = said(found)
    assert [number for number, *_ in zeros] == [2, 3]
    for (_, value, deviation), zero in zip(zeros, (-0.3, 0.05), strict=True):
        assert abs(value - zero) < 4.0 * deviation < 0.01
    for signals, table in zip([found.signals, *found.further_signals], tables, strict=True):
        assert np.array_equal(signals.recorded, table["y"])
        assert np.std(signals.recorded - signals.improved) < 1.2 * NOISE
        assert abs(np.mean(signals.recorded - signals.improved)) < NOISE
    # No one zero suits them all: the next recording says where its own is.
    assert found.improved.offset == "estimate"
    assert diagnosis_with(found, *tables).verdict == "adequate"


def diagnosis_with(found, *recordings):
    return camid.diagnose(list(recordings), found.improved.to_mapping(), time_limit=None)


def decays(seed, angle, zero):
    """A torsion pendulum of ω² = 18.5 s⁻² that is let go at an angle."""
    random, time = np.random.default_rng(seed), PERIOD * np.arange(1000)
    rate, damping = np.sqrt(18.5 - 0.11**2), np.exp(-0.11 * time)
    motion = angle * damping * (np.cos(rate * time) + 0.11 / rate * np.sin(rate * time))
    return pd.DataFrame({"t": time, "y": zero + motion + NOISE * random.standard_normal(1000)})


def test_a_plant_that_decays_does_not_integrate_because_the_camera_was_moved():
    """One that does is at another place in each recording, and zeros beside it explain nothing."""
    nominal = SIMULATION | {
        "input": None,
        "plant": {"transfer_function": {"numerator": [1.0], "denominator": [1.0, 0.3, 16.0]}},
        "initial_state": "estimate",
    }
    found = camid.diagnose([decays(1, 0.35, 0.1), decays(2, -0.2, 0.4)], nominal, time_limit=None)
    assert found.verdict == "adequate"
    stiffness = next(c for c in found.coefficients if c.name == "a0")
    assert abs(stiffness.improved - 18.5) < 4.0 * stiffness.improved_deviation < 0.05
    ((number, value, deviation),) = said(found)
    assert number == 2
    assert abs(value - 0.3) < 4.0 * deviation < 0.01


@pytest.mark.slow
def test_friction_is_found_beside_zeros_that_differ():
    found = diagnosis(recording(1.0, 1, friction=0.15), recording(2.5, 2, friction=0.15, zero=-0.3))
    (effect,) = found.findings
    assert effect.identifier == "coulomb-friction"
    force = effect.parameters["force"]
    assert abs(force.value - 0.15) < 4.0 * force.standard_deviation
    ((number, value, deviation),) = said(found)
    assert number == 2
    assert abs(value + 0.3) < 4.0 * deviation


@pytest.mark.slow
def test_a_gain_that_differs_between_the_signs_is_no_zero():
    """It moves the mean of each recording, too, by as much as the input is large."""
    sizes = np.repeat([0.5, 1.0, 1.5, 2.0], ROWS // 4)
    tables = []
    for seed, size in enumerate((sizes, 0.3 * sizes)):
        tables.append(recording(size, seed, unequal=0.8))
    found = diagnosis(*tables)
    (effect,) = found.findings
    assert effect.identifier == "gain-asymmetry"
    assert effect.parameters["ratio"].value == pytest.approx(0.8, abs=0.01)
    assert not said(found)


@pytest.mark.slow
def test_a_zero_that_is_declared_holds_for_all():
    declared = {**SIMULATION, "sensor": {**SIMULATION["sensor"], "offset": 0.0}}
    found = camid.diagnose([recording(1.0, 1), recording(1.0, 2, zero=-0.3)], declared, time_limit=None)
    assert found.verdict != "adequate"
    assert not said(found)


@pytest.mark.slow
def test_a_motor_may_begin_elsewhere():
    """The position of a plant that integrates is counted from where each recording begins."""

    def rate(state, drive):
        return np.array([state[1], 50.0 * drive - 8.0 * state[1]])

    tables = []
    for seed, zero in enumerate((0.0, 7.5)):
        random = np.random.default_rng(seed)
        signal = np.repeat(random.choice([-1.0, 1.0], ROWS // 8), 8)
        seen = positions(rate, signal, PERIOD, PARTS) + zero + NOISE * random.standard_normal(ROWS)
        tables.append(pd.DataFrame({"t": PERIOD * np.arange(ROWS), "u": signal, "y": seen}))
    plant = {"transfer_function": {"numerator": [45.0], "denominator": [1.0, 7.0, 0.0]}}
    found = camid.diagnose(tables, {**SIMULATION, "plant": plant}, time_limit=None)
    assert found.verdict == "adequate"
    ((_, value, deviation),) = said(found)
    assert abs(value - 7.5) < 4.0 * deviation
