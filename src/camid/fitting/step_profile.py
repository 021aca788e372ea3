"""How well a recording determines a number by which the output moves in jumps: steps to which a command is rounded.

Between two jumps the number and the plant's gain make up for each other, so that no derivative says anything of it;
beyond them some commands are rounded the other way.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from camid.fitting.likelihood_profile import LikelihoodProfile, root_mean_square

if TYPE_CHECKING:
    from camid.fitting.fit import Fitted

Array = NDArray[np.float64]

# Distances from the estimate, as shares of it: the profile begins finely, and ends where it is another number.
SHARES = 5e-4 * (1.12 ** np.arange(1.0, 61.0) - 1.0) / 0.12
# Of the estimate, what is no longer it below, and the least deviation.
LOWEST, LEAST = 0.95, 2.5e-4


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
        profile = LikelihoodProfile(fitted, index, str(fitted.model.effects[index].jumps_by))
        deviation, nearest = _deviation(profile)
        if deviation == 0.0:
            continue
        # The others make up for what it does between two jumps; a derivative at a point may be that of a jump.
        change = profile.output(nearest) - profile.output(0.0)
        moved = np.insert(profile.others(change) / nearest, place, 1.0)
        covariance = covariance + deviation**2 * np.outer(moved, moved)
    return covariance


def _deviation(profile: LikelihoodProfile) -> tuple[float, float]:
    """Root mean square distance from the estimate of what the profile leaves possible, and the likeliest distance."""
    size = abs(profile.estimate)
    distances, falls, widths = [np.zeros(1)], [np.zeros(1)], [np.array([SHARES[0] * size])]
    for side in (-1.0, 1.0):
        shares = SHARES[SHARES < LOWEST] if side * profile.estimate < 0.0 else SHARES
        found, fallen = profile.falls((side * shares * size).tolist())
        distances.append(found)
        falls.append(fallen)
        widths.append(np.diff(shares, prepend=0.0)[: len(found)] * size)
    every, fallen, wide = (np.concatenate(each) for each in (distances, falls, widths))
    nearest = float(every[1 + np.argmin(fallen[1:])]) if len(every) > 1 else SHARES[0] * size
    return max(root_mean_square(every, fallen, wide), LEAST * size), nearest
