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
from camid.chain.companion_form import companion, derivative_rows, time_scale
from camid.chain.hold import driven
from camid.chain.matrix_exponential import divided, exponential_and_integral, mean, multiply
from camid.chain.plant import TransferFunction
from camid.compiled import kernel, njit

Array = NDArray[np.float64]


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
    transition, integral = exponential_and_integral(augmented, period)
    second = np.zeros((size, size))
    if start == 0.0 and length == period:
        return transition, divided(integral, length), second
    # The exponential of a time of zero is the identity.
    onset, _ = exponential_and_integral(augmented, start)
    if length == 0.0:
        return transition, onset, second
    first = np.empty((size, size))
    if not straddles:
        multiply(mean(augmented, length), onset, first)
        return transition, first, second
    multiply(divided(exponential_and_integral(augmented, period - start)[1], length), onset, first)
    second = divided(exponential_and_integral(augmented, start + length - period)[1], length)
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
