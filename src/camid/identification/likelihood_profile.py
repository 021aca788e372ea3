"""Standard deviations where the first order is not enough: the profile of the likelihood.

Where the data say little (few samples, much noise, a mode near a zero of the camera), the output error is not a
parabola within two standard deviations. The interval is then read from the error itself: how far a coefficient can be
moved, all others following, before the deviance rises by the 95 % point of χ² (Venzon & Moolgavkar 1988).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from camid.identification.iteration_result import IterationResult
from camid.identification.predictor import Predictor
from camid.identification.safeguarded import safeguarded_srivc

Array = NDArray[np.float64]

# Below this relative standard deviation the first order has been right wherever it was tried, so the check is skipped.
CERTAIN_DEVIATION = 0.05
# 95 % of a normal variable lie within this many standard deviations, and the deviance there is its square.
WIDTH = 1.959964
# Shares of the parabola's deviance between which the first order is left as it is.
PARABOLIC = (0.75, 1.33)
# How often the distance is doubled before a coefficient counts as undetermined.
DOUBLINGS = 6
RESOLUTION = 0.05
# Sensitivities of longer recordings cost too much to be made hundreds of times, and rarely need it.
LONGEST = 50_000


@dataclass(frozen=True)
class Interval:
    """95 % interval of a coefficient that the first order does not describe.

    Attributes
    ----------
    coefficient : int
        Index in [b_0 … b_m, a_1 … a_n].
    low, high : float
        In SI units; infinite where the data set no limit.
    """

    coefficient: int
    low: float
    high: float


def intervals(predictor: Predictor, fit: IterationResult, covariance: Array) -> list[Interval]:
    """Likelihood intervals of the coefficients whose standard deviation of first order is not to be trusted.

    Parameters
    ----------
    predictor : Predictor
    fit : IterationResult
        The optimum.
    covariance : ndarray, shape (p, p)
        Of first order, coefficients in SI units.

    Returns
    -------
    list of Interval
        Empty where the output error is a parabola.
    """
    count = len(predictor.structure.free)
    if not fit.converged or len(predictor.target) > LONGEST or not np.all(np.isfinite(covariance)):
        return []
    scale = predictor.scale()
    scaled = covariance * np.outer(scale, scale)
    deviations = np.sqrt(np.diag(scaled))
    noise = fit.cost / max(len(predictor.target) - int(predictor.free.sum()), 1)
    weak = predictor.free[:count] & (deviations[:count] > CERTAIN_DEVIATION * np.abs(fit.parameters[:count]))
    if noise <= 0.0 or not weak.any():
        return []
    profile = _Profile(predictor, fit, scaled, noise)
    if all(profile.is_parabolic(int(i), side) for i in np.flatnonzero(weak) for side in (-1.0, 1.0)):
        return []
    found = []
    for i in np.flatnonzero(predictor.free[:count]):
        low, high = (fit.parameters[i] + side * profile.half_width(int(i), side) for side in (-1.0, 1.0))
        if profile.bounded[i]:
            low = max(low, 0.0)
        found.append(Interval(int(i), float(low / scale[i]), float(high / scale[i])))
    return found


def standard_deviations(coefficients: Array, first_order: Array, found: list[Interval]) -> Array:
    """Standard deviations whose ± 1.96 reach to the farther end of each interval, never below those of first order."""
    deviations = first_order.copy()
    for interval in found:
        value = coefficients[interval.coefficient]
        reach = max(interval.high - value, value - interval.low)
        deviations[interval.coefficient] = max(reach / WIDTH, first_order[interval.coefficient])
    return deviations


class _Profile:
    """Deviance above the optimum as a function of one coefficient."""

    def __init__(self, predictor: Predictor, fit: IterationResult, covariance: Array, noise: float) -> None:
        self.predictor, self.fit, self.covariance, self.noise = predictor, fit, covariance, noise
        split, order = predictor.structure.degree + 1, predictor.structure.order
        self.bounded = np.zeros(len(predictor.free), bool)
        self.bounded[split : split + order] = True

    def moved(self, i: int, distance: float) -> Array:
        """Parameters with coefficient i moved and the others following to first order."""
        parameters = self.fit.parameters + self.covariance[:, i] * (distance / self.covariance[i, i])
        parameters[self.bounded] = np.maximum(parameters[self.bounded], 0.0)
        return parameters

    def is_parabolic(self, i: int, side: float) -> bool:
        """Whether the deviance at two standard deviations is what the first order says."""
        distance = side * WIDTH * float(np.sqrt(self.covariance[i, i]))
        parameters = self.moved(i, distance)
        if self.bounded[i] and self.fit.parameters[i] + distance < 0.0:
            return False
        deviance = (self.predictor.factorise(parameters, sensitive=False)[1] - self.fit.cost) / self.noise
        return PARABOLIC[0] * WIDTH**2 < deviance < PARABOLIC[1] * WIDTH**2

    def deviance(self, i: int, distance: float) -> float:
        """Deviance with coefficient i moved and all others fitted again."""
        structure = self.predictor.structure
        free_numerator, free_denominator = structure.free_numerator.copy(), structure.free_denominator.copy()
        if i <= structure.degree:
            free_numerator[i] = False
        else:
            free_denominator[i - structure.degree] = False
        fixed = replace(structure, free_numerator=free_numerator, free_denominator=free_denominator)
        predictor = replace(self.predictor, structure=fixed)
        fit = safeguarded_srivc(predictor, self.moved(i, distance), maximum_iterations=30)
        return (fit.cost - self.fit.cost) / self.noise

    def half_width(self, i: int, side: float) -> float:
        """Distance at which the deviance reaches the 95 % point; infinite if it never does."""
        from scipy.optimize import brentq

        # The ends of the bracket are known when the root is sought in it, and each costs a fit.
        @cache
        def excess(distance: float) -> float:
            if distance == 0.0:
                return -WIDTH
            return float(np.sqrt(max(self.deviance(i, side * distance), 0.0))) - WIDTH

        limit = float(self.fit.parameters[i]) if self.bounded[i] and side < 0.0 else np.inf

        near, far = 0.0, WIDTH * float(np.sqrt(self.covariance[i, i]))
        for _ in range(DOUBLINGS):
            if far >= limit:
                return limit if excess(limit) < 0.0 else float(brentq(excess, near, limit, xtol=RESOLUTION * limit))
            if excess(far) > 0.0:
                return float(brentq(excess, near, far, xtol=RESOLUTION * far))
            near, far = far, 2.0 * far
        return np.inf
