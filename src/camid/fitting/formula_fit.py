"""A formula fitted to the recording itself: its numbers, the plant's coefficients and all else together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from camid.effects.learned import LearnedEffect
from camid.engine.work import Work
from camid.fitting.beginning import Beginning
from camid.fitting.fit import Fitted, evaluate
from camid.fitting.linearised_law import Absorbed, on_points
from camid.fitting.output_error import sensitivities
from camid.fitting.packing import Packing
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.fitting.updated_derivative import UpdatedDerivative
from camid.identification.autoregression import coloured

Array = NDArray[np.float64]

# Points that carry a formula through the engine, how far beyond the range they go, as a share of it, and how near to
# zero, where a root is steep and a sign jumps, there are more.
POINTS = 321
BEYOND = 0.1
NEAR_ZERO = np.geomspace(2e-3, 2e-2, 6)
# Evaluations of a fit, how often its derivatives are computed by differences, the fall of the sum of squares that ends
# it, and the step of the differences.
MOST_STEPS = 30
REFRESHES = 6
SETTLED = 1e-6
DIFFERENCE = 1e-5
# Residual of a simulation that diverged.
RUNAWAY = 1e12


class TooMuchWorkError(Exception):
    """A fit would take more simulation than there is left."""


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
    left: Array,
    most_work: float = np.inf,
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
    left : ndarray, shape (M,)
        What the learned law leaves, beside which an error of a simulation is negligible.
    most_work : float
        Work (:mod:`camid.engine.work`) that the fit may take, in seconds.

    Raises
    ------
    ValueError
        If the chain diverges with the formula.
    TooMuchWorkError
        If the fit would take more work, as it is judged by its first simulation.
    """
    from scipy.optimize import least_squares

    chain = _ChainWithFormula.of(problem, start, law, absorbed, values, vector, bounds, left)
    packing, split = chain.packing, len(chain.packing.names)
    begin = np.concatenate([packing.pack(chain.first), vector])
    begin = np.clip(begin, *chain.limits)
    work = chain.first_work(begin)
    if np.max(np.abs(chain.simulated(begin))) >= RUNAWAY:
        raise ValueError("the simulation diverges with this formula")
    if work * (MOST_STEPS + REFRESHES * len(begin)) > most_work:
        raise TooMuchWorkError("the fit of this formula would take too long")
    derivative = UpdatedDerivative(chain.derivatives, REFRESHES)
    beginning = Beginning.about(chain.pinned, packing, chain.first, left)
    by_first_rows = np.hstack([beginning.table, np.zeros((len(beginning.errors), len(vector)))])

    def residual(at: Array) -> Array:
        return np.concatenate([chain.residual(at), beginning.error(at[:split])])

    def jacobian(at: Array) -> Array:
        return -np.vstack([derivative.at(at, chain.simulated(at)), by_first_rows])

    found = least_squares(
        residual,
        begin,
        jac=jacobian,
        bounds=chain.limits,
        x_scale="jac",
        ftol=SETTLED,
        max_nfev=MOST_STEPS,
    )
    fitted = evaluate(chain.pinned, chain.model(found.x))
    table = chain.derivatives(found.x, chain.simulated(found.x))
    return FormulaFit(fitted, found.x[split:], _covariance(fitted, table)[split:, split:], table[:, split:])


@dataclass
class _ChainWithFormula:
    """The simulated output over the packed numbers and those of a formula behind them, one vector."""

    pinned: Problem
    first: Model
    packing: Packing
    law: LearnedEffect
    absorbed: Absorbed
    values: Callable[[Array, Array], Array]
    bounds: tuple[Array, Array]
    steps: Array
    known: dict[bytes, Array] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        problem: Problem,
        start: Model,
        law: LearnedEffect,
        absorbed: Absorbed,
        values: Callable[[Array, Array], Array],
        vector: Array,
        bounds: tuple[Array, Array],
        left: Array,
    ) -> _ChainWithFormula:
        """With the steps of the integrator that suit the formula's first numbers."""
        first = start.plus(_effect(law, absorbed, values, vector))
        pinned = problem.pinned(first, finest=True, negligible=problem.negligible(left))
        steps = DIFFERENCE * np.maximum(np.abs(vector), 1e-3 * float(np.max(np.abs(vector))))
        return cls(pinned, first, Packing.of(pinned, first), law, absorbed, values, bounds, steps)

    @property
    def limits(self) -> tuple[Array, Array]:
        """Least and largest values of the whole vector."""
        lower = np.concatenate([self.packing.lower, self.bounds[0]])
        return lower, np.concatenate([self.packing.upper, self.bounds[1]])

    def model(self, at: Array) -> Model:
        """The model of a vector."""
        split = len(self.packing.names)
        beside = self.packing.unpack(at[:split])
        formula = _effect(self.law, self.absorbed, self.values, at[split:])
        return replace(beside, effects=(*beside.effects[:-1], formula))

    def first_work(self, begin: Array) -> float:
        """Work of the first simulation, in seconds; it is counted as any other."""
        first = replace(self, pinned=replace(self.pinned, work=Work()))
        first.simulated(begin)
        work = first.pinned.work
        self.pinned.work.add(work.state())
        return work.seconds

    def simulated(self, at: Array) -> Array:
        """Shape (M,)."""
        key = at.tobytes()
        if key not in self.known:
            try:
                rows = self.pinned.simulate_fitted(self.model(at))
            except (ValueError, ArithmeticError):
                rows = np.full(len(self.pinned.output), RUNAWAY)
            self.known[key] = np.clip(np.nan_to_num(rows, nan=RUNAWAY), -RUNAWAY, RUNAWAY)
        return self.known[key]

    def residual(self, at: Array) -> Array:
        """Recorded minus simulated output, shape (M,)."""
        return np.asarray(self.pinned.output - self.simulated(at))

    def derivatives(self, at: Array, here: Array) -> Array:
        """Of the simulated output, shape (M, p + q), by one-sided differences into the allowed range from ``here``."""
        split = len(self.packing.names)
        moving = replace(self.packing, template=self.model(at))
        columns = [sensitivities(self.pinned, moving, at[:split], here)]
        for i, step in enumerate(self.steps):
            moved = at.copy()
            moved[split + i] += step if at[split + i] + step <= self.bounds[1][i] else -step
            columns.append(((self.simulated(moved) - here) / (moved[split + i] - at[split + i]))[:, None])
        return np.hstack(columns)


def _effect(
    law: LearnedEffect, absorbed: Absorbed, values: Callable[[Array, Array], Array], vector: Array
) -> LearnedEffect:
    """A formula on many points, without what the coefficients hold of it."""
    points = points_about(absorbed.grid)
    held = absorbed.part_of(values(absorbed.grid, vector))
    return on_points(law, points, values(points, vector) - absorbed.functions(points) @ held)


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
        innovations = fitted.problem.whitened(fitted.residual, fitted.noise.whitening)
        carried = coloured(scaled[::-1], fitted.noise.whitening)
        inverse = inverse @ (carried.T @ carried) @ inverse * float(innovations @ innovations) / freedom
    result = np.full((len(lengths), len(lengths)), np.inf)
    result[np.ix_(moving, moving)] = inverse / np.outer(lengths[moving], lengths[moving])
    return result
