"""First guesses of forces where a controller answers them: what is compared is what it puts out."""

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.chain.controller import Controller
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction
from camid.effects.disturbance import ImpulseDisturbance, PeriodicDisturbance, StepDisturbance
from camid.effects.situation import Situation

PERIOD, COUNT = 0.01, 2000
TIME = PERIOD * np.arange(COUNT)
SERVO = TransferFunction((3.7,), (1.0, 2.5, 0.0))
CONTROLLER = Controller("r", position_gain=5.7, velocity_gain=4.0)


def situation(force):
    """A loop in which a force, shape (N,), acts at the plant's input, and what the control adds for it."""
    answer, acquisition = CONTROLLER.answer_to_force(SERVO), Acquisition(PERIOD, sensor="instant")
    rest, rows = np.zeros(COUNT), np.ones(COUNT, bool)
    residual = sample(answer, force, acquisition)
    command = np.ones(COUNT)
    return Situation(
        TIME, command, rest, rest, rest, residual, SERVO, acquisition, rows, controlled=True, answer=answer
    )


def test_the_control_makes_up_for_a_constant_force():
    answer = CONTROLLER.answer_to_force(SERVO)
    assert answer.static_gain() == pytest.approx(-1.0)
    poles = sorted(answer.poles().real)
    np.testing.assert_allclose(poles, sorted(np.roots([1.0, 2.5 + 3.7 * 4.0, 3.7 * 4.0 * 5.7]).real))


@pytest.mark.parametrize(
    ("law", "force"),
    [
        (ImpulseDisturbance, np.where(np.arange(COUNT) == 1256, 500.0, 0.0)),
        (StepDisturbance, np.where(np.arange(COUNT) >= 1256, 5.0, 0.0)),
    ],
)
def test_the_time_at_which_a_force_sets_in_is_guessed(law, force):
    times = [guess.values["time"] for guess in law.candidates(situation(force))]
    assert abs(times[0] - TIME[1256]) <= PERIOD


def test_amplitude_and_phase_of_a_sinusoidal_force_are_guessed():
    force = 2.0 * np.sin(8.0 * TIME + 0.7)
    best = next(iter(PeriodicDisturbance.candidates(situation(force))))
    assert best.values["frequency"] == pytest.approx(8.0, rel=0.02)
    assert best.values["amplitude"] == pytest.approx(2.0, rel=0.1)
    at_the_middle = best.values["frequency"] * TIME[COUNT // 2] + best.values["phase"]
    assert np.cos(at_the_middle - 8.0 * TIME[COUNT // 2] - 0.7) > 0.9
