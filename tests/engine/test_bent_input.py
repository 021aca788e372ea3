"""An actuator bends its command anywhere in a step of the integrator: lines with the moments of the bent command."""

from dataclasses import replace

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects import known_effects
from camid.engine.input import MOST_PARTS, grid_input, parts_in_a_period
from camid.engine.mechanics import Chain
from camid.engine.run import run, steps_of

PERIOD, COUNT = 0.02, 400
PLANT = TransferFunction((100.0,), (1.0, 2.0, 100.0))
FIRST = TransferFunction((5.0,), (1.0, 5.0))


def effect(identifier, *keys, **values):
    return known_effects()[identifier].with_keys(keys)(**values)


def command():
    random = np.random.default_rng(np.random.SeedSequence((3, 1)))
    return np.convolve(random.standard_normal(COUNT), np.ones(4) / 2.0, "same")


def moments(start, end, steps):
    """Mean and first moment about the middle of so many equal steps, of lines, by their ends; each (steps,)."""
    parts = len(start) // steps
    share = (np.arange(64 * parts) + 0.5) / 64 % 1.0
    fine = np.repeat(start, 64) + np.tile(share[:64], len(start)) * np.repeat(end - start, 64)
    fine = fine.reshape(steps, -1)
    about = (np.arange(fine.shape[1]) + 0.5) / fine.shape[1] - 0.5
    return fine.mean(axis=1), (fine * about).mean(axis=1)


@pytest.mark.parametrize("hold", ["zoh", "foh"])
@pytest.mark.parametrize("steps", [1, 4])
def test_lines_in_steps_have_the_moments_of_the_bent_command(hold, steps):
    effects, acquisition = [effect("rate-limit", rate=30.0)], Acquisition(PERIOD, hold=hold)
    coarse = grid_input(effects, command(), acquisition, 0, steps, parts=48)
    fine = grid_input(effects, command(), acquisition, 0, 48)
    for found, expected in zip(moments(*coarse, len(coarse[0])), moments(*fine, len(coarse[0])), strict=True):
        assert np.allclose(found, expected, atol=1e-3 * np.std(command()))
    assert not np.allclose(coarse[1], coarse[0])


def test_a_command_that_stays_held_is_not_divided():
    acquisition = Acquisition(PERIOD)
    assert parts_in_a_period([effect("saturation", limit=1.0)], acquisition, PLANT) == 1
    assert parts_in_a_period([], Acquisition(PERIOD, hold="foh"), PLANT) == 1
    assert parts_in_a_period([effect("saturation", limit=1.0)], Acquisition(PERIOD, hold="foh"), PLANT) > 1


def test_a_plant_of_any_speed_needs_no_more_memory():
    """A fit may come by a pole of 10⁹ rad/s, whose motion no frame shows."""
    fast = TransferFunction((1e9,), (1.0, 1e9))
    assert parts_in_a_period([effect("rate-limit", rate=30.0)], Acquisition(PERIOD), fast) == MOST_PARTS


@pytest.mark.parametrize("plant", [PLANT, FIRST])
@pytest.mark.parametrize(
    "beside", [[], [effect("coulomb-friction", force=0.2)], [effect("quadratic-drag", coefficient=0.1)]]
)
def test_few_steps_say_the_same_as_many(plant, beside):
    """The output of a rate limit, beside forces, with the steps that are taken and with the finest."""
    time = PERIOD * np.arange(COUNT)
    chain = Chain(plant, Acquisition(PERIOD), (effect("rate-limit", rate=20.0), *beside))
    fine = run(replace(chain, steps=400), command(), time)
    assert np.max(np.abs(run(chain, command(), time) - fine)) < 2e-4 * np.std(fine)


def test_a_fast_mode_costs_no_steps_where_nothing_jumps():
    """A step without events is exact for linear dynamics of any speed, and a Runge-Kutta step is not."""
    signal, time = command(), PERIOD * np.arange(COUNT)
    fast = effect("extra-mode", natural_frequency=1e5, damping=1.0)

    def steps(*effects):
        return steps_of(Chain(PLANT, Acquisition(PERIOD), effects), signal, time, finest=False)

    smooth, dry = effect("cubic-stiffness", coefficient=0.5), effect("coulomb-friction", force=0.1)
    assert steps(smooth, fast) == steps(smooth)
    assert steps(dry, fast) > 10 * steps(dry)
    without = run(Chain(PLANT, Acquisition(PERIOD), (smooth,)), signal, time)
    beside = run(Chain(PLANT, Acquisition(PERIOD), (smooth, fast)), signal, time)
    # It delays by 2/ω, and does nothing else to such a motion.
    assert np.max(np.abs(beside - without)) < 5e-3 * np.std(without)
