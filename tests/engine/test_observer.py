"""An observer compares frames: a true model is not pulled, and from another start it comes to the recording."""

from dataclasses import replace

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.chain.observer import Observer, Pull
from camid.chain.plant import TransferFunction
from camid.effects.periodic_in_position import Cogging
from camid.engine.mechanics import Chain
from camid.engine.run import run

PERIOD, ROWS, GAIN = 0.004, 1500, 8.0
PLANT = TransferFunction((GAIN,), (1.0, 5.0, 0.0))
FALLING = TransferFunction((GAIN,), (1.0, 0.5, -22.0))
COGGING = Cogging(amplitude=0.3, period=0.035, phase=0.3)
SENSORS = {
    "instant": Acquisition(PERIOD, sensor="instant"),
    "part of a period": Acquisition(PERIOD, sensor="camera", exposure=0.002),
    "whole period": Acquisition(PERIOD, sensor="camera", exposure=PERIOD),
    "late": Acquisition(PERIOD, sensor="camera", exposure=0.003, latency=0.009),
    "instant and late": Acquisition(PERIOD, sensor="instant", latency=0.003),
}
TIME = PERIOD * np.arange(ROWS)
COMMAND = np.repeat(np.random.default_rng(1).choice([-1.0, -0.5, 0.5, 1.0], ROWS // 50), 50)


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_true_model_is_not_pulled_and_another_start_is_forgotten(sensor):
    acquisition = SENSORS[sensor]
    chain = Chain(PLANT, acquisition, (COGGING,))
    recorded = run(chain, COMMAND, TIME)
    held = replace(chain, pull=Pull(Observer(25.0, GAIN), recorded, acquisition))
    assert run(held, COMMAND, TIME) == pytest.approx(recorded, abs=1e-7 * np.std(recorded))
    elsewhere = replace(held, initial_state=np.array([0.5, 0.003]), state_before_record=False)
    apart = np.abs(run(elsewhere, COMMAND, TIME) - recorded)
    assert np.max(apart[:50]) > 0.01 * np.std(recorded)
    assert np.max(apart[500:]) < 1e-6 * np.std(recorded)


def test_a_plant_that_falls_stays_near_the_recording():
    acquisition = SENSORS["part of a period"]
    swinging = 0.1 * np.sin(3.0 * TIME)
    # What holds it there is its input; the frames lag by half their exposure.
    force = (-9.0 * swinging + 0.5 * 0.3 * np.cos(3.0 * TIME) - 22.0 * swinging) / GAIN
    recorded = 0.1 * np.sin(3.0 * (TIME - 0.001))
    alone = run(Chain(FALLING, acquisition, steps=20), force, TIME)
    held = run(Chain(FALLING, acquisition, pull=Pull(Observer(10.0, GAIN), recorded, acquisition)), force, TIME)
    assert not np.max(np.abs(alone - recorded)) < 1.0
    assert np.max(np.abs(held - recorded)[400:]) < 0.003


def test_frames_that_are_none_pull_nowhere():
    acquisition = SENSORS["instant"]
    chain = Chain(PLANT, acquisition, (COGGING,))
    nothing = Pull(Observer(25.0, GAIN), np.full(ROWS, np.nan), acquisition)
    assert run(replace(chain, pull=nothing), COMMAND, TIME) == pytest.approx(run(chain, COMMAND, TIME), abs=1e-9)


def test_the_pull_acts_behind_the_actuators():
    """A command that its saturation leaves nothing of would take the pull with it."""
    from camid.effects.actuator import Saturation

    acquisition = SENSORS["instant"]
    recorded = 0.05 * np.sin(5.0 * TIME)
    chain = Chain(PLANT, acquisition, (Saturation(limit=1e-6),), pull=Pull(Observer(25.0, GAIN), recorded, acquisition))
    followed = run(chain, COMMAND, TIME)
    assert np.corrcoef(followed[300:], recorded[300:])[0, 1] > 0.95


def test_what_a_force_does_to_a_pulled_plant():
    observer = Observer(30.0, GAIN)
    answer = observer.answer_to_force(TransferFunction((GAIN,), (1.0, 0.0, 0.0)))
    assert np.roots(answer.denominator) == pytest.approx([-30.0, -30.0], rel=1e-6)
    assert observer.holds(FALLING)
    assert not Observer(1.0, GAIN).holds(FALLING)
