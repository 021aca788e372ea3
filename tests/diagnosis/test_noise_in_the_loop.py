"""Where a controller answers the noise of the sensor, the input knows of it; nothing is missing for that."""

import numpy as np
import pandas as pd
import pytest

import camid

SUBSTEPS = 20
POSITION_GAIN, VELOCITY_GAIN, LIMIT = 12.0, 0.55, 10.0


def motor(control_of, reference, seed, period, noise, gain, damping, stiffness=0.0):
    """A motor, by steps far shorter than a sample, whose input a controller makes of noisy positions."""
    random = np.random.default_rng([48, seed])
    angle = speed = 0.0
    control, seen = np.zeros(len(reference)), np.zeros(len(reference))
    step = period / SUBSTEPS
    for k in range(len(reference)):
        seen[k] = angle + noise * random.standard_normal()
        control[k] = control_of(reference[k], seen[k], speed)
        for _ in range(SUBSTEPS):
            middle = speed + 0.5 * step * (gain * control[k] - damping * speed - stiffness * angle)
            angle += step * middle
            speed += step * (gain * control[k] - damping * middle - stiffness * (angle - 0.5 * step * middle))
    return pd.DataFrame({"t": period * np.arange(len(reference)), "r": reference, "u": control, "y": seen})


def believed(gain, damping, **more):
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [gain], "denominator": [1.0, damping, 0.0]}},
        "sensor": {"column": "y", "kind": "instant"},
        **more,
    }


def cascade(reference, seen, speed):
    return np.clip(VELOCITY_GAIN * (POSITION_GAIN * (reference - seen) - speed), -LIMIT, LIMIT)


@pytest.mark.parametrize("seed", range(2))
def test_a_declared_controller(seed):
    controller = {
        "reference": "r",
        "position_gain": POSITION_GAIN,
        "velocity_gain": VELOCITY_GAIN,
        "limit": LIMIT,
    }
    reference = np.repeat(np.random.default_rng([9, seed]).choice([-1.0, -0.4, 0.5, 1.0], 60), 50)
    recording = motor(cascade, reference, seed, 0.005, 0.01, 28.0, 9.0)
    found = camid.diagnose(recording, believed(36.0, 6.0, controller=controller))
    assert found.verdict == "adequate"
    values = {c.name: (c.improved, c.improved_deviation) for c in found.coefficients}
    assert abs(values["b0"][0] - 28.0) < 4.0 * values["b0"][1]


def test_the_colour_of_a_declared_loop_is_no_fault():
    """Held up by a controller, against a force that grows with the way, the control follows the noise alone."""

    def held_up(reference, seen, speed):
        return np.clip(8.0 * (40.0 * (reference - seen) - speed), -6.0, 6.0)

    reference = np.repeat(np.random.default_rng(13).uniform(-0.004, 0.004, 40), 75)
    recording = motor(held_up, reference, 5, 0.004, 5e-5, 12.0, 1.0, stiffness=-900.0)
    controller = {"reference": "r", "position_gain": 40.0, "velocity_gain": 8.0, "limit": 6.0}
    plant = {"transfer_function": {"numerator": [9.0], "denominator": [1.0, 1.5, -700.0]}}
    found = camid.diagnose(recording, believed(9.0, 1.5, controller=controller, plant=plant))
    assert found.verdict == "adequate"
    (noise,) = [u for u in found.undetectable if u.identifier == "coloured-noise"]
    assert "the controller answers to the noise of its sensor" in noise.reason


@pytest.mark.parametrize("seed", range(2))
def test_a_controller_that_nobody_declares(seed):
    """A motion so slow that what is fast in it follows the noise alone: that of a row shows in the rows after it."""
    time = 0.01 * np.arange(2500)
    reference = 25.0 * np.sin(1.1 * time) + 12.0 * np.sin(0.43 * time + seed)
    recording = motor(lambda r, seen, speed: 0.16 * (r - seen), reference, seed, 0.01, 0.1, 1000.0, 25.0)
    found = camid.diagnose(recording.drop(columns="r"), believed(600.0, 18.0))
    assert found.verdict == "adequate"
