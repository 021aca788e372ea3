"""How many readings are outliers: a mixture of the noise and of something much wider.

A count of what lies far off misses the outliers that lie near. The share comes from the likelihood of a contaminated
normal distribution (Tukey 1960, in Contributions to Probability and Statistics, 448-485) whose wide component is a
generalised normal one (Subbotin 1923, Mat. Sb. 31, 296-301): from heavier tails than the noise's to nearly uniform, as
the readings have it. Where they say that no outlier lies near, as none does of a second marker, the count holds.

Noise may have heavy tails itself, and then nothing struck it: a Student distribution (Lange, Little & Taylor 1989, J.
Am. Stat. Assoc. 84, 881-896), or a generalised normal one from Laplacian to Gaussian. The evidence, by Bayes's
criterion, says which of the two it is: outliers or tails. What strikes readings of a distribution so wide that it has
no third moment comes on top of the noise, so that the near readings are still the noise's: the sum of a normal and a
Student distribution is asked too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
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
# Degrees of freedom of a Student distribution: of Cauchy's, below which its third moment is infinite, so that outliers
# struck it and it is no noise of a sensor, and from which it is a Gaussian one.
CAUCHY, STRUCK, GAUSSIAN = 1.0, 3.0, 1e3
# Bins of the absolute values, over their inverse hyperbolic sine, in which the sum of two distributions is evaluated.
BINS = 300
# Logarithms of the precision over which a Student distribution is a mixture of normal ones.
PRECISIONS = np.linspace(-18.0, 4.0, 56)
# Logarithm of how much narrower or wider than the median either part of such a sum may be.
SPREAD_OF_PARTS = 6.0


@dataclass(frozen=True)
class OutlierShare:
    """Share of readings that are outliers.

    Attributes
    ----------
    fraction, deviation : float
        The share and its standard deviation.
    evidence : float
        Logarithm of the Bayes factor of outliers against noise with heavy tails, by Bayes's criterion.
    """

    fraction: float
    deviation: float
    evidence: float


def outlier_share(values: Array, far: NDArray[np.bool_], spread: float) -> OutlierShare:
    """Share of the values that are outliers.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Residuals, of zero median.
    far : ndarray of bool, shape (n,)
        Which of them lie far off: some, and not all.
    spread : float
        Robust standard deviation of the others.
    """
    sizes = np.abs(values) / spread
    share = float(np.mean(far))
    width = float(np.sqrt(np.mean(sizes[far] ** 2)))
    start = np.array([log(share / (1.0 - share)), 0.0, max(log(width), LEAST_RATIO), log(2.0)])
    low = np.array([-LARGEST_ODDS, -1.0, LEAST_RATIO, LEAST_EXPONENT])
    high = np.array([LARGEST_ODDS, 1.0, LARGEST_RATIO, LARGEST_EXPONENT])

    found = _likeliest(partial(_log_density, sizes), start, low, high)
    # A number at its bound is not estimated.
    free = np.flatnonzero((found > low) & (found < high))
    steps = STEP * np.eye(len(found))[free]
    scores = [(_log_density(sizes, found + h) - _log_density(sizes, found - h)) / (2.0 * STEP) for h in steps]
    information = np.array(scores) @ np.array(scores).T
    singular = np.linalg.matrix_rank(information) < len(free)
    mixture = float(np.sum(_log_density(sizes, found)))
    hollow = _log_likelihood_of_hollow(sizes, far)
    # What lies far off is a wide component, or keeps away from the noise, or has no limit.
    struck = min(
        _criterion(mixture, len(free), sizes),
        _criterion(hollow, len(start), sizes),
        _criterion_of_student(sizes, CAUCHY, STRUCK),
        _criterion_of_sum(sizes, CAUCHY, STRUCK),
    )
    evidence = 0.5 * (_criterion_of_heavy_tails(sizes) - struck)
    if singular or 0 not in free or hollow - mixture > HOLLOW:
        return OutlierShare(share, sqrt(share * (1.0 - share) / len(sizes)), evidence)
    fraction = float(1.0 / (1.0 + np.exp(-found[0])))
    deviation = fraction * (1.0 - fraction) * float(np.sqrt(np.linalg.inv(information)[0, 0]))
    return OutlierShare(fraction, deviation, evidence)


def _criterion(log_likelihood: float, parameters: int, sizes: Array) -> float:
    """Bayes's criterion (Schwarz 1978, Ann. Stat. 6, 461-464)."""
    return parameters * log(len(sizes)) - 2.0 * log_likelihood


def _criterion_of_student(sizes: Array, least: float, largest: float) -> float:
    """Bayes's criterion of a Student distribution with degrees of freedom within these."""
    return _criterion_of(_log_density_of_student, sizes, log(least), log(largest))


def _criterion_of_heavy_tails(sizes: Array) -> float:
    """Bayes's criterion of the likeliest of three kinds of noise with heavy tails."""
    normal = _criterion_of(_log_density_of_generalised_normal, sizes, LEAST_EXPONENT, log(2.0))
    return min(normal, _criterion_of_student(sizes, STRUCK, GAUSSIAN), _criterion_of_sum(sizes, STRUCK, GAUSSIAN))


def _criterion_of_sum(sizes: Array, least: float, largest: float) -> float:
    """Bayes's criterion of normal noise and a Student distribution with degrees of freedom within these, added."""
    scale = np.arcsinh(sizes)
    counts, edges = np.histogram(scale, BINS)
    centres = np.sinh(0.5 * (edges[1:] + edges[:-1]))
    # Sums within bins: the means of the squares, where readings are dense, hold more than the bins' centres.
    held = counts > 0
    squares = np.histogram(scale, BINS, weights=sizes**2)[0]
    centres[held] = np.sqrt(squares[held] / counts[held])
    counts, centres = counts[held], centres[held]

    def density(vector_sizes: Array, vector: Array) -> Array:
        return counts * _log_density_of_sum(vector_sizes, vector)

    width = log(float(np.median(sizes)))
    start = np.array([width, width - log(2.0), log(least) + 0.3 * log(largest / least)])
    low = np.array([width - SPREAD_OF_PARTS, width - SPREAD_OF_PARTS, log(least)])
    high = np.array([width + SPREAD_OF_PARTS, width + SPREAD_OF_PARTS, log(largest)])
    found = _likeliest(partial(density, centres), start, low, high)
    return _criterion(float(np.sum(density(centres, found))), len(start), sizes)


def _criterion_of(law: Callable[[Array, Array], Array], sizes: Array, least: float, largest: float) -> float:
    """Bayes's criterion of a law with a width, and a shape within these."""
    density, width = partial(law, sizes), log(float(np.median(sizes)))
    start = np.array([width, least + 0.3 * (largest - least)])
    low, high = np.array([width - LARGEST_RATIO, least]), np.array([width + LARGEST_RATIO, largest])
    return _criterion(float(np.sum(density(_likeliest(density, start, low, high)))), len(start), sizes)


def _likeliest(density: Callable[[Array], Array], start: Array, low: Array, high: Array) -> Array:
    """Vector within bounds at which the sum of logarithms of a density is largest."""
    from scipy.optimize import Bounds, minimize

    def deviance(vector: Array) -> float:
        return -float(np.sum(density(vector)))

    return np.asarray(minimize(deviance, start, method="L-BFGS-B", bounds=Bounds(low, high)).x)


def _log_density(sizes: Array, vector: Array) -> Array:
    """Logarithm of the mixture's density of absolute values, shape (n,).

    ``vector`` holds the logit of the share, the logarithms of both components' widths and that of the exponent.
    """
    from scipy.special import log_expit

    odds, narrow, wide, exponent = vector
    near = log_expit(-odds) - 0.5 * (sizes / np.exp(narrow)) ** 2 - narrow + 0.5 * log(2.0 / pi)
    far = log_expit(odds) + _log_density_of_generalised_normal(sizes, np.array([wide, exponent]))
    return np.asarray(np.logaddexp(near, far))


def _log_density_of_generalised_normal(sizes: Array, vector: Array) -> Array:
    """Logarithm of a generalised normal density of absolute values, shape (n,).

    ``vector`` holds the logarithms of the width and of the exponent.
    """
    from scipy.special import gammaln

    wide, exponent = vector
    power = np.exp(exponent)
    return np.asarray(exponent - wide - gammaln(1.0 / power) - (sizes / np.exp(wide)) ** power)


def _log_density_of_student(sizes: Array, vector: Array) -> Array:
    """Logarithm of a Student density of absolute values, shape (n,).

    ``vector`` holds the logarithms of the width and of the degrees of freedom.
    """
    from scipy.special import gammaln

    wide, freedom = vector[0], np.exp(vector[1])
    constant = gammaln(0.5 * (freedom + 1.0)) - gammaln(0.5 * freedom) - 0.5 * log(0.25 * pi * freedom) - wide
    return np.asarray(constant - 0.5 * (freedom + 1.0) * np.log1p((sizes / np.exp(wide)) ** 2 / freedom))


def _log_density_of_sum(sizes: Array, vector: Array) -> Array:
    """Logarithm of the density of absolute values of a normal and a Student distribution, added, shape (n,).

    ``vector`` holds the logarithms of both widths and of the degrees of freedom. A Student distribution is a mixture
    of normal ones over their precision.
    """
    from scipy.special import log_softmax, logsumexp

    normal, student, freedom = np.exp(vector)
    share = log_softmax(0.5 * freedom * (PRECISIONS - np.exp(PRECISIONS)))
    variance = normal**2 + student**2 * np.exp(-PRECISIONS)
    height = share - 0.5 * np.log(variance) + 0.5 * log(2.0 / pi)
    return np.asarray(logsumexp(height - 0.5 * sizes[:, None] ** 2 / variance, axis=1))


def _log_likelihood_of_hollow(sizes: Array, far: NDArray[np.bool_]) -> float:
    """Logarithm of the likelihood where the others are normal and what lies far off is uniform between its extremes."""
    share, near = float(np.mean(far)), sizes[~far]
    narrow = float(np.sqrt(np.mean(near**2)))
    width = max(float(np.ptp(sizes[far])), 1.0)
    normal = len(near) * (log(1.0 - share) - 0.5 - log(narrow) + 0.5 * log(2.0 / pi))
    return normal + (len(sizes) - len(near)) * (log(share) - log(width))
