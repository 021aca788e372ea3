"""The first rows of a recording that begins in motion, which are not fitted, as what says how that motion began.

What the input did before the record is unknown, so that the first rows take no part in any comparison. What of the
motion has faded when the fitted rows begin these say nothing of, and least squares makes anything of it: a body that
seems to come from a thousand spreads away, past all that depends on where it is. The first rows show it well enough.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem

Array = NDArray[np.float64]

# Logarithm by which the fastest motion of the plant has faded when the fitted rows begin, from which they say too
# little of it, and first rows that show it.
FADED, MOST_ROWS = 5.0, 50
# Error of a first row, as a share of the output's spread, that what was before the record may make; and by how much at
# least it weighs less than a fitted one.
UNKNOWN_SHARE, LARGEST_WEIGHT = 0.1, 0.3


@dataclass(frozen=True)
class FirstRows:
    """A problem whose fitted rows are more than those that are compared.

    Attributes
    ----------
    problem : Problem
        With the first rows as well.
    alone : Problem
        With the first rows alone.
    compared : ndarray of bool, shape (M + e,)
        Which rows of the problem are those that are compared.
    """

    problem: Problem
    alone: Problem
    compared: NDArray[np.bool_]

    @classmethod
    def of(cls, problem: Problem, model: Model) -> FirstRows | None:
        """The first rows where the fitted ones say too little of how a model's motion began; else None."""
        first = [_first_rows(problem, model, index) for index in range(len(problem.experiments))]
        if problem.own_zeros or not any(rows.any() for rows in first):
            return None
        used = [e.used for e in problem.experiments]
        both = [u | rows for u, rows in zip(used, first, strict=True)]
        compared = np.concatenate([u[rows] for u, rows in zip(used, both, strict=True)])
        return cls(problem.with_used(both), problem.with_used(first), compared)

    def stepped_as(self, problem: Problem) -> FirstRows:
        """The same with the integrator's steps of another problem."""
        used = [[e.used for e in each.experiments] for each in (self.problem, self.alone)]
        return FirstRows(problem.with_used(used[0]), problem.with_used(used[1]), self.compared)

    def weight(self, residual: Array) -> float:
        """What a first row counts for beside fitted ones that leave such a residual, shape (M,)."""
        return self.weight_beside(float(np.sqrt(np.mean(residual**2))))

    def weight_beside(self, deviation: float) -> float:
        """The same where these leave such a root mean square."""
        return min(deviation / (UNKNOWN_SHARE * (float(np.std(self.problem.output)) or 1.0)), LARGEST_WEIGHT)


def _first_rows(problem: Problem, model: Model, index: int) -> NDArray[np.bool_]:
    """Those of one recording, shape (N,); none where the fitted ones say how its motion began."""
    experiment = problem.experiments[index]
    rows = np.zeros(len(experiment.used), bool)
    if not experiment.estimate_initial_state or not experiment.used.any():
        return rows
    begin = experiment.acquisition.window()[0]
    end = int(np.argmax(experiment.used))
    poles = problem.structure.plant(model.coefficients).poles()
    fastest = float(np.max(-poles.real, initial=0.0))
    if fastest * end * problem.acquisition.period <= FADED:
        return rows
    rows[begin : min(end, begin + MOST_ROWS)] = True
    return rows & np.isfinite(experiment.output)
