"""Fits to parts of recordings that each begin with a state of their own."""

from dataclasses import replace

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.friction import CoulombFriction, StribeckFriction
from camid.fitting.fit import evaluate, fit
from camid.fitting.initial_motion import recorded_start
from camid.fitting.multiple_shooting import in_parts, may_be_cut, shot_several_times
from camid.fitting.output_error import DIFFERENCE_STEP, sensitivities
from camid.fitting.packing import Packing
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.linear import LinearPlant
from camid.fitting.problem import Problem
from camid.identification.experiment import Experiment
from camid.identification.structure import Structure

PERIOD, ROWS, NOISE = 0.02, 2000, 0.002
GAIN, RATE = 1.2, 1.3
LEVEL, BREAKAWAY, SPEED = 0.35, 0.7, 0.1


@pytest.fixture(scope="module")
def axis():
    """Time, command and position of an axis with friction, in a loop, by an integrator of its own."""
    generator = np.random.default_rng(7)
    wanted = np.repeat(generator.uniform(-1.5, 1.5, ROWS // 125), 125)
    fine, position, velocity = 100, 0.0, 0.0
    command, seen = np.zeros(ROWS), np.zeros(ROWS)
    for k, goal in enumerate(wanted):
        seen[k] = position
        command[k] = np.clip(8.0 * (goal - position) - 4.0 * velocity, -5.0, 5.0)
        for _ in range(fine):
            level = LEVEL + (BREAKAWAY - LEVEL) * np.exp(-((velocity / SPEED) ** 2))
            velocity += PERIOD / fine * (GAIN * (command[k] - level * np.tanh(velocity / 5e-4)) - RATE * velocity)
            position += PERIOD / fine * velocity
    return PERIOD * np.arange(ROWS), command, seen + NOISE * generator.normal(size=ROWS)


def problem_of(axis, parts=1, **options):
    """Recordings of the axis, one after the other, as a problem with the plant as it is."""
    time, command, position = axis
    structure = replace(
        Structure.fixed(TransferFunction((GAIN,), (1.0, RATE, 0.0))),
        free_numerator=np.array([True]),
        free_denominator=np.array([False, True, False]),
    )
    pieces = np.array_split(np.arange(ROWS), parts)
    acquisition = Acquisition(PERIOD, sensor="instant")
    experiments = [
        Experiment(command[p], position[p], acquisition, np.ones(len(p), bool), True, **options) for p in pieces
    ]
    kind = LinearPlant().with_unknown(experiments)
    return Problem(structure, experiments, [time[p] for p in pieces], kind, 1.0)


def test_parts_hold_every_fitted_row_once_and_shorter_recordings_are_cut_into_fewer(axis):
    problem = problem_of(axis, 2)
    used = [np.arange(1000) < 900, np.arange(1000) < 225]
    problem = problem.with_used(used)
    cut = in_parts(problem, 4)
    assert [len(t) for t in cut.times] == [225, 225, 225, 225, 225]
    np.testing.assert_array_equal(
        np.concatenate(cut.times), np.concatenate([problem.times[0][:900], problem.times[1][:225]])
    )
    np.testing.assert_array_equal(cut.recorded, problem.recorded)


def test_a_plant_that_integrates_keeps_the_zero_that_its_states_count_from(axis):
    problem = problem_of(axis, estimate_offset=True, estimate_bias=True)
    assert [c.name for c in problem.kind.free_constants()] == ["offset", "bias"]
    assert [c.name for c in in_parts(problem, 4).kind.free_constants()] == ["bias"]


def test_initial_states_of_all_runs_are_differentiated_by_one_simulation_each(axis):
    problem = problem_of(axis, 5).pinned(Model(np.array([GAIN, RATE, 0.0])), finest=False)
    friction = StribeckFriction(coulomb=LEVEL, breakaway=BREAKAWAY, velocity=SPEED)
    model = recorded_start(problem, Model(np.array([GAIN, RATE, 0.0]), (friction,)))
    packing = Packing.of(problem, model)
    groups = packing.moved_together(range(len(packing.names)))
    assert [len(group) for group in groups] == [1] * 5 + [5, 5]
    vector = packing.pack(model)
    simulated = problem.simulate_fitted(model)
    found = sensitivities(problem, packing, vector, simulated)
    for column in range(len(vector)):
        moved = vector.copy()
        moved[column] += DIFFERENCE_STEP
        alone = (problem.simulate_fitted(packing.unpack(moved)) - simulated) / DIFFERENCE_STEP
        np.testing.assert_allclose(found[:, column], alone, atol=1e-9 * np.max(np.abs(alone)))


@pytest.mark.parametrize(("friction", "gain", "rate"), [((0.6, 0.65, 0.05), 0.8, 0.6), ((0.2, 0.9, 0.3), 1.3, 0.5)])
def test_friction_that_sticks_is_found_from_where_a_fit_of_the_whole_is_caught(axis, friction, gain, rate):
    problem = problem_of(axis)
    assert may_be_cut(problem)
    wrong = StribeckFriction(**dict(zip(("coulomb", "breakaway", "velocity"), friction, strict=True)))
    start = recorded_start(problem, Model(np.array([gain * GAIN, rate * RATE, 0.0]), (wrong,)))
    caught = fit(problem, start, steps=30)
    found = fit(problem, shot_several_times(problem, start), steps=30)
    assert np.sqrt(caught.cost / ROWS) > 3.0 * NOISE
    assert np.sqrt(found.cost / ROWS) < 1.2 * NOISE
    values = found.model.effects[0].values
    assert values["coulomb"] == pytest.approx(LEVEL, rel=0.02)
    assert values["breakaway"] == pytest.approx(BREAKAWAY, rel=0.02)


def test_what_no_fit_makes_better_is_returned_as_it_is(axis):
    problem = problem_of(axis)
    start = recorded_start(problem, Model(np.array([GAIN, RATE, 0.0]), (CoulombFriction(force=0.0),)))
    found = shot_several_times(problem, start)
    assert evaluate(problem, found).cost <= evaluate(problem, start).cost
