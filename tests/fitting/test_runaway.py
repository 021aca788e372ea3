"""A simulation that runs away has derivatives and a noise that are finite, whatever the motion does."""

import numpy as np

from camid.fitting.from_simulation import problem_of, structure_of
from camid.fitting.output_error import LARGEST_DERIVATIVE, OutputError
from camid.identification.from_recordings import experiments_of
from camid.simulation.file import load_simulation
from tests.support.mass_on_spring import record, simulation


class _Derivative:
    def at(self, vector, simulated):
        return np.array([[np.inf, 1e300, -2.0], [np.nan, 1.0, 3.0]])


class _Problem:
    output_spread = 1.0

    def whitened(self, table, whitening):
        return table


def test_derivatives_of_a_motion_that_runs_away_are_zero():
    error = OutputError.__new__(OutputError)
    error.problem, error.whitening, error.derivative = _Problem(), np.ones(1), _Derivative()
    error.first_rows = None
    error.simulated = lambda vector: np.zeros(2)
    assert np.array_equal(error.jacobian(np.zeros(3)), [[0.0, 0.0, 2.0], [0.0, -1.0, -3.0]])
    assert np.linalg.norm(np.full((100_000, 1), LARGEST_DERIVATIVE)) < 1e100


def test_a_residual_of_any_size_has_a_noise():
    """A model without an effect may run away so far that the square of what it leaves is no number."""
    file = load_simulation(simulation())
    recordings, experiments, _ = experiments_of([record()], file, None)
    problem = problem_of(file, structure_of(file), recordings, experiments)
    noise = problem.noise(1e200 * np.random.default_rng(5).standard_normal(len(problem.output)), 3)
    assert np.isfinite(noise.deviance)
