"""Fit a plant whose phases add up, such as a pendulum, over a horizon that grows.

An error of the natural frequency turns into a phase that grows with the time, and beyond half a period the sum of
squares has other minima: the fit starts with the first part of each recording and adds more of it as long as it
follows.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.chain.companion_form import time_scale
from camid.fitting.fit import Fitted, fit
from camid.fitting.initial_motion import recorded_start
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem

Array = NDArray[np.float64]

# The first horizon in time constants 1/ω of the plant, in rows a free number at least, and by how much it grows.
FIRST_HORIZON = 15.0
ROWS_PER_UNKNOWN = 20
GROWTH = 1.6
# The least horizon, in time constants, of a model that follows for a while already.
LEAST_HORIZON = 5.0
# Largest number of evaluations for each horizon.
STEPS = 60
# Error, as a share of the output's spread, from which a model no longer follows; how often one that follows a part is
# fitted to it, and the evaluations for that.
ASTRAY, MOST_EXTENSIONS, STEPS_WHILE_IT_FOLLOWS = 0.1, 6, (8, 30)


def fit_growing(problem: Problem, start: Model, steps: int = STEPS) -> Fitted:
    """Least squares over a horizon that grows to the whole of the recordings.

    Parameters
    ----------
    problem : Problem
    start : Model
        Its initial states are taken from the recordings where it has none.
    steps : int
        Largest number of evaluations for each horizon.
    """
    if not start.initial:
        start = recorded_start(problem, start)
    longest = max(len(t) for t in problem.times)
    starts = [start, *problem.kind.starts_from_regression(problem, start)]
    rows = [first_horizon(problem, s) for s in starts]
    first = [fit(problem.start_of(r), s, steps=steps, finest=False) for r, s in zip(rows, starts, strict=True)]
    best = int(np.argmin([f.cost / len(f.residual) for f in first]))
    model, horizon = first[best].model, int(GROWTH * rows[best])
    while horizon < longest:
        model = fit(problem.start_of(horizon), model, steps=steps, finest=False).model
        horizon = int(GROWTH * horizon)
    return fit(problem, model, steps=steps)


def first_horizon(problem: Problem, start: Model, time_constants: float = FIRST_HORIZON) -> int:
    """Rows, of so many time constants, over which a model follows well enough for a fit to start there."""
    constant = time_scale((1.0, *start.coefficients[problem.structure.degree + 1 :]))
    numbers = len(start.coefficients) + sum(len(s) for s in start.initial if s is not None) + 1
    begin = max(int(np.argmax(e.used)) for e in problem.experiments)  # rows before it say nothing
    return begin + max(int(time_constants * constant / problem.acquisition.period), ROWS_PER_UNKNOWN * numbers)


def fitted_as_far_as_it_follows(problem: Problem, start: Model) -> Model:
    """A model that follows the recordings for a while, fitted to that part, and to more of them the longer it follows.

    A body that may come to rest in many places ends in another one for the least error, and from there on a simulation
    says nothing. Up to there it may say all.

    Parameters
    ----------
    problem : Problem
    start : Model
        Returned as it is where it follows for too short a while, or all the way.
    """
    model, horizon = start, rows_followed(problem, start)
    if horizon <= first_horizon(problem, start, LEAST_HORIZON):
        return start
    longest = max(len(t) for t in problem.times)
    for _ in range(MOST_EXTENSIONS):
        if horizon >= longest:
            break
        # A short part says little of some numbers, and a fit to the end would take them anywhere.
        for steps in STEPS_WHILE_IT_FOLLOWS:
            fitted = fit(problem.start_of(horizon), model, steps=steps, finest=False).model
            follows = rows_followed(problem, fitted)
            if follows > horizon:
                break
        else:
            return model
        model, horizon = fitted, follows
    return model


def rows_followed(problem: Problem, model: Model) -> int:
    """Rows that a model follows in every recording."""
    rows = []
    for simulated, experiment in zip(problem.simulate(model), problem.experiments, strict=True):
        error = np.where(experiment.used, np.abs(simulated - experiment.output), 0.0)
        lost = np.flatnonzero(~(error < ASTRAY * problem.output_spread))
        rows.append(int(lost[0]) if len(lost) else len(error))
    return min(rows)
