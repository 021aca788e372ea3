"""A resonance of the drive before a spring that is no straight line: another one than behind the plant."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.effects.modes import ExtraMode, ModeOfDrive
from tests.support.runge_kutta import positions

PERIOD, ROWS, FREQUENCY, DAMPING, NOISE = 0.01, 1200, 22.0, 0.12, 0.01
SIMULATION = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [50.0], "denominator": [1.0, 5.2, 58.0]}},
    "sensor": {"column": "y", "kind": "instant"},
}


def recording(cubic):
    """Of a mass on a cubic spring, driven through a mode, under levels that are held for a while."""
    random = np.random.default_rng(5)
    signal = np.repeat(random.uniform(-2.0, 2.0, ROWS // 40), 40)

    def rate(state, drive):
        position, velocity, arrived, change = state
        bent = FREQUENCY**2 * (drive - arrived) - 2.0 * DAMPING * FREQUENCY * change
        force = 60.0 * (arrived - cubic * position**3) - 4.0 * velocity - 50.0 * position
        return np.array([velocity, force, change, bent])

    seen = positions(rate, signal, PERIOD, 20, states=4) + NOISE * random.standard_normal(ROWS)
    return pd.DataFrame({"t": PERIOD * np.arange(ROWS), "u": signal, "y": seen})


def test_it_is_found_beside_a_cubic_spring():
    found = camid.diagnose(recording(0.5), SIMULATION)
    assert found.verdict == "explained"
    named = {f.identifier: f for f in found.findings}
    assert set(named) == {"cubic-stiffness", "extra-mode"}
    mode = named["extra-mode"]
    assert mode.title == ModeOfDrive.title
    assert mode.parameters["side"].value == "drive"
    for name, truth in (("natural_frequency", FREQUENCY), ("damping", DAMPING)):
        estimate = mode.parameters[name]
        assert abs(estimate.value - truth) < 4.0 * estimate.standard_deviation < 0.1 * truth
    assert found.fit.improved < 0.03


@pytest.mark.slow
def test_without_another_force_a_mode_has_no_side():
    found = camid.diagnose(recording(0.0), SIMULATION)
    (mode,) = found.findings
    assert mode.title == ExtraMode.title
    assert abs(mode.parameters["natural_frequency"].value - FREQUENCY) < 0.1
