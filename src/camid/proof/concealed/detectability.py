"""How far an effect rises above the noise, and the strength that brings it there.

The size of an effect is measured by what remains after the simulation's plant has been re-estimated: a sum of
squares of 25 times the noise variance counts as one detectable size.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.identification.estimate import estimate
from camid.identification.experiment import Experiment
from camid.identification.predictor import Predictor
from camid.identification.safeguarded import safeguarded_srivc
from camid.identification.structure import Structure
from camid.proof.concealed.machine_integrator import DivergedError

Array = NDArray[np.float64]

UNIT = 25.0  # noise variances
MULTIPLE_TOLERANCE = 0.05
EVALUATIONS = 14
SMALLEST_STRENGTH = 1e-7


@dataclass(frozen=True)
class Belief:
    """How a recording is declared.

    Attributes
    ----------
    plant : TransferFunction
        The true linear plant: where the re-estimation starts.
    acquisition : Acquisition
        As it is declared.
    moving : bool
        Whether the initial state is estimated.
    """

    plant: TransferFunction
    acquisition: Acquisition
    moving: bool

    def _experiment(self, command: Array, output: Array) -> Experiment:
        used = np.ones(len(output), bool)
        if self.moving:
            used[: self.acquisition.window()[0]] = False
        return Experiment(command, output, self.acquisition, used, self.moving)

    @property
    def _structure(self) -> Structure:
        return Structure.of_order(self.plant.order, len(self.plant.numerator) - 1)

    def left_over(self, command: Array, output: Array) -> float:
        """Sum of squares that the re-estimated plant does not follow, by a local search from the true plant."""
        experiment = self._experiment(command, output)
        predictor = Predictor.around(self._structure, [experiment], np.asarray(self.plant.denominator))
        start = np.concatenate([self.plant.numerator, self.plant.denominator[1:]])
        return float(safeguarded_srivc(predictor, predictor.with_fitted_initial_states(start)).cost)

    def left_over_after_estimate(self, command: Array, output: Array) -> float:
        """The same by the complete identification, with all its starts."""
        experiment = self._experiment(command, output)
        result = estimate(self._structure, [experiment], nominal=self.plant)
        return float(np.sum(result.residuals[0][experiment.used] ** 2))


def multiple(sum_of_squares: float, noise_std: float) -> float:
    """Size in detectable sizes: the root of the ratio of the sums of squares."""
    return float(np.sqrt(max(sum_of_squares, 0.0) / UNIT) / noise_std)


def strength_for(wanted: float, size: Callable[[float], float], start: float, largest: float) -> float:
    """Strength at which an effect has the wanted size, or the largest that its family reaches.

    Parameters
    ----------
    wanted : float
        In detectable sizes.
    size : callable
        From the strength to the size; :class:`DivergedError` counts as too large.
    start, largest : float
        First guess and bound of the strength.

    Returns
    -------
    float
        Of all strengths that were tried, the one whose size is nearest to the required one.
    """

    def measured(strength: float) -> float:
        try:
            return size(strength)
        except DivergedError:
            return float("inf")

    below: tuple[float, float] | None = None
    above: tuple[float, float] | None = None
    best = (start, 0.0)
    strength = min(start, largest)
    for _ in range(EVALUATIONS):
        found = measured(strength)
        if np.isfinite(found) and (
            best[1] == 0.0 or abs(np.log((found + 1e-30) / wanted)) < abs(np.log((best[1] + 1e-30) / wanted))
        ):
            best = (strength, found)
        if abs(found / wanted - 1.0) < MULTIPLE_TOLERANCE or (found < wanted and strength >= largest):
            break
        if found < wanted:
            below = (strength, found)
        else:
            above = (strength, found)
        strength = _next(wanted, below, above, largest)
        if strength < SMALLEST_STRENGTH:
            break
    return best[0]


def _next(wanted: float, below: tuple[float, float] | None, above: tuple[float, float] | None, largest: float) -> float:
    """Next trial: along the straight line in logarithms within a bracket, else as if the size were proportional."""
    if below is not None and above is not None:
        middle = float(np.sqrt(below[0] * above[0]))
        if not np.isfinite(above[1]) or below[1] <= 0.0:
            return middle
        share = np.log(wanted / below[1]) / np.log(above[1] / below[1])
        line = float(below[0] * (above[0] / below[0]) ** share)
        # Away from the ends, so that the bracket shrinks even where the line is a bad guess.
        edge = (above[0] / below[0]) ** 0.1
        return float(np.clip(line, below[0] * edge, above[0] / edge))
    if below is not None:
        factor = 30.0 if below[1] <= 0.0 else float(np.clip(wanted / below[1], 1.2, 30.0))
        return min(below[0] * factor, largest)
    assert above is not None
    factor = 0.2 if not np.isfinite(above[1]) else float(np.clip(wanted / above[1], 0.01, 0.8))
    return above[0] * factor
