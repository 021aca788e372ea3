"""Frames between the samples of the drive: the plant is found as exactly as if both ran at one rate."""

import numpy as np
import pytest

import camid
from camid.errors import InputError
from tests.support.two_rates import SIMULATION, two_rates

TRUTH = np.array([105.3, 2.7, 81.0])
WRONG = {"transfer_function": {"numerator": [90.0], "denominator": [1.0, 2.0, 75.0]}}


def with_state(state):
    return {**SIMULATION, "plant": WRONG, "initial_state": state}


@pytest.mark.parametrize("state", ["zero", "estimate"])
def test_identify_finds_the_plant(state):
    found = camid.identify(two_rates(), with_state(state))
    plant, deviations = found.simulation.plant, found.simulation.standard_deviations
    estimate = np.array([plant.numerator[-1], *plant.denominator[1:]])
    deviation = np.array([deviations["numerator"][-1], *deviations["denominator"][1:]])
    assert np.all(np.abs(estimate - TRUTH) < 3.5 * deviation)
    assert np.all(deviation < 1e-2 * TRUTH)


def test_a_drive_slower_than_the_frames():
    found = camid.identify(two_rates(rate=21.0, frames=60.0), with_state("zero"))
    assert found.simulation.plant.denominator[-1] == pytest.approx(81.0, rel=1e-3)


@pytest.mark.parametrize("rate", [21.0, 173.0, 1000.0])
def test_simulate_follows_the_frames(rate):
    table = two_rates(rate=rate, noise=0.0)
    found = camid.simulate(table, SIMULATION)
    frames = table.dropna()
    np.testing.assert_allclose(found["t"], frames["frame"])
    assert np.std(found["simulated"].to_numpy() - frames["y"].to_numpy()) < 1e-4 * frames["y"].std()


def test_a_limited_actuator_between_two_rates():
    """What it limits is the input as it was logged, not its mean over a frame."""
    table = two_rates(noise=0.0, curve=lambda u: np.clip(u, -0.4, 0.4))
    limited = {**SIMULATION, "effects": [{"id": "saturation", "parameters": {"limit": 0.4}}]}
    found = camid.simulate(table, limited)
    frames = table.dropna()
    error = np.std(found["simulated"].to_numpy() - frames["y"].to_numpy())
    assert error < 1e-4 * frames["y"].std()


def test_diagnose_finds_nothing_and_what_is_there():
    assert camid.diagnose(two_rates(), with_state("zero")).verdict == "adequate"
    found = camid.diagnose(two_rates(curve=lambda u: np.clip(u, -0.4, 0.4)), with_state("zero"))
    assert found.findings[0].identifier == "saturation"
    assert found.findings[0].parameters["limit"].value == pytest.approx(0.4, abs=0.02)


FIXED = {
    "transfer_function": {
        "transfer_function": {"numerator": [105.3], "denominator": [1.0, 2.7, 81.0]},
        "free": {"numerator": [False], "denominator": [False, False, False]},
    },
    "physical": {
        "physical": {
            "parameters": {"gain": 105.3, "damping": 2.7, "stiffness": 81.0},
            "fixed": ["gain", "damping", "stiffness"],
            "transfer_function": {"numerator": ["gain"], "denominator": ["1", "damping", "stiffness"]},
        }
    },
}


@pytest.mark.parametrize("form", FIXED)
def test_a_latency_alone_is_estimated(form):
    """Where the plant is known and the clock is not."""
    sensor = {**SIMULATION["sensor"], "latency": "estimate", "offset": 0.0}
    found = camid.identify(two_rates(), {**SIMULATION, "plant": FIXED[form], "sensor": sensor}).simulation
    assert abs(found.latency - 0.004) < 3.5 * found.latency_deviation < 5e-4


@pytest.mark.parametrize("command", [camid.identify, camid.diagnose])
def test_validation_rows_that_leave_nothing_to_fit_are_refused(command):
    with pytest.raises(InputError, match="the validation rows, -1 s to 100 s, leave no row to fit"):
        command(two_rates(), {**SIMULATION, "validation": {"start": -1.0, "end": 100.0}})


def test_orders_are_not_compared_over_two_clocks():
    """The table of regressions would have to take the mean input of a frame for the input."""
    with pytest.raises(InputError, match="order takes frames and input for samples of one clock"):
        camid.select_order(two_rates(), SIMULATION)


@pytest.mark.slow
def test_the_next_experiment_after_frames_with_times_of_their_own():
    sensor = {**SIMULATION["sensor"], "latency": "estimate", "skew": "estimate"}
    found = camid.identify(two_rates(), {**SIMULATION, "sensor": sensor, "initial_state": "estimate"}).simulation
    designed = camid.design(found, recording=two_rates(), duration=3.0, time_limit=None)
    assert len(designed.played.signal) == pytest.approx(3.0 * 47.3, abs=2)
