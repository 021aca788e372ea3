"""Simulated output, sensitivities and their QR factorisation in one pass over the samples.

An iteration of identification needs of the sensitivities J and the residual r nothing but the triangle R of
[J r] = Q R: every normal equation, covariance and cost follows from it. The rows are made by running the chain and
folded into R a block at a time, so memory does not grow with the recording, and neither does the time of a sample.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.chain.exact import driven, input_at_start, sampling_matrices
from camid.compiled import njit

if TYPE_CHECKING:
    from camid.identification.experiment import Experiment

Array = NDArray[np.float64]

# Rows that are folded into the triangle at once: long enough for the loops, short enough for the nearest cache.
BLOCK = 64
# A column of which less than this share is left beside the others depends on them.
DEPENDENT = 1e-13


class Records(NamedTuple):
    """Experiments, concatenated, as compiled code takes them.

    Attributes
    ----------
    signal, output : ndarray, shape (total,)
    used : ndarray of bool, shape (total,)
    offsets : ndarray of int, shape (E + 1,)
        Rows of experiment e: ``offsets[e]`` up to ``offsets[e + 1]``.
    first_order, straddles, early, initial : ndarray of bool, shape (E,)
        First-order hold; window in two intervals; initial state that of the first exposure; initial state unknown.
    period, start, length : ndarray, shape (E,)
        In seconds, see :meth:`camid.chain.acquisition.Acquisition.window`.
    delay : ndarray of int, shape (E,)
    input_bias, sensor_offset : bool
        Whether a constant that is added to all inputs, or to all outputs, is unknown.
    """

    signal: Array
    output: Array
    used: NDArray[np.bool_]
    offsets: NDArray[np.int64]
    first_order: NDArray[np.bool_]
    straddles: NDArray[np.bool_]
    early: NDArray[np.bool_]
    initial: NDArray[np.bool_]
    period: Array
    start: Array
    length: Array
    delay: NDArray[np.int64]
    input_bias: bool
    sensor_offset: bool

    @classmethod
    def of(cls, experiments: Sequence[Experiment]) -> Records:
        """Pack experiments."""
        windows = [e.acquisition.window() for e in experiments]
        inputs = [driven(e.signal, e.acquisition.hold) for e in experiments]
        return cls(
            np.concatenate([signal for signal, _ in inputs], dtype=np.float64),
            np.concatenate([e.position for e in experiments], dtype=np.float64),
            np.concatenate([e.used for e in experiments]),
            np.cumsum([0, *(len(e.output) for e in experiments)]),
            np.array([first_order for _, first_order in inputs]),
            np.array([w[3] for w in windows]),
            np.array([e.free_motion_before_record for e in experiments]),
            np.array([e.estimate_initial_state for e in experiments]),
            np.array([e.acquisition.period for e in experiments]),
            np.array([w[1] for w in windows]),
            np.array([w[2] for w in windows]),
            np.array([w[0] for w in windows]),
            any(e.estimate_bias for e in experiments),
            any(e.estimate_offset for e in experiments),
        )

    def linear_unknowns(self, order: int) -> int:
        """How many numbers beside the coefficients are fitted: initial polynomials, bias and offset."""
        return order * int(self.initial.sum()) + int(self.input_bias) + int(self.sensor_offset)


# Sums may be taken in any order, so that the loops use the processor's vectors.
@njit(fastmath={"reassoc", "contract"})
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
def _companion_system(  # noqa: C901, PLR0912 - loops over elements, which compile fastest
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


@njit
def _clear(block: Array, first: int, last: int) -> None:
    """Set rows to zero, from the first up to the last, which is left out."""
    for i in range(first, last):
        for j in range(block.shape[1]):
            block[i, j] = 0.0


@njit
def factorise(  # noqa: C901, PLR0912, PLR0915 - one loop over the samples, so that it compiles to one
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
    filled, position, cost = 0, 0, 0.0
    for e in range(len(records.offsets) - 1):
        estimated = records.initial[e]
        augmented, start, rows = _companion_system(
            numerator, denominator, initial[position : position + order], bias, estimated, biased, sensitive
        )
        size = len(start) - 2
        period = records.period[e] / time_unit
        transition, first, second = sampling_matrices(
            augmented, period, records.start[e] / time_unit, records.length[e] / time_unit, records.straddles[e]
        )
        first = rows @ first
        second = rows @ second
        straddles, first_order, delay = records.straddles[e], records.first_order[e], records.delay[e]
        first_row, count = records.offsets[e], records.offsets[e + 1] - records.offsets[e]
        begins_moving = -delay if records.early[e] else 0
        _clear(block, 0, columns + 1)
        now = np.zeros(size + 2)
        following = np.zeros(size + 2)
        outputs = 1 + split + (order if sensitive else 0)
        for j in range(-delay, count - delay):
            if (estimated or biased) and j == begins_moving:
                for row in range(size):
                    now[row] += start[row]
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
            used = records.used[frame]
            for row in range(len(rows)):
                if row > 0 and (not used or outputs <= row < 1 + split + order):
                    continue
                total = 0.0
                for column in range(size + 2):
                    total += first[row, column] * now[column]
                if straddles:
                    for column in range(size + 2):
                        total += second[row, column] * following[column]
                if row == 0:
                    residual[frame] = records.output[frame] - total - offset
                elif biased and row == len(rows) - 1:
                    block[bias_column, filled] = total
                elif row <= split + order:
                    block[row - 1, filled] = total
                else:
                    block[position + row - 1, filled] = total
            if used:
                if records.sensor_offset:
                    block[offset_column, filled] = 1.0
                block[columns, filled] = residual[frame]
                cost += residual[frame] * residual[frame]
                filled += 1
                if filled == BLOCK:
                    fold(triangle, block, filled)
                    filled = 0
                    _clear(block, split + order, columns)
            for row in range(size):
                now[row] = following[row]
        # The columns of one experiment's initial state are zero in the rows of the others.
        fold(triangle, block, filled)
        filled = 0
        if estimated:
            position += order
    if not np.isfinite(cost):
        cost = np.inf
    return triangle, cost


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
        See :meth:`Records.linear_unknowns`.
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
