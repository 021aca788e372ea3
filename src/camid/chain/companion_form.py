"""The companion form of a plant's denominator, in a unit of time in which its coefficients are of the order of one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def companion(denominator: Array) -> Array:
    """Companion matrix of a monic polynomial, shape (n, n), for the states z^(n-1), …, z' and z of z = u / A."""
    coefficients = np.asarray(denominator, dtype=float)
    return np.eye(len(coefficients) - 1, k=-1) - np.outer(np.eye(len(coefficients) - 1)[0], coefficients[1:])


def time_scale(denominator: tuple[float, ...] | Array) -> float:
    """Time unit in seconds in which the coefficients of a monic denominator are of the order of one."""
    coefficients = np.abs(np.asarray(denominator, dtype=float))
    radii = [c ** (1.0 / i) for i, c in enumerate(coefficients) if i > 0 and c > 0.0]
    return 1.0 / max(radii) if radii else 1.0


def derivative_rows(denominator: Array, degrees: range | list[int]) -> Array:
    """Rows that pick the derivatives z^(degree) of z = u / A out of the companion states and the input.

    Returns
    -------
    ndarray, shape (len(degrees), n + 1)
    """
    order = len(denominator) - 1
    rows = np.zeros((len(degrees), order + 1))
    for row, degree in zip(rows, degrees, strict=True):
        if degree == order:  # z^(n) = u - a_1 z^(n-1) - … - a_n z
            row[:order] = -np.asarray(denominator, dtype=float)[1:]
            row[order] = 1.0
        else:
            row[order - 1 - degree] = 1.0
    return rows
