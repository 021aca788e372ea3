"""How well a recording determines a number by which the output moves in jumps: steps to which a command is rounded.

Between two jumps the number and the plant's gain make up for each other, so that no derivative says anything of it;
beyond them some commands are rounded the other way. The profile of the likelihood, with all else estimated beside it,
says both (Bates & Watts 1988, Nonlinear Regression Analysis and Its Applications, section 6.1).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from camid.fitting.fit import Fitted

Array = NDArray[np.float64]

# Parts of the number in which its profile goes on, and how many of them at most to either side.
SHARE, MOST = 5e-4, 120
# Twice the fall of the log likelihood from which on a number and those beyond it are left out.
IMPOSSIBLE = 30.0


def jumping_places(fitted: Fitted) -> dict[int, int]:
    """Places among the packed parameters of numbers by which the output jumps, and the indices of their effects."""
    names = [(index, f"{index} {effect.jumps_by}") for index, effect in enumerate(fitted.model.effects)]
    return {fitted.packing.names.index(name): index for index, name in names if name in fitted.packing.names}


def with_jumps(fitted: Fitted, covariance: Array, jumping: dict[int, int]) -> Array:
    """The covariance of the packed parameters with what the profile leaves open of numbers by which the output jumps.

    Parameters
    ----------
    fitted : Fitted
    covariance : ndarray, shape (p, p)
        Of the others where these are known, with zeros in their places.
    jumping : dict of int to int
        Their places, and the indices of their effects.
    """
    for place, index in jumping.items():
        basis, back = _beside(fitted, place)
        deviation = _deviation(fitted, index, basis)
        ends = [_simulated(fitted, index, side * deviation) for side in (-1.0, 1.0)]
        # The others make up for what it does over its deviation; at a point its derivative may be a jump's.
        moved = np.insert(-back @ (basis.T @ (ends[1] - ends[0])) / (2.0 * deviation), place, 1.0)
        covariance = covariance + deviation**2 * np.outer(moved, moved)
    return covariance


def _beside(fitted: Fitted, place: int) -> tuple[Array, Array]:
    """Basis of what all other numbers do, shape (M, r), and what they are for its coordinates, shape (p - 1, r)."""
    table = np.delete(fitted.sensitivities, place, axis=1)
    lengths = np.where((norms := np.linalg.norm(table, axis=0)) > 0.0, norms, 1.0)
    left, sizes, right = np.linalg.svd(table / lengths, full_matrices=False)
    kept = sizes > 1e-9 * sizes[0]
    return left[:, kept], right[kept].T / sizes[kept] / lengths[:, None]


def _simulated(fitted: Fitted, index: int, distance: float) -> Array:
    """Output on the fitted rows with a number by which it jumps moved by a distance."""
    effect = fitted.model.effects[index]
    name = str(effect.jumps_by)
    moved = type(effect)(**{**effect.values, name: float(effect.values[name]) + distance})
    effects = (*fitted.model.effects[:index], moved, *fitted.model.effects[index + 1 :])
    return fitted.problem.simulate_fitted(replace(fitted.model, effects=effects))


def _deviation(fitted: Fitted, index: int, basis: Array) -> float:
    """Root mean square distance from the estimate of what the profile leaves possible."""
    count, effect = len(fitted.residual), fitted.model.effects[index]
    estimate = float(effect.values[str(effect.jumps_by)])

    def size(distance: float) -> float:
        rows = fitted.problem.output - _simulated(fitted, index, distance)
        rows = rows - basis @ (basis.T @ rows)
        return float(rows @ rows)

    least = max(size(0.0), 1e-300)
    distances, falls = [0.0], [0.0]
    for side in (-1.0, 1.0):
        for turn in range(1, MOST + 1):
            distance = side * turn * SHARE * estimate
            fall = count * float(np.log(max(size(distance), 1e-300) / least))
            if not fall < IMPOSSIBLE:
                break
            distances.append(distance)
            falls.append(fall)
    weights = np.exp(-0.5 * (np.array(falls) - min(falls)))
    # A profile that ends at once leaves half a part open.
    return max(float(np.sqrt(weights @ np.square(distances) / np.sum(weights))), 0.5 * SHARE * estimate)
