"""A formula fitted to the recording itself: its numbers, the plant's coefficients and all else together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.effects.learned import LearnedEffect
from camid.fitting.fit import Fitted, evaluate, sensitivities
from camid.fitting.linearised_law import Absorbed, on_points
from camid.fitting.packing import Packing
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem

Array = NDArray[np.float64]

# Points that carry a formula through the engine, how far beyond the range they go, as a share of it, and how near to
# zero, where a root is steep and a sign jumps, there are more.
POINTS = 321
BEYOND = 0.1
NEAR_ZERO = np.geomspace(2e-3, 2e-2, 6)
# Evaluations of a fit, the fall of the sum of squares that ends it, and the step of the differences.
MOST_STEPS = 20
SETTLED = 1e-6
DIFFERENCE = 1e-5
# Residual of a simulation that diverged.
RUNAWAY = 1e12


@dataclass(frozen=True)
class FormulaFit:
    """A formula in the place of a learned law.

    Attributes
    ----------
    fitted : Fitted
        The formula is the last effect of its model, on many points.
    vector : ndarray, shape (q,)
        The formula's numbers.
    covariance : ndarray, shape (q, q)
    derivatives : ndarray, shape (M, q)
        Of the simulated output by them.
    """

    fitted: Fitted
    vector: Array
    covariance: Array
    derivatives: Array

    def criterion_beyond(self, other: FormulaFit) -> float:
        """By how much Bayes's criterion exceeds that of another formula; see :meth:`Fitted.criterion_beyond`."""
        more = len(self.vector) - len(other.vector)
        return self.fitted.criterion_beyond(other.fitted) + more * float(np.log(len(self.fitted.residual)))


def points_about(grid: Array) -> Array:
    """Where a formula is given to the engine."""
    low, high = float(grid[0]), float(grid[-1])
    margin = BEYOND * (high - low)
    points = np.linspace(low - margin, high + margin, POINTS)
    if not low < 0.0 < high:
        return points
    close = (high - low) * NEAR_ZERO
    apart = points[np.abs(points) > 1.2 * close[-1]]
    return np.sort(np.concatenate([apart, -close, [0.0], close]))


def fit_formula(
    problem: Problem,
    start: Model,
    law: LearnedEffect,
    absorbed: Absorbed,
    values: Callable[[Array, Array], Array],
    vector: Array,
    bounds: tuple[Array, Array],
) -> FormulaFit:
    """Least squares of a formula and all that is fitted beside it, through the whole chain.

    Parameters
    ----------
    problem : Problem
    start : Model
        All that is beside the formula.
    law : LearnedEffect
        The kind of law.
    absorbed : Absorbed
        What the coefficients hold of it.
    values : callable
        The formula at some points, shape (N,), with a vector of its numbers, shape (q,).
    vector, bounds
        The numbers that the fit starts from, and what they may be.

    Raises
    ------
    ValueError
        If the chain diverges with the formula.
    """
    from scipy.optimize import least_squares

    points = points_about(absorbed.grid)

    def effect(numbers: Array) -> LearnedEffect:
        held = absorbed.part_of(values(absorbed.grid, numbers))
        return on_points(law, points, values(points, numbers) - absorbed.functions(points) @ held)

    first = start.plus(effect(vector))
    pinned = problem.pinned(first, finest=True)
    packing = Packing.of(pinned, first)
    split = len(packing.names)

    def model(at: Array) -> Model:
        beside = packing.unpack(at[:split])
        return replace(beside, effects=(*beside.effects[:-1], effect(at[split:])))

    simulations: dict[bytes, Array] = {}

    def simulated(at: Array) -> Array:
        key = at.tobytes()
        if key not in simulations:
            try:
                rows = pinned.simulate_fitted(model(at))
            except (ValueError, ArithmeticError):
                rows = np.full(len(problem.output), RUNAWAY)
            simulations[key] = np.clip(np.nan_to_num(rows, nan=RUNAWAY), -RUNAWAY, RUNAWAY)
        return simulations[key]

    steps = DIFFERENCE * np.maximum(np.abs(vector), 1e-3 * float(np.max(np.abs(vector))))

    def derivative(at: Array) -> Array:
        here = simulated(at)
        moving = replace(packing, template=model(at))
        table = sensitivities(pinned, moving, at[:split], here)
        columns = []
        for i, step in enumerate(steps):
            moved = at.copy()
            moved[split + i] += step if at[split + i] + step <= bounds[1][i] else -step
            columns.append((simulated(moved) - here) / (moved[split + i] - at[split + i]))
        return -np.column_stack([table, *columns])

    begin = np.concatenate([np.clip(packing.pack(first), packing.lower, packing.upper), np.clip(vector, *bounds)])
    if np.max(np.abs(simulated(begin))) >= RUNAWAY:
        raise ValueError("the simulation diverges with this formula")

    def residual(at: Array) -> Array:
        return np.asarray(problem.output - simulated(at))

    found = least_squares(
        residual,
        begin,
        jac=derivative,
        bounds=(np.concatenate([packing.lower, bounds[0]]), np.concatenate([packing.upper, bounds[1]])),
        x_scale="jac",
        ftol=SETTLED,
        max_nfev=MOST_STEPS,
    )
    fitted = evaluate(problem, model(found.x))
    table = -derivative(found.x)
    covariance = _covariance(fitted, table)[split:, split:]
    return FormulaFit(replace(fitted, nuisance=None), found.x[split:], covariance, table[:, split:])


def _covariance(fitted: Fitted, table: Array) -> Array:
    """Of least squares, in coloured noise the sandwich (Ljung 1999, section 9.4); infinite where undetermined."""
    lengths = np.linalg.norm(table, axis=0)
    moving = lengths > 0.0
    scaled = table[:, moving] / lengths[moving]
    inverse = np.linalg.pinv(scaled.T @ scaled, rcond=1e-12)
    freedom = max(len(fitted.residual) - len(lengths), 1)
    if len(fitted.noise.whitening) == 1:
        inverse = inverse * fitted.cost / freedom
    else:
        from scipy.signal import lfilter

        innovations = fitted.problem.whitened(fitted.residual, fitted.noise.whitening)
        carried = lfilter([1.0], fitted.noise.whitening, scaled[::-1], axis=0)
        inverse = inverse @ (carried.T @ carried) @ inverse * float(innovations @ innovations) / freedom
    result = np.full((len(lengths), len(lengths)), np.inf)
    result[np.ix_(moving, moving)] = inverse / np.outer(lengths[moving], lengths[moving])
    return result
