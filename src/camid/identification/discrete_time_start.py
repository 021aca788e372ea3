"""Starting values from a discrete-time model, and the continuous-time modes that look alike when sampled."""

from __future__ import annotations

from functools import reduce
from itertools import islice, product
from math import hypot

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import polynomial_roots
from camid.compiled import njit
from camid.identification.experiment import Experiment
from camid.identification.least_squares import BLOCK, fold

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

# How far past the Shannon frequency π/T a mode is looked for, in units of π/T: a held input leaves no alias.
HIGHEST_FREQUENCY = 2.6
MOST_ALIAS_COMBINATIONS = 64
STEIGLITZ_MCBRIDE_ITERATIONS = 12
# Largest change of a coefficient of the denominator from one iteration to the next that ends them.
COEFFICIENT_TOLERANCE = 1e-5


@njit
def _filter(
    signal: Array, output: Array, denominator: Array, filtered_signal: Array, filtered_output: Array, order: int
) -> None:
    """Signal and output through the all-pole filter 1/A(z⁻¹), from rest, into the given arrays."""
    for k in range(len(output)):
        at_input, at_output = signal[k], output[k]
        for i in range(1, min(order, k) + 1):
            at_input -= denominator[i] * filtered_signal[k - i]
            at_output -= denominator[i] * filtered_output[k - i]
        filtered_signal[k], filtered_output[k] = at_input, at_output


@njit
def _regression(
    signal: Array, output: Array, used: NDArray[np.bool_], order: int, first_lag: int, lags: int, triangle: Array
) -> bool:
    """Fold the regression of the output on its past and on lagged inputs into a triangle; whether that is finite."""
    columns = order + lags
    block = np.zeros((columns + 1, BLOCK))
    filled = 0
    for k in range(max(order, first_lag + lags - 1), len(output)):
        if not used[k]:
            continue
        for i in range(order):
            block[i, filled] = -output[k - 1 - i]
        for i in range(lags):
            block[order + i, filled] = signal[k - first_lag - i]
        block[columns, filled] = output[k]
        filled += 1
        if filled == BLOCK:
            fold(triangle, block, filled)
            filled = 0
    fold(triangle, block, filled)
    for i in range(columns + 1):
        for j in range(columns + 1):
            if not np.isfinite(triangle[i, j]):
                return False
    return True


def _steiglitz_mcbride(
    signal: Array, output: Array, used: NDArray[np.bool_], order: int, first_lag: int, lags: int, iterations: int
) -> Array:
    """Denominators in z⁻¹, shape (iterations done, n + 1): the first is ARX, the last Steiglitz–McBride's."""
    from scipy.linalg.lapack import dgelsd, dgelsd_lwork

    denominator = np.zeros(order + 1)
    denominator[0] = 1.0
    found: list[Array] = []
    filtered_signal, filtered_output = signal.copy(), output.copy()
    columns = order + lags
    work, integer_work, _ = dgelsd_lwork(columns + 1, columns, 1, 1e-14)
    for _ in range(iterations):
        _filter(signal, output, denominator, filtered_signal, filtered_output, order)
        triangle = np.zeros((columns + 1, columns + 1))
        if not _regression(filtered_signal, filtered_output, used, order, first_lag, lags, triangle):
            break
        solution, _, _, failed = dgelsd(triangle[:, :columns], triangle[:, columns], int(work), integer_work, 1e-14)
        if failed:
            raise np.linalg.LinAlgError("SVD did not converge.")
        polynomial = _reflected(solution.ravel()[:order])
        change = np.max(np.abs(polynomial - denominator))
        denominator = polynomial
        found.append(denominator)
        if not np.all(np.isfinite(denominator)):
            found.pop()
            break
        if change < COEFFICIENT_TOLERANCE:
            break
    return np.array(found).reshape(len(found), order + 1)


def _reflected(coefficients: Array) -> Array:
    """Monic polynomial with the given lower coefficients, its roots outside the unit circle reflected into it.

    Raises
    ------
    numpy.linalg.LinAlgError
        If a coefficient is not finite, or the eigenvalues do not converge.
    """
    from scipy.linalg.lapack import zgeev

    order = len(coefficients)
    if not np.all(np.isfinite(coefficients)):
        raise np.linalg.LinAlgError("Array must not contain infs or NaNs.")
    matrix = np.zeros((order, order), dtype=np.complex128, order="F")
    matrix[0] = -coefficients
    for i in range(order - 1):
        matrix[i + 1, i] = 1.0
    roots, _, _, failed = zgeev(matrix, 0, 0, overwrite_a=1)
    if failed:
        raise np.linalg.LinAlgError("Eigenvalues did not converge.")
    polynomial = [1.0 + 0.0j] + [0.0j] * order
    for root in roots.tolist():
        stable = 1.0 / root.conjugate() if hypot(root.real, root.imag) > 1.0 else root  # the filter must be stable
        polynomial = [polynomial[0], *(polynomial[i] - stable * polynomial[i - 1] for i in range(1, order + 1))]
    return np.array([each.real for each in polynomial])


def discrete_time_poles(experiment: Experiment, order: int) -> list[ComplexArray]:
    """Poles of discrete-time models: ARX (exact on clean data), then Steiglitz–McBride (consistent in white noise)."""
    delay, _, _, straddles = experiment.acquisition.window()
    lags = range(max(delay - 2, 0), delay + order + 1 + straddles)
    count = len(experiment.output)
    if count - max(order, lags[-1]) < 2 * (order + len(lags)):
        return []
    if not np.any(experiment.signal):
        lags = range(0)
    signal, output = experiment.for_regression()
    found = _steiglitz_mcbride(
        signal,
        output,
        experiment.used,
        order,
        lags.start,
        len(lags),
        STEIGLITZ_MCBRIDE_ITERATIONS,
    )
    return [polynomial_roots(d) for d in found[[0, -1]] if d[-1] != 0.0] if len(found) else []


def continuous_denominators(poles: ComplexArray, period: float, *, aliases: bool) -> list[Array]:
    """Monic denominators in SI units whose sampled poles are the given ones.

    A complex pair at the angle φ may be a mode at φ/T, (2π − φ)/T, (2π + φ)/T, …; a negative real pole can only come
    from a mode at π/T.
    """
    choices: list[list[Array]] = []
    negative = [z for z in poles if abs(z.imag) < 1e-9 and z.real <= 0.0]
    for z in poles:
        if z.imag > 1e-9:
            angle = float(np.angle(z))
            choices.append(_modes(np.log(abs(z)), alias_angles(angle) if aliases else [angle], period))
        elif abs(z.imag) <= 1e-9 and z.real > 0.0:
            choices.append([np.array([1.0, -np.log(max(z.real, 1e-12)) / period])])
    while len(negative) >= 2:
        first, second = negative.pop(), negative.pop()
        angles = [0.9 * np.pi, np.pi] if not aliases else list(np.arange(0.6, 2.5, 0.2) * np.pi)
        choices.append(_modes(0.5 * np.log(max(abs(first * second), 1e-12)), angles, period))
    if negative:
        choices.append([np.array([1.0, 3.0 / period])])
    return [reduce(np.convolve, c) for c in islice(product(*choices), MOST_ALIAS_COMBINATIONS)]


def _modes(real: float, angles: list[float], period: float) -> list[Array]:
    """Denominators of modes whose poles have the real part ``real``/T and the given angles in a period."""
    return [np.array([1.0, -2.0 * real / period, (real**2 + angle**2) / period**2]) for angle in angles]


def alias_angles(angle: float) -> list[float]:
    """Angles in a period, up to the highest looked for, that a sampled mode at the given angle may have, ascending."""
    folded = abs((angle + np.pi) % (2.0 * np.pi) - np.pi)
    turns = range(int(np.ceil(HIGHEST_FREQUENCY / 2.0)) + 1)
    every = {2.0 * np.pi * turn + sign * folded for turn in turns for sign in (-1.0, 1.0)}
    # A folded mode is heard wherever it lies, its slower and faster twins up to the limit.
    return sorted(a for a in every if 0.0 <= a <= HIGHEST_FREQUENCY * np.pi or a == folded)


def alias_denominators(poles: ComplexArray, period: float) -> list[Array]:
    """Denominators of the same sampled poles with modes moved to their aliases, the given one left out."""
    choices = []
    for pole in poles:
        if pole.imag > 0.0:
            here = pole.imag * period
            # The mode itself comes first, so the first combination is the one that is known.
            angles = [here, *(a for a in alias_angles(here) if not np.isclose(a, here))]
            choices.append(_modes(pole.real * period, angles, period))
        elif pole.imag == 0.0:
            choices.append([np.array([1.0, -pole.real])])
    return [reduce(np.convolve, c) for c in islice(product(*choices), 1, MOST_ALIAS_COMBINATIONS)]
