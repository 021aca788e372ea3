"""Derivatives of the simulated output by a law's heights, with all that a fit adds to a chain."""

import numpy as np
import pytest

from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.fitting.law_columns import by_differences, law_columns
from camid.fitting.possible_laws import blank_laws
from camid.identification.from_recordings import experiments_of
from camid.simulation.file import load_simulation
from tests.support.mass_on_spring import effect, record, simulation

SIZE = 1e-4


def refitted(*effects):
    """Problem of a recording, and the plant re-estimated without the effects."""
    believed = load_simulation(simulation(sensor={"column": "y", "kind": "camera", "offset": 0.0}))
    signal = np.repeat(np.random.default_rng(2).uniform(-1.5, 1.5, 50), 8)
    recordings, experiments, _ = experiments_of([record(*effects, count=400, signal=signal)], believed, None)
    problem = problem_of(believed, structure_of(believed), recordings, experiments)
    return problem, problem.kind.refit(problem, problem.with_initial_states(model_of(problem, [])))


def columns_of(name, directions):
    """Columns for a law of this name, and those of differences."""
    problem, fitted = refitted(effect("cubic-stiffness", coefficient=0.02))
    model = fitted.model.plus(blank_laws(problem, fitted)[name])
    pinned = problem.pinned(model, finest=True)
    rest = (pinned, model, len(model.effects) - 1, directions, SIZE, pinned.simulate_fitted(model))
    return law_columns(*rest), by_differences(*rest)


@pytest.mark.parametrize("name", ["position", "velocity", "damping over position", "gain over position", "reading"])
def test_one_run_says_what_differences_do(name):
    found, expected = columns_of(name, np.eye(17))
    lengths = np.linalg.norm(expected, axis=0)
    assert np.all(np.linalg.norm(found - expected, axis=0) <= 2e-3 * np.maximum(lengths, 0.1 * np.max(lengths)))


def test_directions_that_act_everywhere_are_sums_of_single_heights():
    directions = np.linalg.qr(np.random.default_rng(3).normal(size=(17, 9)))[0]
    found, expected = columns_of("velocity", directions)
    assert np.max(np.abs(found - expected)) <= 2e-3 * np.max(np.abs(expected))


def test_a_curve_of_the_actuator_is_left_to_differences():
    found, expected = columns_of("input", np.eye(17))
    assert np.array_equal(found, expected)
