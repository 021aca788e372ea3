"""Least squares whose rows come a block at a time: they are folded into a triangle, and that is solved."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.compiled import kernel, njit

Array = NDArray[np.float64]

# Rows that are folded into the triangle at once: long enough for the loops, short enough for the nearest cache.
BLOCK = 64
# A column of which less than this share is left beside the others depends on them.
DEPENDENT = 1e-13


# Sums may be taken in any order, so that the loops use the processor's vectors.
@kernel(fastmath={"reassoc", "contract"})
def fold(triangle: Array, block: Array, rows: int) -> None:
    """Householder reflections that fold ``rows`` rows, the columns of ``block``, into an upper triangle."""
    size = triangle.shape[0]
    for j in range(size):
        pivot = triangle[j, j]
        below = 0.0
        for i in range(rows):
            below += block[j, i] * block[j, i]
        if below == 0.0:
            continue
        length = np.sqrt(pivot * pivot + below)
        diagonal = -length if pivot > 0.0 else length
        head = pivot - diagonal
        scale = 1.0 / (diagonal * head)  # minus two over the squared length of the reflection's vector
        triangle[j, j] = diagonal
        for k in range(j + 1, size):
            total = head * triangle[j, k]
            for i in range(rows):
                total += block[j, i] * block[k, i]
            total *= scale
            triangle[j, k] += total * head
            for i in range(rows):
                block[k, i] += total * block[j, i]


@njit
def solve(  # noqa: C901, PLR0912 - compiled as one
    triangle: Array, chosen: NDArray[np.int64]
) -> tuple[Array, float, float, float]:
    """Least squares of the last column on the chosen ones, by modified Gram–Schmidt.

    A column that depends on those before it gets the coefficient zero.

    Returns
    -------
    solution : ndarray, shape (len(chosen),)
    cost : float
        Sum of squares that is left; infinite where it overflows.
    effect : float
        Length of what the chosen columns explain.
    independence : float
        Smallest share of a column's length that those before it leave; one is orthogonal.
    """
    size, count = triangle.shape[0], len(chosen)
    table = np.empty((count, size))
    target = np.empty(size)
    for i in range(size):
        for j in range(count):
            table[j, i] = triangle[i, chosen[j]]
        target[i] = triangle[i, size - 1]
    upper = np.zeros((count, count))
    projected = np.zeros(count)
    independence, effect = 1.0, 0.0
    for j in range(count):
        whole, length = 0.0, 0.0
        for i in range(size):
            whole += triangle[i, chosen[j]] ** 2
            length += table[j, i] ** 2
        share = np.sqrt(length / whole) if whole > 0.0 else 0.0
        if not share >= independence:
            independence = share
        if not share > DEPENDENT:
            continue
        upper[j, j] = np.sqrt(length)
        for i in range(size):
            table[j, i] /= upper[j, j]
            projected[j] += table[j, i] * target[i]
        effect += projected[j] ** 2
        for i in range(size):
            target[i] -= projected[j] * table[j, i]
        for later in range(j + 1, count):
            for i in range(size):
                upper[j, later] += table[j, i] * table[later, i]
            for i in range(size):
                table[later, i] -= upper[j, later] * table[j, i]
    solution = np.zeros(count)
    for j in range(count - 1, -1, -1):
        if upper[j, j] > 0.0:
            solution[j] = projected[j]
            for later in range(j + 1, count):
                solution[j] -= upper[j, later] * solution[later]
            solution[j] /= upper[j, j]
    cost = 0.0
    for i in range(size):
        cost += target[i] ** 2
    return solution, cost if np.isfinite(cost) else np.inf, np.sqrt(effect), independence
