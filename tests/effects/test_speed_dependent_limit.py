"""A limit of the actuator that falls with the speed, as that of a motor under a limited voltage."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.effects.actuator import Saturation
from camid.effects.speed_dependent_limit import SpeedDependentSaturation
from tests.support.runge_kutta import positions

PERIOD, ROWS, LIMIT, SPEED, NOISE = 0.01, 2000, 4.2, 9.0, 0.01
SIMULATION = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [38.0], "denominator": [1.0, 6.2, 66.0]}},
    "sensor": {"column": "y", "kind": "instant"},
}


def recording(gain=45.0, seed=1):
    """Of a motor that turns an axis on a spring, under levels that are held for a while."""
    random = np.random.default_rng(seed)
    signal = np.repeat(random.uniform(-6.0, 6.0, ROWS // 25), 25)

    def rate(state, drive):
        position, velocity = state
        turned = np.sign(gain) * velocity
        torque = np.clip(drive, -LIMIT * (1.0 + turned / SPEED), LIMIT * (1.0 - turned / SPEED))
        return np.array([velocity, gain * torque - 5.0 * velocity - 60.0 * position])

    seen = positions(rate, signal, PERIOD, 20) + NOISE * random.standard_normal(ROWS)
    return pd.DataFrame({"t": PERIOD * np.arange(ROWS), "u": signal, "y": seen})


@pytest.mark.parametrize("gain", [45.0, pytest.param(-45.0, marks=pytest.mark.slow)])
def test_a_motor_whose_torque_falls_with_its_speed_is_named_with_its_speed_without_a_load(gain):
    numerator = {"transfer_function": {"numerator": [np.sign(gain) * 38.0], "denominator": [1.0, 6.2, 66.0]}}
    found = camid.diagnose(recording(gain), SIMULATION | {"plant": numerator})
    assert found.verdict == "explained"
    (effect,) = found.findings
    assert effect.identifier == "saturation"
    for name, truth in (("limit", LIMIT), ("no_load_speed", SPEED)):
        estimate = effect.parameters[name]
        assert abs(estimate.value - truth) < 4.0 * estimate.standard_deviation < 0.1 * truth
    assert found.fit.improved < 0.03
    assert found.fit.refitted > 0.1


def test_its_special_case_is_a_limit_that_is_the_same_at_any_speed():
    law = SpeedDependentSaturation(limit=2.0, no_load_speed=5.0)
    assert type(law.simplified()) is Saturation
    assert law.simplified().values["limit"] == 2.0
    # A stronger effect has the lower limit.
    assert law.scaled(2.0).values == {"limit": 1.0, "no_load_speed": 5.0}
