"""Fit a plant that is no linear chain behind a recorded input: a pendulum, or a plant in a closed loop.

The exact path of identification does not hold there. An error of the natural frequency turns into a phase that grows
with the time, and beyond half a period the sum of squares has other minima: the fit begins with the first part of each
recording and takes in more of it as long as it follows (the horizon grows).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.exact import time_scale
from camid.fitting.fit import Fitted, fit
from camid.fitting.initial_motion import FEWEST_SMOOTHED, MOST_SMOOTHED, SMOOTHED, recorded_start
from camid.fitting.problem import Model, Problem

Array = NDArray[np.float64]

# The first horizon in time constants 1/ω of the plant, in rows a free number at least, and by how much it grows.
FIRST_HORIZON = 15.0
ROWS_A_NUMBER = 20
GROWTH = 1.6


def fit_growing(problem: Problem, start: Model, steps: int = 60) -> Fitted:
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
    if problem.closed:  # the controller keeps the simulation near the recording, however long that is
        return fit(problem, start, steps=steps)
    numbers = len(start.coefficients) + sum(len(s) for s in start.initial if s is not None) + 1
    longest = max(len(t) for t in problem.times)
    starts = [start, *_from_regression(problem, start)]
    rows = [max(_horizon(problem, s), ROWS_A_NUMBER * numbers) for s in starts]
    first = [fit(problem.beginning(r), s, steps=steps, finest=False) for r, s in zip(rows, starts, strict=True)]
    best = int(np.argmin([f.cost / len(f.residual) for f in first]))
    model, horizon = first[best].model, int(GROWTH * rows[best])
    while horizon < longest:
        model = fit(problem.beginning(horizon), model, steps=steps, finest=False).model
        horizon = int(GROWTH * horizon)
    return fit(problem, model, steps=steps)


def _horizon(problem: Problem, model: Model) -> int:
    """Rows of the first horizon."""
    constant = time_scale((1.0, *model.coefficients[problem.structure.degree + 1 :]))
    return int(FIRST_HORIZON * constant / problem.acquisition.period)


def _from_regression(problem: Problem, model: Model) -> list[Model]:
    """A pendulum from the linear regression ÿ = -a_1 ẏ - a_2 (sin y cos r - cos y sin r) + b_0 u, none where it fails.

    A believed frequency that is a tenth too low lets a pendulum that swings far turn over, from where no fit returns;
    smoothed derivatives need no simulation and no start. What is not free keeps its value.
    """
    from scipy.signal import savgol_filter

    if model.rest is None:
        return []
    constant = time_scale((1.0, *model.coefficients[problem.structure.degree + 1 :]))
    tables, accelerations = [], []
    for experiment in problem.experiments:
        period = experiment.acquisition.period
        half = int(np.clip(SMOOTHED * constant / period, FEWEST_SMOOTHED, MOST_SMOOTHED)) // 2
        window = 2 * half + 1
        smooth, velocity, acceleration = (
            savgol_filter(experiment.output, window, min(4, window - 1), derivative, period) for derivative in range(3)
        )
        tables.append(np.column_stack([-velocity, -np.sin(smooth), np.cos(smooth), experiment.signal]))
        accelerations.append(acceleration)
    table, acceleration = np.concatenate(tables), np.concatenate(accelerations)
    driven = bool(np.any(table[:, 3])) and bool(problem.structure.free_numerator[0])
    solution = np.linalg.lstsq(table if driven else table[:, :3], acceleration, rcond=None)[0]
    square = float(np.hypot(solution[1], solution[2]))
    if not np.isfinite(square) or square <= 0.0:
        return []
    coefficients = model.coefficients.copy()
    found = np.array([solution[3] if driven else coefficients[0], max(solution[0], 0.0), square])
    free = problem.structure.free
    coefficients[free] = found[free]
    if problem.fixed_gain is not None:
        coefficients[0] = problem.fixed_gain * coefficients[-1]
    rest = model.rest
    if problem.rest_free:
        angle = float(np.arctan2(solution[2], solution[1]))
        rest = angle + 2.0 * np.pi * round((model.rest - angle) / (2.0 * np.pi))
    return [recorded_start(problem, replace(model, coefficients=coefficients, rest=rest))]
