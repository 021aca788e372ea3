"""Output error of many denominators at once, as a search for starting values needs it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.compiled import njit
from camid.identification.factorisation import factorise
from camid.identification.least_squares import solve
from camid.identification.records import Records

Array = NDArray[np.float64]


@njit
def output_error_costs(
    denominators: Array,
    numerator: Array,
    free_numerator: NDArray[np.bool_],
    linear_unknowns: int,
    records: Records,
) -> Array:
    """Output error of many denominators, each with its best numerator and initial states (variable projection).

    Parameters
    ----------
    denominators : ndarray, shape (K, n + 1)
        Monic, in SI units.
    numerator : ndarray, shape (m + 1,)
        In SI units; only the entries that are not free count.
    free_numerator : ndarray of bool, shape (m + 1,)
    linear_unknowns : int
        See :meth:`camid.identification.records.Records.linear_unknowns`.
    records : Records

    Returns
    -------
    ndarray, shape (K,)
        Sums of squared residuals; infinite where the simulation overflows.
    """
    order, split = denominators.shape[1] - 1, len(numerator)
    costs = np.empty(len(denominators))
    residual = np.empty(len(records.signal))
    initial = np.zeros(linear_unknowns)
    chosen = np.empty(split + linear_unknowns, np.int64)
    number = 0
    for i in range(split + order + linear_unknowns):
        if i >= split + order or (i < split and free_numerator[i]):
            chosen[number] = i
            number += 1
    chosen = chosen[:number]
    scaled, fixed = np.empty(order + 1), np.zeros(split)
    for k in range(len(denominators)):
        radius = 0.0
        for i in range(1, order + 1):
            radius = max(radius, abs(denominators[k, i]) ** (1.0 / i))
        unit = 1.0 / radius if radius > 0.0 else 1.0
        for i in range(order + 1):
            scaled[i] = denominators[k, i] * unit**i
        for i in range(split):
            if not free_numerator[i]:
                fixed[i] = numerator[i] * unit ** (order - split + 1.0 + i)
        triangle, _ = factorise(fixed, scaled, initial, records, unit, False, residual)
        costs[k] = solve(triangle, chosen)[1]
    return costs
