"""The chain hold → plant → sensor, run exactly: matrix exponentials, no step size anywhere.

The plant is augmented with the integrator of the paper's Fig. 4, so that the camera's average over the exposure is a
difference of integrals and as exact as the state itself. Because input and sensor are linear, the average of *every*
state comes at the same price, and with it the regressors, instruments and sensitivities of identification.

Time convention: frame k is delivered at t_k; w_k = (1/τ)∫ y dt over [t_k − ℓ − τ, t_k − ℓ] (instant sensor:
y(t_k − ℓ)); u_k is applied from t_k to t_{k+1}, held (zoh) or along a straight line to u_{k+1} (foh); before the first
sample u = 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.compiled import kernel, njit

Array = NDArray[np.float64]


@njit
def _multiply(left: Array, right: Array, product: Array) -> None:
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
        _multiply(term, scaled, product)
        for i in range(size):
            for j in range(size):
                term[i, j] = product[i, j] / k
                exponential[i, j] += term[i, j]
                integral[i, j] += term[i, j] / (k + 1)


@njit
def _exponential_and_integral(matrix: Array, duration: float) -> tuple[Array, Array]:
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
        _multiply(exponential, integral, product)
        for i in range(size):
            for j in range(size):
                integral[i, j] += product[i, j]
        _multiply(exponential, exponential, product)
        _copy(product, exponential)
    return exponential, integral


@njit
def _mean(matrix: Array, duration: float) -> Array:
    """Mean of exp(F t) over [0, h]."""
    _, integral = _exponential_and_integral(matrix, duration)
    return _divided(integral, duration)


@njit
def _divided(matrix: Array, divisor: float) -> Array:
    size = matrix.shape[0]
    result = np.empty((size, size))
    for i in range(size):
        for j in range(size):
            result[i, j] = matrix[i, j] / divisor
    return result


@njit
def sampling_matrices(
    augmented: Array, period: float, start: float, length: float, straddles: bool
) -> tuple[Array, Array, Array]:
    """What a linear system does in a period, and what the sensor sees of it.

    Parameters
    ----------
    augmented : ndarray, shape (p + 2, p + 2)
        State matrix with the input and its slope as the last two states, so that one exponential serves both holds.
    period, start, length : float
        Sampling period, and start and length of the sensor's window, in the time unit of the matrix.
    straddles : bool
        Whether the window ends in the next interval of the input.

    Returns
    -------
    transition, first, second : ndarray, shape (p + 2, p + 2)
        State after a period; the sensor's output for every state is ``first @ now + second @ following``.
    """
    size = augmented.shape[0]
    transition, integral = _exponential_and_integral(augmented, period)
    second = np.zeros((size, size))
    if start == 0.0 and length == period:
        return transition, _divided(integral, length), second
    # The exponential of a time of zero is the identity.
    onset, _ = _exponential_and_integral(augmented, start)
    if length == 0.0:
        return transition, onset, second
    first = np.empty((size, size))
    if not straddles:
        _multiply(_mean(augmented, length), onset, first)
        return transition, first, second
    _multiply(_divided(_exponential_and_integral(augmented, period - start)[1], length), onset, first)
    second = _divided(_exponential_and_integral(augmented, start + length - period)[1], length)
    return transition, first, second


@kernel
def input_at_start(
    signal: Array, first: int, count: int, j: int, first_order: bool, period: float
) -> tuple[float, float]:
    """Input and its slope at the start of interval j of a record that starts at ``signal[first]``; zero outside it."""
    if j < 0 or j >= count:
        return 0.0, 0.0
    value = signal[first + j]
    if first_order and j + 1 < count:
        return value, (signal[first + j + 1] - value) / period
    return value, 0.0


@njit
def _run(
    state_matrix: Array,
    input_vector: Array,
    initial_state: Array,
    selection: Array,
    signal: Array,
    first_order: bool,
    period: float,
    delay: int,
    start: float,
    length: float,
    straddles: bool,
    first_interval: int,
) -> Array:
    """Sampled sensor outputs of a linear system with one held input; see :func:`respond`."""
    order = state_matrix.shape[0]
    outputs, count = selection.shape[0], signal.shape[0]
    augmented = np.zeros((order + 2, order + 2))
    for i in range(order):
        augmented[i, order] = input_vector[i]
        for k in range(order):
            augmented[i, k] = state_matrix[i, k]
    augmented[order, order + 1] = 1.0
    transition, window, late_window = sampling_matrices(augmented, period, start, length, straddles)
    first = selection @ window[: order + 1]
    second = selection @ late_window[: order + 1]

    result = np.zeros((count, outputs))
    now = np.zeros(order + 2)
    following = np.zeros(order + 2)
    for j in range(-delay, count - delay):
        if j == first_interval:
            for row in range(order):
                now[row] += initial_state[row]
        now[order], now[order + 1] = input_at_start(signal, 0, count, j, first_order, period)
        for row in range(order):
            total = 0.0
            for column in range(order + 2):
                total += transition[row, column] * now[column]
            following[row] = total
        following[order], following[order + 1] = input_at_start(signal, 0, count, j + 1, first_order, period)
        frame = j + delay
        for row in range(outputs):
            total = 0.0
            for column in range(order + 2):
                total += first[row, column] * now[column]
            if straddles:
                for column in range(order + 2):
                    total += second[row, column] * following[column]
            result[frame, row] = total
        for row in range(order):
            now[row] = following[row]
    return result


def straight_line_corners(signal: Array) -> Array:
    """Corners of straight lines that hold the same below π/T as the band-limited signal through the given samples.

    Straight lines between samples attenuate by sinc²(ωT/2), so that the samples are amplified by the inverse of it, in
    the cosine transform of the record (mirrored at its ends). What is left to be wrong are the images of the input
    above π/T, of the relative size (ω/(2π/T - ω))², which a plant with more poles than zeros attenuates further.

    Parameters
    ----------
    signal : ndarray, shape (N,)

    Returns
    -------
    ndarray, shape (N,)
    """
    from scipy.fft import dct, idct

    values = np.asarray(signal, dtype=float)
    # np.sinc(x) is sin(πx)/(πx); the k-th cosine has ωT/2 = πk/(2N).
    loss = np.sinc(0.5 * np.arange(len(values)) / len(values)) ** 2
    return np.asarray(idct(dct(values) / loss), dtype=np.float64)


def driven(signal: Array, hold: str) -> tuple[Array, bool]:
    """Samples as the compiled code takes them, and whether straight lines join them.

    Parameters
    ----------
    signal : ndarray, shape (N,)
    hold : {"zoh", "foh", "band-limited"}
    """
    if hold == "band-limited":
        return straight_line_corners(signal), True
    return signal, hold == "foh"


def respond(
    state_matrix: Array,
    input_vector: Array,
    initial_state: Array,
    selection: Array,
    signal: Array,
    acquisition: Acquisition,
    time_unit: float = 1.0,
    *,
    before_record: bool = True,
) -> Array:
    """Run dX/dt' = A X + B u through the hold and the sensor.

    Parameters
    ----------
    state_matrix : ndarray, shape (p, p)
        In units of ``1/time_unit``: t' = t / time_unit.
    input_vector, initial_state : ndarray, shape (p,)
        The input is zero before t_0.
    selection : ndarray, shape (q, p + 1)
        Rows that pick the wanted combinations of states and (last column) input, after the sensor.
    signal : ndarray, shape (N,)
        Input samples u_k.
    acquisition : Acquisition
    time_unit : float
        Seconds in a unit of the scaled time.
    before_record : bool
        Whether the initial state is that at t_0 - delay·T, where the interval begins in which the first frame was
        exposed, or that at t_0. The second leaves the frames that were exposed before t_0 without free motion.

    Returns
    -------
    ndarray, shape (N, q)
        Row k belongs to frame k.
    """
    delay, start, length, straddles = acquisition.window()
    signal, first_order = driven(signal, acquisition.hold)
    return _run(
        np.ascontiguousarray(state_matrix, dtype=np.float64),
        np.ascontiguousarray(input_vector, dtype=np.float64),
        np.ascontiguousarray(initial_state, dtype=np.float64),
        np.ascontiguousarray(selection, dtype=np.float64),
        np.ascontiguousarray(signal, dtype=np.float64),
        first_order,
        acquisition.period / time_unit,
        delay,
        start / time_unit,
        length / time_unit,
        straddles,
        -delay if before_record else 0,
    )


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


def sample(
    plant: TransferFunction, signal: Array, acquisition: Acquisition, initial_state: Array | None = None
) -> Array:
    """Output samples of a plant between a hold and a sensor, exact to rounding.

    Parameters
    ----------
    plant : TransferFunction
    signal : ndarray, shape (N,)
        Input samples u_k, in the units of u.
    acquisition : Acquisition
    initial_state : ndarray, shape (n,), optional
        Coefficients of the initial polynomial C(s'), highest power first, so that C/A is the free motion that begins
        where :func:`respond` says, with s' in units of ``1/time_scale``; at rest where it is not given.

    Returns
    -------
    ndarray, shape (N,)
        w_k, in the units of y.
    """
    monic = plant.monic
    signal = np.asarray(signal, dtype=float)
    unit = time_scale(monic.denominator)
    order, degree = monic.order, len(monic.numerator) - 1
    if order == 0:
        return (
            monic.numerator[0]
            * respond(np.zeros((0, 0)), np.zeros(0), np.zeros(0), np.ones((1, 1)), signal, acquisition)[:, 0]
        )
    denominator = np.asarray(monic.denominator) * unit ** np.arange(order + 1)
    numerator = np.asarray(monic.numerator) * unit ** (order - degree + np.arange(degree + 1.0))
    selection = numerator @ derivative_rows(denominator, range(degree, -1, -1))
    forced = respond(
        companion(denominator), np.eye(order)[0], np.zeros(order), selection[None, :], signal, acquisition, unit
    )[:, 0]
    if initial_state is None:
        return forced
    free = np.append(np.asarray(initial_state, dtype=float), 0.0)
    return (
        forced
        + respond(companion(denominator), np.zeros(order), np.eye(order)[0], free[None, :], signal, acquisition, unit)[
            :, 0
        ]
    )
