"""Whether the variance of a residual grows with something, and whether it does so from frame to frame."""

from __future__ import annotations

from math import log, sqrt

import numpy as np
from numpy.typing import NDArray

from camid.effects.situation import Situation

Array = NDArray[np.float64]

# Residuals fewer than these show no spread.
FEWEST_ROWS = 8
# Rows up to which squares of second differences are correlated.
MOST_LAGS = 2
# Score, in standard deviations, from which differences of frames scatter with the speed: a chance of one in a hundred.
SCATTERS = 2.33


def scatters_from_frame_to_frame(situation: Situation, usable: NDArray[np.bool_]) -> bool:
    """Whether what changes from one frame to the next grows with the speed, too.

    What coefficients err by is larger in fast motion as well, on rows that were not fitted above all, but goes on.

    Parameters
    ----------
    situation : Situation
    usable : ndarray of bool, shape (N,)
        Rows that count.
    """
    rows = np.flatnonzero(usable[1:-1] & usable[:-2] & usable[2:]) + 1
    if len(rows) < FEWEST_ROWS:
        return True
    residual, speed = situation.residual, situation.velocity**2
    difference = residual[rows] - 0.5 * (residual[rows - 1] + residual[rows + 1])
    around = speed[rows] + 0.25 * (speed[rows - 1] + speed[rows + 1])
    return variance_regression(difference**2, around)[3] > SCATTERS


def variance_regression(square: Array, regressor: Array) -> tuple[float, float, float, float]:
    """Gaussian likelihood gain, slope, its standard deviation and score of variance = c + slope · regressor.

    The score is in its standard deviations, with regard to the correlation that neighbouring rows may have, as
    differences of frames do (Newey & West 1987, Econometrica 55, 703-708).
    """
    mean = float(np.mean(square))
    unit = float(np.mean(regressor))
    if mean <= 0.0 or float(np.ptp(regressor)) == 0.0:
        return 0.0, 0.0, 1.0, 0.0
    # In units in which both columns below are near one: beside squares of large speeds the constant would be lost in
    # rounding.
    regressor = regressor / unit
    centred = regressor - np.mean(regressor)
    # Fourth moments as they are, so that heavy tails are not taken for a dependence.
    excess = square / mean - 1.0
    score = float(centred @ excess / _deviation_of_product(centred, excess))
    base, slope = mean, 0.0
    information = np.eye(2)
    for _ in range(30):  # Fisher scoring for the two variances
        variance = np.maximum(base + slope * regressor, 1e-3 * mean)
        basis = np.column_stack([np.ones_like(regressor), regressor]) / variance[:, None]
        information = 0.5 * basis.T @ basis
        step = np.linalg.lstsq(information, 0.5 * basis.T @ (square / variance - 1.0), rcond=None)[0]
        base, slope = max(base + step[0], 1e-3 * mean), max(slope + step[1], 0.0)
        if np.max(np.abs(step)) < 1e-6 * mean:
            break
    variance = np.maximum(base + slope * regressor, 1e-3 * mean)
    gain = 0.5 * float(len(square) * (log(mean) + 1.0) - np.sum(np.log(variance) + square / variance))
    deviation = float(np.sqrt(max(np.linalg.pinv(information)[1, 1], 0.0)))
    return gain, float(slope) / unit, deviation / unit, score


def _deviation_of_product(regressor: Array, excess: Array) -> float:
    """Standard deviation of the product of a regressor and a noise, whose neighbouring rows may be correlated."""
    alone = float(np.mean(excess**2)) * float(regressor @ regressor)
    together = alone
    for lag in range(1, MOST_LAGS + 1):
        together += 2.0 * float(np.mean(excess[lag:] * excess[:-lag])) * float(regressor[lag:] @ regressor[:-lag])
    return sqrt(max(together, alone))
