"""First guesses of a sinusoidal force where a controller answers it."""

from types import SimpleNamespace

import numpy as np
import pytest

from camid.effects.disturbance import PHASES, SMALL, PeriodicDisturbance

PERIOD, COUNT, FREQUENCY = 0.01, 1000, 40.0


def test_in_a_loop_any_phase_is_tried_small():
    time = PERIOD * np.arange(COUNT)
    situation = SimpleNamespace(
        time=time,
        residual=0.3 * np.sin(FREQUENCY * time),
        acquisition=SimpleNamespace(period=PERIOD),
        command=np.ones(COUNT),
        largest=lambda name: {"command": 2.5}[name],
    )
    guesses = list(PeriodicDisturbance.candidates(situation))
    nearest = guesses[: len(PHASES)]
    assert [g.values["phase"] for g in nearest] == list(PHASES)
    assert all(g.values["frequency"] == pytest.approx(FREQUENCY, rel=0.01) for g in nearest)
    assert all(g.values["amplitude"] == SMALL * 2.5 for g in guesses)
