"""Simulated output, sensitivities and their QR factorisation in one pass over the samples.

An iteration of identification needs of the sensitivities J and the residual r nothing but the triangle R of
[J r] = Q R: every normal equation, covariance and cost follows from it. The rows are made by running the chain and
folded into R a block at a time, so memory does not grow with the recording, and neither does the time of a sample.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.chain.exact import input_at_start, sampling_matrices
from camid.compiled import kernel, njit
from camid.identification.companion_system import companion_system
from camid.identification.least_squares import BLOCK, fold
from camid.identification.records import Records

Array = NDArray[np.float64]

# What a coefficient of an initial state, in scaled time, leaves in place of itself: part of a state that has decayed
# before the first row that is compared would else be anything, and rounding errors of it noise in all rows.
LOOSELY = 1e-6


@kernel
def _clear(block: Array, first: int, last: int) -> None:
    """Set rows to zero, from the first up to the last, which is left out."""
    for i in range(first, last):
        for j in range(block.shape[1]):
            block[i, j] = 0.0


class _Sampled(NamedTuple):
    """An experiment's chain from sample to sample.

    Attributes
    ----------
    transition : ndarray, shape (q + 2, q + 2)
        State after a period; the last two states are the input and its slope.
    first, second : ndarray, shape (o, q + 2)
        What the sensor sees of the outputs: ``first @ now + second @ following``.
    start : ndarray, shape (q + 2,)
        What the state gains where the free motion begins.
    now, following : ndarray, shape (q + 2,)
        Room for the state.
    period : float
        In scaled time.
    """

    transition: Array
    first: Array
    second: Array
    start: Array
    now: Array
    following: Array
    period: float


class _Places(NamedTuple):
    """Where the output rows of an experiment go: the columns of [∂x/∂θ, w − x], one after the other.

    Attributes
    ----------
    outputs, coefficients : int
        Output rows up to the last derivative that is wanted, and up to that by the last coefficient.
    initial, bias, offset : int
        First column of the experiment's initial polynomial, and columns of bias and offset.
    """

    outputs: int
    coefficients: int
    initial: int
    bias: int
    offset: int


@kernel(forceinline=True)
def _seen(system: _Sampled, row: int, straddles: bool) -> float:
    """What the sensor sees of an output."""
    total = 0.0
    for column in range(len(system.now)):
        total += system.first[row, column] * system.now[column]
    if straddles:
        for column in range(len(system.now)):
            total += system.second[row, column] * system.following[column]
    return total


@kernel(forceinline=True)
def _enter(
    block: Array, filled: int, system: _Sampled, straddles: bool, places: _Places, biased: bool, offset: bool
) -> None:
    """Fill a row of the block with the sensitivities of a frame."""
    rows = len(system.first)
    for row in range(1, rows):
        if places.outputs <= row < places.coefficients:
            continue
        if biased and row == rows - 1:
            column = places.bias
        elif row < places.coefficients:
            column = row - 1
        else:
            column = places.initial + row - places.coefficients
        block[column, filled] = _seen(system, row, straddles)
    if offset:
        block[places.offset, filled] = 1.0


@kernel
def _run_experiment(
    e: int,
    system: _Sampled,
    records: Records,
    offset: float,
    places: _Places,
    triangle: Array,
    block: Array,
    residual: Array,
    cost: float,
) -> float:
    """Run experiment ``e``, fold its rows into the triangle, fill its residual and add its squares to the cost."""
    now, following, transition, period = system.now, system.following, system.transition, system.period
    size = len(now) - 2
    straddles, delay = records.straddles[e], records.delay[e]
    first_order, first_row = records.first_order[e], records.offsets[e]
    count = records.offsets[e + 1] - first_row
    begins_moving = -delay if records.early[e] else 0
    filled = 0
    _clear(block, 0, len(block))
    for j in range(-delay, count - delay):
        if j == begins_moving:
            for row in range(size):
                now[row] += system.start[row]
        now[size], now[size + 1] = input_at_start(records.signal, first_row, count, j, first_order, period)
        for row in range(size):
            total = 0.0
            for column in range(size + 2):
                total += transition[row, column] * now[column]
            following[row] = total
        if straddles:
            following[size], following[size + 1] = input_at_start(
                records.signal, first_row, count, j + 1, first_order, period
            )
        frame = first_row + j + delay
        residual[frame] = records.output[frame] - _seen(system, 0, straddles) - offset
        if records.used[frame]:
            _enter(block, filled, system, straddles, places, records.input_bias, records.sensor_offset)
            block[len(block) - 1, filled] = residual[frame]
            cost += residual[frame] * residual[frame]
            filled += 1
            if filled == BLOCK:
                fold(triangle, block, filled)
                filled = 0
                _clear(block, places.coefficients - 1, len(block) - 1)
        for row in range(size):
            now[row] = following[row]
    # The columns of one experiment's initial state are zero in the rows of the others.
    fold(triangle, block, filled)
    return cost


@kernel
def _hold_loosely(initial: Array, count: int, first: int, triangle: Array, block: Array) -> float:
    """Fold a row for each of the first ``count`` coefficients into the triangle; the sum of squares of what they leave.

    They stand in the columns from ``first`` on.
    """
    cost = 0.0
    for i in range(count):
        _clear(block, 0, len(block))
        block[first + i, 0] = LOOSELY
        block[len(block) - 1, 0] = -LOOSELY * initial[i]
        cost += (LOOSELY * initial[i]) ** 2
        fold(triangle, block, 1)
    return cost


@njit
def factorise(
    numerator: Array,
    denominator: Array,
    initial: Array,
    records: Records,
    time_unit: float,
    sensitive: bool,
    residual: Array,
) -> tuple[Array, float]:
    """Run a plant through hold and sensor and factorise its sensitivities.

    Parameters
    ----------
    numerator, denominator : ndarray, shapes (m + 1,) and (n + 1,)
        In scaled time, monic denominator.
    initial : ndarray, shape (q,)
        Initial polynomials, n coefficients for each experiment with unknown initial state, concatenated; then the bias
        of the input and the offset of the sensor, where they are unknown.
    records : Records
    time_unit : float
        Seconds in a unit of the scaled time.
    sensitive : bool
        Whether the derivatives by the denominator are wanted; their columns are zero otherwise.
    residual : ndarray, shape (total,)
        Filled with recorded minus simulated output, rows that are not used included.

    Returns
    -------
    triangle : ndarray, shape (p + 1, p + 1)
        R of the QR factorisation of [∂x/∂θ, w − x] on the used rows.
    cost : float
        Sum of squared residuals; infinite where it overflows.
    """
    order, split = len(denominator) - 1, len(numerator)
    columns = split + order + len(initial)
    offset_column, biased = columns - 1, records.input_bias
    bias_column = offset_column - 1 if records.sensor_offset else offset_column
    offset = initial[len(initial) - 1] if records.sensor_offset else 0.0
    bias = initial[bias_column - split - order] if biased else 0.0
    triangle = np.zeros((columns + 1, columns + 1))
    block = np.zeros((columns + 1, BLOCK))
    position, cost = 0, 0.0
    outputs, coefficients = 1 + split + (order if sensitive else 0), 1 + split + order
    for e in range(len(records.offsets) - 1):
        estimated = records.initial[e]
        augmented, start, rows = companion_system(
            numerator, denominator, initial[position : position + order], bias, estimated, biased, sensitive
        )
        places = _Places(outputs, coefficients, split + order + position, bias_column, offset_column)
        period, straddles = records.period[e] / time_unit, records.straddles[e]
        transition, first, second = sampling_matrices(
            augmented, period, records.start[e] / time_unit, records.length[e] / time_unit, straddles
        )
        now, following = np.zeros(len(start)), np.zeros(len(start))
        system = _Sampled(transition, rows @ first, rows @ second, start, now, following, period)
        cost = _run_experiment(e, system, records, offset, places, triangle, block, residual, cost)
        if estimated:
            position += order
    cost += _hold_loosely(initial, position, split + order, triangle, block)
    if not np.isfinite(cost):
        cost = np.inf
    return triangle, cost
