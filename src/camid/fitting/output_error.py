"""Recorded minus simulated output over the numbers of a model, with its derivatives, and where its square is least."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from camid.engine.mechanics import NotApplicable
from camid.fitting.first_rows import FirstRows
from camid.fitting.packing import Packing
from camid.fitting.problem import Problem
from camid.fitting.updated_derivative import LatestOutputs, UpdatedDerivative
from camid.side_by_side import in_threads

if TYPE_CHECKING:
    from camid.fitting.fit import Fitted

Array = NDArray[np.float64]

# Step of the differences that replace derivatives, as a share of what a parameter is measured by.
DIFFERENCE_STEP = 1e-5
# Difference of two simulated outputs, as a share of their size, that is rounding.
ROUNDING = 1e-14
# Residual of a simulation that diverged, in standard deviations of the output.
RUNAWAY_RESIDUAL = 1e3
# Derivative, in the units of the packed numbers and standard deviations of the output, that only a runaway motion has.
LARGEST_DERIVATIVE = 1e15
# Steps of the integrator, or rows, of a simulation that takes longer than handing it to a thread.
STEPS_WORTH_A_THREAD = 6000
# The first rows are weighed anew where they then count for less than this share of what they did, and how often.
HEAVIER, MOST_WEIGHINGS = 0.5, 4


def sensitivities(
    problem: Problem, packing: Packing, vector: Array, simulated: Array, columns: Sequence[int] | None = None
) -> Array:
    """Derivatives by (some of) the packed vector, shape (M, p), by one-sided differences into the allowed range."""
    columns = list(range(len(vector)) if columns is None else columns)
    groups = packing.moved_together(columns)
    steps = np.where(vector + DIFFERENCE_STEP <= packing.upper, DIFFERENCE_STEP, -DIFFERENCE_STEP)
    counts = [int(np.count_nonzero(experiment.used)) for experiment in problem.experiments]
    runs = np.repeat(problem.runs, counts)

    def change(group: dict[int, int | None]) -> Array:
        moved = vector.copy()
        moved[list(group)] += steps[list(group)]
        try:
            return problem.simulate_fitted(packing.unpack(moved)) - simulated
        except (ValueError, ArithmeticError):
            return np.zeros(len(simulated))

    short = problem.integrated < STEPS_WORTH_A_THREAD
    changes = [change(group) for group in groups] if short else in_threads(change, groups)
    table = np.zeros((len(simulated), len(columns)))
    for group, changed in zip(groups, changes, strict=True):
        for column, run in group.items():
            rows = changed if run is None else np.where(runs == run, changed, 0.0)
            table[:, columns.index(column)] = rows / steps[column]
    table[~np.isfinite(table)] = 0.0
    return table


class OutputError:
    """Recorded minus simulated output over the packed vector, whitened, and its derivative."""

    def __init__(
        self,
        problem: Problem,
        packing: Packing,
        whitening: Array,
        base: Fitted | None,
        refreshes: int,
        tolerance: float,
    ) -> None:
        self.tolerance = tolerance
        self.problem, self.packing, self.whitening, self.base = problem, packing, whitening, base
        # What is simulated, and what for derivatives, for which few steps of the integrator are enough.
        self.first_rows = FirstRows.of(problem, packing.template)
        self.seen = self.few = problem if self.first_rows is None else self.first_rows.problem
        self.weight = 0.0
        self.derivative = UpdatedDerivative(self._differences, refreshes, self._first)
        # About the middle of what was recorded: an offset may be far larger than the motion.
        middle = 0.0 if problem.own_zeros else float(np.mean(problem.recorded))
        worst = RUNAWAY_RESIDUAL * problem.output_spread
        rows = np.ones(len(self.seen.output))
        self.lowest, self.highest = (self.seen.over_noise((middle + side * worst) * rows) for side in (-1.0, 1.0))
        self.latest = LatestOutputs(self._simulated)

    def with_steps_of(self, problem: Problem) -> None:
        """Go on with the integrator's steps of another problem, and with the derivative that is known."""
        self.problem, self.latest = problem, LatestOutputs(self._simulated)
        self.first_rows = None if self.first_rows is None else self.first_rows.stepped_as(problem)
        self.seen = problem if self.first_rows is None else self.first_rows.problem

    def with_derivative_of_its_own(self) -> None:
        """Take the derivatives with the same steps, and anew."""
        self.few = self.seen
        self.derivative.forget()

    def _differences(self, vector: Array, simulated: Array) -> Array:
        if self.few is not self.seen:
            simulated = self.few.simulate_fitted(self.packing.unpack(vector))
        return sensitivities(self.few, self.packing, vector, simulated)

    def _first(self, vector: Array, simulated: Array) -> Array:
        """Columns that a fit without the last effect has already, and differences for the others."""
        if self.base is None:
            return self._differences(vector, simulated)
        names = self.packing.names
        new = len(self.packing.template.effects) - 1
        fresh = [i for i, name in enumerate(names) if name.startswith(f"{new} ") or name.endswith(f" of {new}")]
        known = np.setdiff1d(np.arange(len(names)), fresh)
        table = np.zeros((len(simulated), len(names)))
        table[np.ix_(self.compared, known)] = self.base.sensitivities * self.packing.units[known]
        if fresh:
            table[:, fresh] = sensitivities(self.seen, self.packing, vector, simulated, fresh)
        if self.first_rows is not None:
            rows = ~self.compared
            others = sensitivities(self.first_rows.alone, self.packing, vector, simulated[rows], known.tolist())
            table[np.ix_(rows, known)] = others
        return table

    @property
    def compared(self) -> NDArray[np.bool_]:
        """Which of the simulated rows are compared."""
        return np.ones(len(self.seen.output), bool) if self.first_rows is None else self.first_rows.compared

    def _in_metric(self, rows: Array) -> Array:
        """Rows in the metric of the noise, and behind them those that only show how the motion began."""
        if self.first_rows is None:
            return self.problem.whitened(rows, self.whitening)
        whitened = self.problem.whitened(rows[self.compared], self.whitening)
        return np.concatenate([whitened, self.weight * rows[~self.compared]])

    def _simulated(self, vector: Array) -> Array:
        problem, low, high = self.seen, self.lowest, self.highest
        try:
            rows = problem.simulate_fitted(self.packing.unpack(vector))
        except NotApplicable:
            raise
        except (ValueError, ArithmeticError):
            return high.copy()
        return np.clip(np.where(np.isnan(rows), high, rows), low, high)

    def simulated(self, vector: Array) -> Array:
        """The simulated output, shape (M,), the last two of which are kept."""
        return self.latest(vector)

    def simulated_whole(self, vector: Array) -> Array | None:
        """The same; None where something of it is cut off."""
        rows = self.simulated(vector)
        whole = (self.lowest < rows) & (rows < self.highest)
        return rows[self.compared] if bool(np.all(whole[self.compared])) else None

    def residual(self, vector: Array) -> Array:
        """Shape (M,)."""
        return self._in_metric(self.seen.output - self.simulated(vector))

    def jacobian(self, vector: Array) -> Array:
        """Shape (M, p); zero where a motion that runs away has no derivative."""
        table = -self._in_metric(self.derivative.at(vector, self.simulated(vector)))
        return np.where(np.abs(table) < LARGEST_DERIVATIVE * self.problem.output_spread, table, 0.0)

    def cost(self, vector: Array) -> float:
        """Sum of squares."""
        residual = self.residual(vector)
        return float(residual @ residual)

    def least(self, start: Array, steps: int) -> Array:
        """The vector of least squares near a start, shape (p,); numbers that do nothing there stay where they are."""
        if self.first_rows is None:
            return self._least_as_weighed(start, steps)
        for _ in range(MOST_WEIGHINGS):
            self.weight = weight = self._weight(start)
            start = self._least_as_weighed(start, steps)
            if self._weight(start) >= HEAVIER * weight:
                break
        return start

    def _weight(self, vector: Array) -> float:
        """What the first rows count for beside what the others leave."""
        assert self.first_rows is not None
        return self.first_rows.weight((self.seen.output - self.simulated(vector))[self.compared])

    def _least_as_weighed(self, start: Array, steps: int) -> Array:
        """The same with the present weight of the first rows."""
        from scipy.optimize import least_squares

        # The optimiser would scale the rounding of a number that does nothing to the size of the others, and follow it.
        rounding = ROUNDING * float(np.linalg.norm(self.simulated(start))) / DIFFERENCE_STEP
        moving = np.linalg.norm(self.jacobian(start), axis=0) > rounding

        def whole(vector: Array) -> Array:
            every = start.copy()
            every[moving] = vector
            return every

        def residual(vector: Array) -> Array:
            return self.residual(whole(vector))

        def jacobian(vector: Array) -> Array:
            return self.jacobian(whole(vector))[:, moving]

        if not np.any(moving):
            return start
        # Where nothing has a derivative the step is nought by nought: the fit stays where it is, and that is right.
        with np.errstate(divide="ignore", invalid="ignore"):
            found = least_squares(
                residual,
                start[moving],
                jac=jacobian,
                bounds=(self.packing.lower[moving], self.packing.upper[moving]),
                x_scale="jac",
                ftol=self.tolerance,
                xtol=1e-9,
                gtol=None,
                max_nfev=steps,
            )
        return whole(found.x)
