"""The linear system whose states give the simulated output of a plant and all its sensitivities."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.compiled import njit

Array = NDArray[np.float64]


@njit
def companion_system(  # noqa: C901, PLR0912 - loops over elements, which compile fastest
    numerator: Array,
    denominator: Array,
    initial: Array,
    bias: float,
    estimated: bool,
    biased: bool,
    sensitive: bool,
) -> tuple[Array, Array, Array]:
    """Augmented matrix, start and output rows of the chains z = u/A, z̃ = y/A, z_δ = δ/A and z_1 = 1/A.

    All but the first are there as needed; a state that stays at one, behind the last chain, drives it.
    Output rows: simulated output, then its derivatives by [b_0 … b_m, a_1 … a_n, c_1 … c_n, bias].
    """
    order, split = len(denominator) - 1, len(numerator)
    forced = order if sensitive else 0
    free = order + forced
    constant = free + (order if estimated else 0)
    chains = constant + (order if biased else 0)
    size = chains + (1 if biased else 0)
    augmented = np.zeros((size + 2, size + 2))
    for chain in range(0, chains, order):
        for i in range(order):
            augmented[chain, chain + i] = -denominator[1 + i]
        for i in range(order - 1):
            augmented[chain + i + 1, chain + i] = 1.0
    augmented[0, size] = 1.0
    augmented[size, size + 1] = 1.0
    start = np.zeros(size + 2)
    rows = np.zeros((1 + split + order + (order if estimated else 0) + (1 if biased else 0), size + 2))
    for j in range(split):
        degree = split - 1 - j
        if degree == order:  # z^(n) = u - a_1 z^(n-1) - … - a_n z
            for i in range(order):
                rows[1 + j, i] = -denominator[1 + i]
            rows[1 + j, size] = 1.0
        else:
            rows[1 + j, order - 1 - degree] = 1.0
        if biased:
            for i in range(order):
                rows[1 + j, constant + i] = rows[1 + j, i]
            rows[1 + j, chains] = rows[1 + j, size]
            for i in range(constant, size):
                rows[len(rows) - 1, i] += numerator[j] * rows[1 + j, i]
                rows[1 + j, i] *= bias
        for i in range(size + 2):
            rows[0, i] += numerator[j] * rows[1 + j, i]
    if biased:
        augmented[constant, chains] = 1.0
        start[chains] = 1.0
    if estimated:
        start[free] = 1.0
        for i in range(order):
            rows[0, free + i] = initial[i]
            rows[1 + split + order + i, free + i] = 1.0
    if sensitive:
        for i in range(size + 2):
            augmented[order, i] += rows[0, i]
        for i in range(order):
            rows[1 + split + i, order + i] = -1.0
    return augmented, start, rows
