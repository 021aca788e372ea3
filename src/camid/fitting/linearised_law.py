"""What a recording says of the values of a law on a fine grid, to first order about the learned one.

With all else that is fitted projected out, the sum of squares that a law h leaves is ‖F h − z‖² + r, which holds its
covariance in full: a formula is fitted to it in the place of the recording. What the plant's coefficients can do of a
law, a constant and a straight line, is taken out of it as it was taken out of the learned one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from camid.effects.learned import FORCES, LearnedCurve, LearnedEffect
from camid.fitting.fit import Fitted
from camid.fitting.law_columns import law_columns
from camid.fitting.learned_law import DIFFERENCE, orthonormal
from camid.fitting.output_error import sensitivities
from camid.fitting.packing import Packing
from camid.fitting.possible_laws import coefficient_is_free, largest_force, visited
from camid.fitting.problem import Problem

Array = NDArray[np.float64]

# Points of the grid between two knots.
BETWEEN_KNOTS = 4
# Share of the distance between points within which one is taken for zero.
NEARLY_ZERO = 0.1
# Points of the grid, at most.
MOST_POINTS = 129


@dataclass(frozen=True)
class Absorbed:
    """What coefficients can do of a law: the constant and the straight line that are taken out of it.

    Attributes
    ----------
    grid : ndarray, shape (G,)
    constraints : ndarray, shape (k, G)
        What a law without them sends to zero.
    constant, line : bool
        Which of the two there are.
    """

    grid: Array
    constraints: Array
    constant: bool
    line: bool

    def functions(self, at: Array) -> Array:
        """Constant and line at some points, shape (N, k)."""
        columns = [np.ones_like(at)] * self.constant + [at] * self.line
        return np.column_stack(columns) if columns else np.zeros((len(at), 0))

    @cached_property
    def on_grid(self) -> Array:
        """Constant and line on the grid, shape (G, k)."""
        return self.functions(self.grid)

    @cached_property
    def parts(self) -> Array:
        """What takes the values of a law on the grid to how much of each is in it, shape (k, G)."""
        if not len(self.constraints):
            return np.zeros((0, len(self.grid)))
        return np.asarray(np.linalg.solve(self.constraints @ self.on_grid, self.constraints))

    def part_of(self, values: Array) -> Array:
        """How much of each, shape (k,) or (…, k, c), is in laws with these values on the grid, (G,) or (…, G, c)."""
        return np.asarray(self.parts @ values)

    def without(self, values: Array) -> Array:
        """The laws without them, on the grid."""
        return np.asarray(values - self.on_grid @ self.part_of(values))


@dataclass(frozen=True)
class LinearisedLaw:
    """The sum of squares that a law leaves, to first order: ‖F h − z‖² + r.

    Attributes
    ----------
    grid : ndarray, shape (G,)
        In the law's variable.
    values : ndarray, shape (G,)
        The learned law: a force, or by how much a curve bends.
    factor, target : ndarray, shapes (n, G) and (n,)
        F and z.
    rest : float
        r.
    absorbed : Absorbed
    rows : int
        Rows that are fitted.
    """

    grid: Array
    values: Array
    factor: Array
    target: Array
    rest: float
    absorbed: Absorbed
    rows: int

    @cached_property
    def factor_of_any(self) -> Array:
        """F for laws that still hold what the coefficients absorb, shape (n, G)."""
        return np.asarray(self.factor - (self.factor @ self.absorbed.on_grid) @ self.absorbed.parts)


@dataclass(frozen=True)
class LawTable:
    """A model with a law, linearised by all that is fitted and by the law's values on a grid.

    Attributes
    ----------
    grid, values : ndarray, shape (G,)
        The law: a force, or by how much a curve bends.
    residual : ndarray, shape (M,)
    table : ndarray, shape (M, p)
        Derivatives of the output by the packed numbers.
    names : list of str
        Of the packed numbers.
    columns : ndarray, shape (M, G)
        Derivatives of the output by the law's values.
    absorbed : Absorbed
    """

    grid: Array
    values: Array
    residual: Array
    table: Array
    names: list[str]
    columns: Array
    absorbed: Absorbed

    @classmethod
    def of(cls, problem: Problem, fitted: Fitted, index: int, grid: Array) -> LawTable:
        """Of the effect ``index`` of a model.

        Raises
        ------
        ValueError
            If the simulation diverges.
        """
        law = fitted.model.effects[index]
        assert isinstance(law, LearnedEffect)
        # A law on more points than the grid, as a formula is, keeps them.
        points = grid if len(grid) > len(law.knots) else law.knots
        other = on_points(law, points, bend_of(law, points))
        model = replace(
            fitted.model, effects=tuple(other if i == index else e for i, e in enumerate(fitted.model.effects))
        )
        pinned = problem.pinned(model, finest=True, negligible=problem.negligible(fitted.residual))
        packing = Packing.of(pinned, model)
        simulated = pinned.simulate_fitted(model)
        if not np.all(np.isfinite(simulated)):
            raise ValueError("the simulation diverges with this law")
        table = sensitivities(pinned, packing, packing.pack(model), simulated)
        size = DIFFERENCE * (float(np.ptp(grid)) if isinstance(law, LearnedCurve) else _unit(problem, fitted, law))

        hats = np.column_stack([np.interp(points, grid, way) for way in np.eye(len(grid))])
        columns = law_columns(pinned, model, index, hats, size, simulated)
        absorbed = absorbed_of(problem, fitted, law, grid)
        return cls(grid, bend_of(law, grid), problem.output - simulated, table, packing.names, columns, absorbed)

    def about(self, values: Array, replaced: Sequence[int] = (), beside: Array | None = None) -> LinearisedLaw:
        """What the recording says of a law that stands for this one, and for other effects with it.

        Parameters
        ----------
        values : ndarray, shape (G,)
            Of all that it stands for.
        replaced : sequence of int
            Effects that it stands for, too: their parameters do not move beside it.
        beside : ndarray, shape (M, m), optional
            Derivatives by what is fitted beside it with a prior of the noise's variance.
        """
        gone = {str(index) for index in replaced}
        moved = [i for i, name in enumerate(self.names) if name.partition(" ")[0] not in gone]
        target = self.residual + self.columns @ values
        left, target = (projected(rows, self.table[:, moved], beside) for rows in (self.columns, target))
        basis, factor = np.linalg.qr(left)
        z = basis.T @ target
        rest = max(float(target @ target - z @ z), 0.0)
        return LinearisedLaw(self.grid, values, factor, z, rest, self.absorbed, len(self.residual))


def fine_grid(knots: Array) -> Array:
    """Points between knots, the knots themselves, and zero, where many forms have a kink."""
    between = max(min(BETWEEN_KNOTS, (MOST_POINTS - 1) // (len(knots) - 1)), 1)
    grid = np.interp(np.arange((len(knots) - 1) * between + 1) / between, np.arange(len(knots)), knots)
    if not grid[0] < 0.0 < grid[-1]:
        return grid
    # A point that is nearly zero moves there.
    near = np.abs(grid) < NEARLY_ZERO * float(np.max(np.diff(grid)))
    return np.sort(np.concatenate([grid[~near], [0.0]]))


def bend_of(law: LearnedEffect, at: Array) -> Array:
    """A force, or by how much a curve bends, at some points."""
    heights = law.heights - law.knots if isinstance(law, LearnedCurve) else law.heights
    return np.asarray(np.interp(at, law.knots, heights))


def on_points(law: LearnedEffect, points: Array, bends: Array) -> LearnedEffect:
    """A law of the same kind with these values, or bends, at other points."""
    heights = points + bends if isinstance(law, LearnedCurve) else bends
    values = {**law.values, "knots": points.tolist(), "values": np.asarray(heights, dtype=float).tolist()}
    return type(law)(**values)


def absorbed_of(problem: Problem, fitted: Fitted, law: LearnedEffect, grid: Array) -> Absorbed:
    """What coefficients can do of a law, as :func:`camid.fitting.learned_law.learn` takes it out."""
    name = str(law.values["variables"])
    over, times = FORCES.get(name, (name, None))
    seen = visited(problem, fitted)
    edges = np.concatenate([[-np.inf], 0.5 * (grid[1:] + grid[:-1]), [np.inf]])
    counts = np.histogram(seen[over], edges, weights=None if times is None else seen[times] ** 2)[0].astype(float)
    counts /= max(float(counts.sum()), 1e-300)
    constraints = []
    if times is None:
        zero = np.array([np.interp(0.0, grid, row) for row in np.eye(len(grid))])
        constraints.append(zero if grid[0] < 0.0 < grid[-1] else counts)
    free = coefficient_is_free(problem, name)
    if free:
        constraints.append(counts * (grid - float(counts @ grid)) if times is None else counts)
    return Absorbed(
        grid,
        np.array(constraints) if constraints else np.zeros((0, len(grid))),
        constant=times is None or free,
        line=times is None and free,
    )


def _unit(problem: Problem, fitted: Fitted, law: LearnedEffect) -> float:
    """What a force's values are measured by."""
    seen = visited(problem, fitted)
    times = FORCES[str(law.values["variables"])][1]
    unit = largest_force(seen["input"], problem, fitted)
    return unit if times is None else unit / (float(np.max(np.abs(seen[times]))) or 1.0)


def projected(rows: Array, table: Array, beside: Array | None) -> Array:
    """Rows without what the columns of a table can do, and what other laws can do within their prior."""
    if beside is not None and beside.shape[1]:
        count = beside.shape[1]
        prior = np.hstack([np.zeros((count, table.shape[1])), np.eye(count)])
        table = np.vstack([np.hstack([table, beside]), prior])
        rows = np.concatenate([rows, np.zeros((count, *rows.shape[1:]))])
    basis = orthonormal(table)
    return np.asarray(rows - basis @ (basis.T @ rows))
