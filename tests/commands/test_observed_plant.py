"""What the commands say of a plant that an observer pulls towards its recording."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.errors import InputError

PERIOD, FINE = 0.01, 20
BELIEVED = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [6.0], "denominator": [1.0, 0.8, -18.0]}},
    "sensor": {"column": "y", "kind": "instant"},
    "observer": {"rate": 6.0},
}


@pytest.fixture(scope="module")
def recording():
    """An inverted pendulum whose controller answers the noise of the frames; steps far shorter than a frame."""
    random = np.random.default_rng(11)
    wanted = np.repeat(0.15 * random.choice([-1.0, 1.0], 60), 40)
    command, frames = np.zeros(len(wanted)), np.zeros(len(wanted))
    angle = speed = last = 0.0
    step = PERIOD / FINE
    for k, goal in enumerate(wanted):
        frames[k] = angle + 2e-4 * random.standard_normal()
        command[k] = 7.5 * (goal - frames[k]) - 1.2 * (frames[k] - last) / PERIOD
        last = frames[k]
        for _ in range(FINE):
            middle = speed + 0.5 * step * (8.0 * command[k] - 0.5 * speed + 22.0 * angle)
            angle += step * middle
            speed += step * (8.0 * command[k] - 0.5 * middle + 22.0 * (angle - 0.5 * step * middle))
    return pd.DataFrame({"t": PERIOD * np.arange(len(wanted)), "u": command, "y": frames})


@pytest.fixture(scope="module")
def identified(recording):
    return camid.identify(recording, BELIEVED)


def test_it_is_identified_with_the_reason_of_the_residuals_colour(identified):
    found = identified.simulation
    values = (*found.plant.numerator, *found.plant.denominator[1:])
    deviations = np.sqrt(np.diag(found.covariance))
    for value, deviation, truth in zip(values, deviations, (8.0, 0.5, -22.0), strict=True):
        assert abs(value - truth) < 4.0 * deviation < 0.05 * abs(truth)
    said = " ".join(identified.warnings())
    assert "the observer answers to the noise of the sensor" in said
    assert "an observer pulls the simulated motion" in said


def test_residuals_say_what_an_observer_does_to_them(recording, identified):
    found = camid.residuals(recording, identified.simulation)
    assert any("an observer answers the noise" in remark for remark in found.remarks)


def test_poles_and_a_step_are_those_of_the_plant_alone(identified):
    poles = camid.poles(identified.simulation)
    assert any("without its observer" in remark for remark in poles.remarks)


def test_orders_of_such_plants_are_not_compared(recording):
    with pytest.raises(InputError, match="this one has an observer"):
        camid.select_order(recording, BELIEVED)


def test_no_input_is_designed_for_it(identified):
    with pytest.raises(InputError, match="follows a recording alone"):
        camid.design(identified.simulation, frame_rate=100.0)
