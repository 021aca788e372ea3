"""How many readings are outliers: a mixture of the noise and of something much wider.

A count of what lies far off misses the outliers that lie near. The share comes from the likelihood of a contaminated
normal distribution (Tukey 1960, in Contributions to Probability and Statistics, 448-485) whose wide component is a
generalised normal one (Subbotin 1923, Mat. Sb. 31, 296-301): from heavier tails than the noise's to nearly uniform, as
the readings have it. Where they say that no outlier lies near, as none does of a second marker, the count holds.
"""

from __future__ import annotations

from math import log, pi, sqrt

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Logarithms of the exponent of the wide component's density: Laplacian to nearly uniform.
LEAST_EXPONENT, LARGEST_EXPONENT = 0.0, 2.5
# Logarithm of how many times as wide as the noise the wide component is.
LEAST_RATIO, LARGEST_RATIO = 0.4, 40.0
# Logarithm of the largest odds of a share.
LARGEST_ODDS = 30.0
# Logarithm of the likelihood ratio from which no outlier lies near: two edges were placed where the readings want them.
HOLLOW = 9.0
# Change of a number of the vector that differentiates the logarithm of the density.
STEP = 1e-4


def outlier_share(values: Array, far: NDArray[np.bool_], spread: float) -> tuple[float, float]:
    """Share of the values that are outliers, and its standard deviation.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Residuals, of zero median.
    far : ndarray of bool, shape (n,)
        Which of them lie far off: some, and not all.
    spread : float
        Robust standard deviation of the others.
    """
    from scipy.optimize import Bounds, minimize

    sizes = np.abs(values) / spread
    share = float(np.mean(far))
    width = float(np.sqrt(np.mean(sizes[far] ** 2)))
    start = np.array([log(share / (1.0 - share)), 0.0, max(log(width), LEAST_RATIO), log(2.0)])
    low = np.array([-LARGEST_ODDS, -1.0, LEAST_RATIO, LEAST_EXPONENT])
    high = np.array([LARGEST_ODDS, 1.0, LARGEST_RATIO, LARGEST_EXPONENT])

    def deviance(vector: Array) -> float:
        return -float(np.sum(_log_density(sizes, vector)))

    result = minimize(deviance, start, method="L-BFGS-B", bounds=Bounds(low, high))
    found = np.asarray(result.x)
    # A number at its bound is not estimated.
    free = np.flatnonzero((found > low) & (found < high))
    steps = STEP * np.eye(len(found))[free]
    scores = [(_log_density(sizes, found + h) - _log_density(sizes, found - h)) / (2.0 * STEP) for h in steps]
    information = np.array(scores) @ np.array(scores).T
    singular = np.linalg.matrix_rank(information) < len(free)
    if singular or _log_likelihood_of_hollow(sizes, far) + deviance(found) > HOLLOW:
        return share, sqrt(share * (1.0 - share) / len(sizes))
    fraction = float(1.0 / (1.0 + np.exp(-found[0])))
    return fraction, fraction * (1.0 - fraction) * float(np.sqrt(np.linalg.inv(information)[0, 0]))


def _log_density(sizes: Array, vector: Array) -> Array:
    """Logarithm of the mixture's density of absolute values, shape (n,).

    ``vector`` holds the logit of the share, the logarithms of both components' widths and that of the exponent.
    """
    from scipy.special import gammaln, log_expit

    odds, narrow, wide, exponent = vector
    power = np.exp(exponent)
    near = log_expit(-odds) - 0.5 * (sizes / np.exp(narrow)) ** 2 - narrow + 0.5 * log(2.0 / pi)
    far = log_expit(odds) - (sizes / np.exp(wide)) ** power - wide + exponent - gammaln(1.0 / power)
    return np.asarray(np.logaddexp(near, far))


def _log_likelihood_of_hollow(sizes: Array, far: NDArray[np.bool_]) -> float:
    """Logarithm of the likelihood where the others are normal and what lies far off is uniform between its extremes."""
    share, near = float(np.mean(far)), sizes[~far]
    narrow = float(np.sqrt(np.mean(near**2)))
    width = max(float(np.ptp(sizes[far])), 1.0)
    normal = len(near) * (log(1.0 - share) - 0.5 - log(narrow) + 0.5 * log(2.0 / pi))
    return normal + (len(sizes) - len(near)) * (log(share) - log(width))
