"""The likelihood over the whole of a number of which no derivative says how well a recording determines it.

The profile goes on from the estimate to either side, with all else estimated beside it to first order (Bates & Watts
1988, Nonlinear Regression Analysis and Its Applications, section 6.1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from camid.fitting.fit import Fitted

Array = NDArray[np.float64]

# Twice the fall of the log likelihood from which on a value and those beyond it are left out.
IMPOSSIBLE = 30.0
# Singular value over the largest below which columns make up for each other.
LEAST_SINGULAR = 1e-9


class LikelihoodProfile:
    """The fall of the likelihood as one number of an effect moves, in the metric of a fit's noise.

    Parameters
    ----------
    fitted : Fitted
    index, name : int, str
        The effect and its number.
    direction : ndarray, shape (M,)
        What the number does to the output, whose noise counts; of the fit's residual where it is not given.
    """

    def __init__(self, fitted: Fitted, index: int, name: str, direction: Array | None = None) -> None:
        self.fitted, self.index, self.name = fitted, index, name
        self.estimate = float(fitted.model.effects[index].values[name])
        self._whitening = fitted.noise.whitening if fitted.weighted else np.ones(1)
        place = fitted.packing.names.index(f"{index} {name}")
        table = np.delete(fitted.sensitivities, place, axis=1)
        if fitted.nuisance is not None:
            table = np.hstack([table, fitted.nuisance])
        table = fitted.problem.whitened(table, self._whitening)
        lengths = np.where((norms := np.linalg.norm(table, axis=0)) > 0.0, norms, 1.0)
        left, sizes, right = np.linalg.svd(table / lengths, full_matrices=False)
        kept = sizes > LEAST_SINGULAR * np.max(sizes, initial=0.0)
        self.basis, self._back = left[:, kept], right[kept].T / sizes[kept] / lengths[:, None]
        # What the noise's colour leaves of the information in a direction.
        direction = fitted.residual if direction is None else direction
        self._inflation = 1.0 if fitted.weighted else fitted.inflation(direction)
        self._least = self._size(0.0)

    def others(self, change: Array) -> Array:
        """How all other numbers of the fit make up for a change of the output, shape (p - 1,)."""
        found = -self._back @ (self.basis.T @ self.fitted.problem.whitened(change, self._whitening))
        return np.asarray(found[: len(self.fitted.packing.names) - 1])

    def output(self, distance: float) -> Array:
        """Output on the fitted rows with the number moved, shape (M,).

        Raises
        ------
        ValueError, ArithmeticError
            Where the effect, or the simulation, allows no such value.
        """
        effects: list[Any] = list(self.fitted.model.effects)
        effect = effects[self.index]
        effects[self.index] = type(effect)(**{**effect.values, self.name: self.estimate + distance})
        return self.fitted.problem.simulate_fitted(replace(self.fitted.model, effects=tuple(effects)))

    def fall(self, distance: float) -> float:
        """Twice the fall of the log likelihood at a distance from the estimate; infinite where there is no output."""
        try:
            size = self._size(distance)
        except (ValueError, ArithmeticError):
            return np.inf
        ratio = max(size, 1e-300) / max(self._least, 1e-300)
        fall = len(self.fitted.residual) * float(np.log(ratio)) / self._inflation
        return fall if np.isfinite(fall) else np.inf

    def falls(self, distances: Sequence[float]) -> tuple[Array, Array]:
        """Distances from the estimate on, up to the first that is impossible, and the falls there."""
        found: list[float] = []
        for distance in distances:
            fall = self.fall(distance)
            if not fall < IMPOSSIBLE:
                break
            found.append(fall)
        return np.array(distances[: len(found)]), np.array(found)

    def _size(self, distance: float) -> float:
        rows = self.fitted.problem.whitened(self.fitted.problem.output - self.output(distance), self._whitening)
        rows = rows - self.basis @ (self.basis.T @ rows)
        return float(rows @ rows)


def root_mean_square(distances: Array, falls: Array, widths: Array) -> float:
    """Of distances that stand for some widths, weighted with their likelihoods."""
    weights = widths * np.exp(-0.5 * (falls - np.min(falls)))
    return float(np.sqrt(weights @ np.square(distances) / np.sum(weights)))
