"""A fit whose simulation runs away has derivatives that are finite, whatever the motion does."""

import numpy as np

from camid.fitting.output_error import LARGEST_DERIVATIVE, OutputError


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
