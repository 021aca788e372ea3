"""Fit effects and the plant's coefficients together: output error through the whole chain."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from camid.fitting.covariance import covariance_of
from camid.fitting.noise_of_residual import Noise
from camid.fitting.onset_profile import onset_deviations
from camid.fitting.output_error import OutputError, sensitivities
from camid.fitting.packing import Packing
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.identification.autoregression import coloured

Array = NDArray[np.float64]

TOLERANCE = 1e-7
# Distance from a bound, in what a number is measured by, within which it lies there.
AT_BOUND = 1e-6
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
    def moving_sensitivities(self) -> Array:
        """Those by numbers that the fit could move, shape (M, q): not by one at a bound that it would go beyond.

        What such a number does, the residual still has in it, and it is none that was fitted.
        """
        vector, packing = self.packing.pack(self.model), self.packing
        pull = self.residual @ self.sensitivities
        reach = AT_BOUND * np.maximum(np.abs(vector), 1.0)
        held = ((vector <= packing.lower + reach) & (pull < 0.0)) | ((vector >= packing.upper - reach) & (pull > 0.0))
        return self.sensitivities[:, ~held] if np.any(held) else self.sensitivities

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
        return onset_deviations(self, fit)


def evaluate(
    problem: Problem, model: Model, fixed: int = 0, *, weighted: bool = False, simulated: Array | None = None
) -> Fitted:
    """Residual and noise of a model as it is; ``simulated`` is its output on the fitted rows where that is known."""
    packing = Packing.of(problem, model, fixed)
    residual = problem.output - (problem.simulate_fitted(model) if simulated is None else simulated)
    return Fitted(problem, model, residual, problem.noise(residual, len(packing.names)), packing, weighted)


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
    output_error = OutputError(pinned, packing, whitening, base, refreshes, tolerance)
    begin = np.clip(packing.pack(start), packing.lower, packing.upper)
    vector = output_error.least(begin, steps)
    if finest:
        vector = _with_fine_steps(problem, output_error, begin, vector, steps)
    simulated = output_error.simulated_whole(vector)
    return evaluate(
        output_error.problem, packing.unpack(vector), fixed, weighted=len(whitening) > 1, simulated=simulated
    )


def _with_fine_steps(problem: Problem, output_error: OutputError, begin: Array, vector: Array, steps: int) -> Array:
    """The vector of least squares with steps of the integrator that are as fine as it needs, shape (p,).

    Few steps lead near to it at a small part of the cost, and their derivatives hold for fine ones.
    """
    few, packing = output_error.problem, output_error.packing
    before = output_error.cost(vector)
    negligible = problem.negligible((output_error.seen.output - output_error.simulated(vector))[output_error.compared])
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
