"""Fit effects and the plant's coefficients together: output error through the whole chain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from camid.engine.mechanics import NotApplicable
from camid.fitting.covariance import covariance_of
from camid.fitting.noise_of_residual import Noise
from camid.fitting.onset_profile import onset_deviations
from camid.fitting.packing import Packing
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.fitting.updated_derivative import UpdatedDerivative
from camid.identification.autoregression import coloured
from camid.side_by_side import in_threads

Array = NDArray[np.float64]

# Step of the differences that replace derivatives, as a share of what a parameter is measured by.
DIFFERENCE_STEP = 1e-5
# Difference of two simulated outputs, as a share of their size, that is rounding.
ROUNDING = 1e-14
# Residual of a simulation that diverged, in standard deviations of the output.
RUNAWAY_RESIDUAL = 1e3
# Derivative, in the units of the packed numbers and standard deviations of the output, that only a runaway motion has.
LARGEST_DERIVATIVE = 1e15
TOLERANCE = 1e-7
# Steps of the integrator, or rows, of a simulation that takes longer than handing it to a thread.
STEPS_WORTH_A_THREAD = 6000
# A simulation with fine steps that leaves this much more than one with few has shown that few mislead.
MISLED = 1.1
# Evaluations with fine steps behind a fit with few ones, as a share of all, and at least.
FINE_SHARE, FEWEST_FINE = 0.5, 5


@dataclass(frozen=True)
class Fitted:
    """A fitted model.

    Attributes
    ----------
    problem : Problem
    model : Model
    residual : ndarray, shape (M,)
        Recorded minus simulated output on the fitted rows.
    noise : Noise
    packing : Packing
    weighted : bool
        Whether it was fitted in the metric of its noise.
    nuisance : ndarray, shape (M, m), optional
        Derivatives of the simulated output by numbers that were fitted beside the packed ones, measured so that each
        has a Gaussian prior of the noise's variance (:mod:`camid.fitting.learned_law`).
    """

    problem: Problem
    model: Model
    residual: Array
    noise: Noise
    packing: Packing
    weighted: bool = False
    nuisance: Array | None = None

    @cached_property
    def sensitivities(self) -> Array:
        """Derivatives of the simulated output, shape (M, p).

        By the free coefficients, the effects' parameters and the initial states, in this order.
        """
        vector = self.packing.pack(self.model)
        simulated = self.problem.output - self.residual
        return sensitivities(self.problem, self.packing, vector, simulated) / self.packing.units

    @property
    def cost(self) -> float:
        """Sum of squared residuals; infinite where the simulation diverges."""
        cost = float(self.residual @ self.residual)
        return cost if np.isfinite(cost) else np.inf

    def criterion_beyond(self, other: Fitted) -> float:
        """By how much Bayes's criterion of this model exceeds that of another one of the same rows.

        The likelihood takes the noise for white. Where what the better of the two leaves is not, because noise has a
        colour or a law is not exact, a direction of the output in which it varies more says less: the log ratio is
        divided by the variance of that direction over that of white noise, which makes the difference vary as much
        as it claims (Kent 1982, Biometrika 69, 19–27; Chandler & Bate 2007, Biometrika 94, 167–183).
        Initial states do not count as parameters.
        """
        better = self if self.cost <= other.cost else other
        change = other.residual - self.residual
        count = len(self.residual)
        sizes = [max(f.cost, 1e-300) / max(count - len(f.packing.names), 1) for f in (self, other)]
        with np.errstate(divide="ignore"):  # one that diverges is infinitely less likely
            ratio = count * float(np.log(sizes[0] / sizes[1])) / better.inflation(change)
        return ratio + (len(self.penalised_names) - len(other.penalised_names)) * float(np.log(count))

    def inflation(self, change: Array) -> float:
        """Variance of the residual along a direction of the output over that of white noise, but at least 1."""
        length = float(change @ change)
        if len(self.noise.whitening) == 1 or length <= 0.0 or not np.isfinite(length):
            return 1.0
        carried = coloured(change[::-1], self.noise.whitening)
        innovations = self.problem.whitened(self.residual, self.noise.whitening)
        return max(float(carried @ carried) / length * float(innovations @ innovations) / max(self.cost, 1e-300), 1.0)

    @property
    def penalised_names(self) -> list[str]:
        """Names of the parameters that the criterion counts: all that are free, but for initial states of the plant.

        Those of a mode count: no model without it has them. Numbers of an effect that do nothing here do not.
        """
        idle = {f"{i} {name}" for i, effect in enumerate(self.model.effects) for name in effect.idle}
        return [n for n in self.packing.names if n not in idle and (" of " in n or not n.startswith("initial"))]

    @cached_property
    def covariance(self) -> Array:
        """See :func:`camid.fitting.covariance.covariance_of`."""
        return covariance_of(self)

    @cached_property
    def onset_deviations(self) -> dict[int, float]:
        """See :func:`camid.fitting.onset_profile.onset_deviations`."""
        return onset_deviations(self)


def evaluate(
    problem: Problem, model: Model, fixed: int = 0, *, weighted: bool = False, simulated: Array | None = None
) -> Fitted:
    """Residual and noise of a model as it is; ``simulated`` is its output on the fitted rows where that is known."""
    packing = Packing.of(problem, model, fixed)
    residual = problem.output - (problem.simulate_fitted(model) if simulated is None else simulated)
    return Fitted(problem, model, residual, problem.noise(residual, len(packing.names)), packing, weighted)


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


class _OutputError:
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
        # Steps of the integrator that are enough for derivatives.
        self.few = problem
        self.derivative = UpdatedDerivative(self._differences, refreshes, self._first)
        # About the middle of what was recorded: an offset may be far larger than the motion.
        middle = 0.0 if problem.own_zeros else float(np.mean(problem.recorded))
        worst = RUNAWAY_RESIDUAL * problem.output_spread
        rows = np.ones(len(problem.output))
        self.lowest, self.highest = (problem.over_noise((middle + side * worst) * rows) for side in (-1.0, 1.0))
        self.latest: list[tuple[Array, Array]] = []

    def with_steps_of(self, problem: Problem) -> None:
        """Go on with the integrator's steps of another problem, and with the derivative that is known."""
        self.problem, self.latest = problem, []

    def with_derivative_of_its_own(self) -> None:
        """Take the derivatives with the same steps, and anew."""
        self.few = self.problem
        self.derivative.forget()

    def _differences(self, vector: Array, simulated: Array) -> Array:
        if self.few is not self.problem:
            simulated = self.few.simulate_fitted(self.packing.unpack(vector))
        return sensitivities(self.few, self.packing, vector, simulated)

    def _first(self, vector: Array, simulated: Array) -> Array:
        """Columns that a fit without the last effect has already, and differences for the others."""
        if self.base is None:
            return self._differences(vector, simulated)
        names = self.packing.names
        new = len(self.packing.template.effects) - 1
        fresh = [i for i, name in enumerate(names) if name.startswith(f"{new} ") or name.endswith(f" of {new}")]
        table = np.zeros((len(simulated), len(names)))
        table[:, [i for i in range(len(names)) if i not in fresh]] = self.base.sensitivities
        table *= self.packing.units
        if fresh:
            table[:, fresh] = sensitivities(self.problem, self.packing, vector, simulated, fresh)
        return table

    def _simulated(self, vector: Array) -> Array:
        problem, low, high = self.problem, self.lowest, self.highest
        try:
            rows = problem.simulate_fitted(self.packing.unpack(vector))
        except NotApplicable:
            raise
        except (ValueError, ArithmeticError):
            return high.copy()
        return np.clip(np.where(np.isnan(rows), high, rows), low, high)

    def simulated(self, vector: Array) -> Array:
        """The simulated output, shape (M,), the last two of which are kept."""
        # The optimiser asks for the derivative at the point that it evaluated last, or the one before.
        for point, rows in reversed(self.latest):
            if np.array_equal(point, vector):
                return rows
        rows = self._simulated(vector)
        self.latest = [*self.latest[-1:], (vector.copy(), rows)]
        return rows

    def simulated_whole(self, vector: Array) -> Array | None:
        """The same; None where something of it is cut off."""
        rows = self.simulated(vector)
        return rows if bool(np.all((self.lowest < rows) & (rows < self.highest))) else None

    def residual(self, vector: Array) -> Array:
        """Shape (M,)."""
        return self.problem.whitened(self.problem.output - self.simulated(vector), self.whitening)

    def jacobian(self, vector: Array) -> Array:
        """Shape (M, p); zero where a motion that runs away has no derivative."""
        table = -self.problem.whitened(self.derivative.at(vector, self.simulated(vector)), self.whitening)
        return np.where(np.abs(table) < LARGEST_DERIVATIVE * self.problem.output_spread, table, 0.0)

    def cost(self, vector: Array) -> float:
        """Sum of squares."""
        residual = self.residual(vector)
        return float(residual @ residual)

    def least(self, start: Array, steps: int) -> Array:
        """The vector of least squares near a start, shape (p,); numbers that do nothing there stay where they are."""
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


def fit(
    problem: Problem,
    start: Model,
    *,
    steps: int = 25,
    whitening: Array | None = None,
    fixed: int = 0,
    base: Fitted | None = None,
    refreshes: int = 10,
    finest: bool = True,
    tolerance: float = TOLERANCE,
) -> Fitted:
    """Least squares from one start.

    Parameters
    ----------
    problem : Problem
    start : Model
    steps : int
        Largest number of evaluations of the residual.
    whitening : ndarray, optional
        Filter of the noise, for generalised least squares.
    fixed : int
        So many of the model's effects, from the first on, keep their values.
    base : Fitted, optional
        A fit of the same model without its last effect, whose sensitivities this one starts from.
    refreshes : int
        How often the sensitivities may be recomputed by differences.
    finest : bool
        Whether the integrator's steps are as fine as what the model leaves needs, or only what its plant suggests.
    tolerance : float
        Fall of the sum of squares in a step, as a share, that ends the fit.

    Raises
    ------
    NotApplicable
        If an effect has no meaning with this plant.
    """
    pinned = problem.pinned(start, finest=False)
    packing = Packing.of(pinned, start, fixed)
    whitening = np.ones(1) if whitening is None else whitening
    output_error = _OutputError(pinned, packing, whitening, base, refreshes, tolerance)
    begin = np.clip(packing.pack(start), packing.lower, packing.upper)
    vector = output_error.least(begin, steps)
    if finest:
        vector = _with_fine_steps(problem, output_error, begin, vector, steps)
    simulated = output_error.simulated_whole(vector)
    return evaluate(
        output_error.problem, packing.unpack(vector), fixed, weighted=len(whitening) > 1, simulated=simulated
    )


def _with_fine_steps(problem: Problem, output_error: _OutputError, begin: Array, vector: Array, steps: int) -> Array:
    """The vector of least squares with steps of the integrator that are as fine as it needs, shape (p,).

    Few steps lead near to it at a small part of the cost, and their derivatives hold for fine ones.
    """
    few, packing = output_error.problem, output_error.packing
    before = output_error.cost(vector)
    negligible = problem.negligible(problem.output - output_error.simulated(vector))
    fine = problem.pinned(packing.unpack(vector), finest=True, negligible=negligible)
    if fine.steps == few.steps:
        return vector
    output_error.with_steps_of(fine)
    if output_error.cost(vector) > MISLED * before:
        at_first = problem.pinned(packing.unpack(begin), finest=True, negligible=negligible)
        output_error.with_steps_of(at_first)
        if output_error.cost(begin) < output_error.cost(vector):
            output_error.with_derivative_of_its_own()
            return output_error.least(begin, steps)
        output_error.with_steps_of(fine)
    return output_error.least(vector, max(int(FINE_SHARE * steps), FEWEST_FINE))
