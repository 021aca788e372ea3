"""The noise that a residual of several recordings consists of: its colour, and the filter after which it is white."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.identification.experiment import Experiment
from camid.identification.residual_analysis import LARGEST_LAG, ROWS_PER_LAG
from camid.identification.residual_statistics import Moments, Rows, levinson, sums_of_products, whiteness

Array = NDArray[np.float64]

LARGEST_ORDER = 12
ROWS_PER_COEFFICIENT = 20
# Noise is taken for white unless a filter improves the likelihood by this more than Bayes's criterion asks: a weak
# effect would else be mistaken for colour, which the test of whiteness would not confirm.
COLOUR_PENALTY = 12.0


@dataclass(frozen=True)
class Noise:
    """What the residual says about the noise.

    Attributes
    ----------
    whitening : ndarray, shape (p + 1,)
        Filter 1 + a_1 z⁻¹ + … after which it is white.
    deviance : float
        -2 log likelihood, with a penalty for the filter's order.
    """

    whitening: Array
    deviance: float


def noise_of(experiments: Sequence[Experiment], residual: Array, fitted: int) -> Noise:
    """Noise that a residual on the fitted rows, shape (M,), consists of, after ``fitted`` numbers were fitted."""
    count = len(residual)
    size = float(np.max(np.abs(residual), initial=0.0))
    if size == 0.0:
        return Noise(np.ones(1), -np.inf)
    sums = np.zeros(LARGEST_LAG + 1)
    position = 0
    for experiment in experiments:
        rows = np.zeros(len(experiment.used))
        part = int(np.count_nonzero(experiment.used))
        rows[experiment.used] = residual[position : position + part] / size
        position += part
        for lag in range(min(LARGEST_LAG, len(rows) - 1) + 1):
            sums[lag] += rows[lag:] @ rows[: len(rows) - lag]
    # The sums over fewer pairs are not corrected for it, so that the correlations are those of a process.
    order = min(LARGEST_ORDER, count // ROWS_PER_COEFFICIENT)
    filters, left = levinson(sums[: order + 1] / sums[0])
    penalties = np.log(count) * np.arange(len(filters)) + np.where(np.arange(len(filters)) > 0, COLOUR_PENALTY, 0.0)
    best = int(np.argmin(count * np.log(left) + penalties))
    # What a model that runs away leaves has no square.
    variance = np.log(sums[0] / max(count - fitted, 1) * left[best]) + 2.0 * np.log(size)
    return Noise(filters[best], float(count * variance + penalties[best]))


def colour_of(experiments: Sequence[Experiment], residual: Array, sensitivities: Array) -> float:
    """Probability of a residual at least as coloured if the noise is white, with regard to what was fitted."""
    longest = max(int(np.count_nonzero(e.used)) for e in experiments)
    lags = max(min(LARGEST_LAG, longest // ROWS_PER_LAG), 1)
    size = float(np.max(np.abs(residual), initial=0.0)) or 1.0
    rows = Rows.of(experiments, residual / size, sensitivities, np.zeros((len(residual), 0)), lags, 0)
    sums = sums_of_products(rows.residual, lags)
    if sums[0] <= 0.0:
        return 1.0
    found = whiteness(sums, Moments.of(rows, lags))
    return 1.0 if found is None else found


def whitened(experiments: Sequence[Experiment], values: Array, whitening: Array) -> Array:
    """Rows, shape (M,) or (M, c), after a whitening filter; rows whose past is not fitted are set to zero."""
    if len(whitening) == 1:
        return values
    result = whitening[0] * values
    known = np.ones(len(values), bool)
    position = 0
    for experiment in experiments:
        rows = np.flatnonzero(experiment.used)
        part = slice(position, position + len(rows))
        position += len(rows)
        whole = len(rows) == 0 or rows[-1] - rows[0] + 1 == len(rows)
        for lag in range(1, len(whitening)):
            if whole:
                result[part][lag:] += whitening[lag] * values[part][:-lag]
                known[part][:lag] = False
                continue
            near = rows[lag:] - rows[:-lag] == lag
            earlier = np.flatnonzero(near)
            result[part][earlier + lag] += whitening[lag] * values[part][earlier]
            known[part][:lag] = False
            known[part][lag:][~near] = False
    result[~known] = 0.0
    return result
