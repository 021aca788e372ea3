"""Exponentials of small matrices and their integrals, compiled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.compiled import njit

Array = NDArray[np.float64]


@njit
def multiply(left: Array, right: Array, product: Array) -> None:
    """Product of small square matrices; a call of BLAS costs more than their few hundred multiplications."""
    size = left.shape[0]
    for i in range(size):
        for j in range(size):
            product[i, j] = 0.0
        for k in range(size):
            factor = left[i, k]
            if factor != 0.0:
                for j in range(size):
                    product[i, j] += factor * right[k, j]


@njit
def _copy(source: Array, target: Array) -> None:
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]


@njit
def _norm(matrix: Array, duration: float) -> float:
    """Largest sum of absolute values in a row of F h."""
    norm = 0.0
    for i in range(matrix.shape[0]):
        total = 0.0
        for j in range(matrix.shape[1]):
            total += abs(matrix[i, j])
        norm = max(norm, total * duration)
    return norm


@njit
def _series(matrix: Array, step: float, exponential: Array, integral: Array, product: Array) -> None:
    """Exp(F s) and its integral over [0, s] divided by s, for ‖F s‖ ≤ 1/2, by their Taylor series."""
    size = matrix.shape[0]
    term, scaled = np.zeros((size, size)), np.empty((size, size))
    for i in range(size):
        exponential[i, i] = integral[i, i] = term[i, i] = 1.0
        for j in range(size):
            scaled[i, j] = matrix[i, j] * step
    for k in range(1, 15):  # 0.5**15 / 15! lies below the rounding error
        multiply(term, scaled, product)
        for i in range(size):
            for j in range(size):
                term[i, j] = product[i, j] / k
                exponential[i, j] += term[i, j]
                integral[i, j] += term[i, j] / (k + 1)


@njit
def exponential_and_integral(matrix: Array, duration: float) -> tuple[Array, Array]:
    """Exp(F h) and its integral over [0, h], by a Taylor series of a halved duration and doubling.

    Doubling keeps the integral as exact as the exponential even where F is singular, which a formula with the inverse
    of F would not. Loops over elements, because numba takes ten times as long to compile expressions of whole arrays.
    """
    size = matrix.shape[0]
    exponential, integral = np.zeros((size, size)), np.zeros((size, size))
    norm = _norm(matrix, duration)
    if not np.isfinite(norm):
        for i in range(size):
            for j in range(size):
                exponential[i, j] = integral[i, j] = np.nan
        return exponential, integral
    halvings = 0
    while norm > 0.5:
        norm *= 0.5
        halvings += 1
    step = duration / 2.0**halvings
    product = np.empty((size, size))
    _series(matrix, step, exponential, integral, product)
    for i in range(size):
        for j in range(size):
            integral[i, j] *= step
    for _ in range(halvings):
        multiply(exponential, integral, product)
        for i in range(size):
            for j in range(size):
                integral[i, j] += product[i, j]
        multiply(exponential, exponential, product)
        _copy(product, exponential)
    return exponential, integral


@njit
def mean(matrix: Array, duration: float) -> Array:
    """Mean of exp(F t) over [0, h]."""
    _, integral = exponential_and_integral(matrix, duration)
    return divided(integral, duration)


@njit
def divided(matrix: Array, divisor: float) -> Array:
    """Quotient of a square matrix and a number."""
    size = matrix.shape[0]
    result = np.empty((size, size))
    for i in range(size):
        for j in range(size):
            result[i, j] = matrix[i, j] / divisor
    return result
