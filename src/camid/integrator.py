"""The compiled integrator: a linear system with forces that depend on its motion, and events where they jump.

Between events a step is that of Cox & Matthews (2002, ETDRK4): exact for the linear part and for an input that is a
straight line over the step, of fourth order in the forces. Where a force jumps or has a kink (velocity reversal under
dry friction, contact with a stop, onset of a disturbance) the step is split at the event, which the cubic through
values and slopes at its ends locates, and the parts are classical Runge–Kutta steps. A body that sticks is held by
whatever force keeps its velocity at zero, up to the level of friction at rest.

Reference: Cox, S. M. & Matthews, P. C. (2002), J. Comput. Phys. 176, 430–455.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic
from numpy.typing import NDArray

from camid.chain import _exponential_and_integral

Array = NDArray[np.float64]

# Events that one step may be split at; more than a few mean that the step is too long for the force.
MOST_EVENTS = 12
# A part of a step shorter than this share of it is not worth a step of its own.
SHORTEST_PART = 1e-7


class Mechanics(NamedTuple):
    """A linear system with forces, as compiled code takes it; time in a unit of its own.

    Attributes
    ----------
    state_matrix : ndarray, shape (q, q)
        The last state is the integral of the measured motion.
    input_vector, force_vector : ndarray, shape (q,)
        Of the input behind the actuator and of a force at the plant's input.
    measured, position, velocity : ndarray, shape (q,)
        Rows for the motion that the sensor sees, and for the motion that the forces depend on (per unit of time).
    sticks : bool
        Whether a force at the plant's input acts on the acceleration at once, so that friction can hold the body.
    force_address, level_address, rate_address, switch_address : ndarray of int, shape (f,)
        Of compiled functions; 0 where an effect has none.
    values : ndarray, shape (f, v)
    time_unit : float
        Seconds.
    """

    state_matrix: Array
    input_vector: Array
    force_vector: Array
    measured: Array
    position: Array
    velocity: Array
    sticks: bool
    force_address: NDArray[np.int64]
    level_address: NDArray[np.int64]
    rate_address: NDArray[np.int64]
    switch_address: NDArray[np.int64]
    values: Array
    time_unit: float


@intrinsic
def _call(
    typing_context: Any,
    address: Any,
    time: Any,
    position: Any,
    velocity: Any,
    signal: Any,
    memory: Any,
    values: Any,
) -> Any:
    """Call a compiled function by its address, so that code which calls it need not be compiled anew for each."""
    signature = types.float64(types.int64, *[types.float64] * 5, types.int64)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        double = ir.DoubleType()
        function = ir.FunctionType(double, [double] * 5 + [double.as_pointer()])
        pointer = builder.inttoptr(arguments[0], function.as_pointer())
        return builder.call(pointer, [*arguments[1:6], builder.inttoptr(arguments[6], double.as_pointer())])

    return signature, generate


@njit(cache=True, inline="always")
def _dot(row: Array, state: Array) -> float:
    total = 0.0
    for i in range(len(row)):
        total += row[i] * state[i]
    return total


@njit(cache=True)
def _force_at(
    m: Mechanics, time: float, position: float, velocity: float, signal: float, memory: Array, direction: float
) -> float:
    """Total force along the input: all forces, and dry friction against ``direction`` (0: none)."""
    data = m.values.ctypes.data
    stride = m.values.shape[1] * 8
    total = 0.0
    for i in range(len(m.force_address)):
        if m.force_address[i] != 0:
            total -= _call(m.force_address[i], time, position, velocity, signal, memory[i], data + i * stride)
        if direction != 0.0 and m.level_address[i] != 0:
            speed = max(direction * velocity, 0.0)
            total -= direction * _call(m.level_address[i], time, position, speed, signal, 0.0, data + i * stride)
    return total


@njit(cache=True)
def _force(m: Mechanics, time: float, state: Array, signal: float, memory: Array, direction: float) -> float:
    """Total force along the input in a state; see :func:`_force_at`."""
    velocity = _dot(m.velocity, state) / m.time_unit
    return _force_at(m, time, _dot(m.position, state), velocity, signal, memory, direction)


@njit(cache=True)
def _level_at_rest(m: Mechanics, time: float, position: float, signal: float) -> float:
    total = 0.0
    for i in range(len(m.level_address)):
        if m.level_address[i] != 0:
            total += _call(
                m.level_address[i], time, position, 0.0, signal, 0.0, m.values.ctypes.data + i * m.values.shape[1] * 8
            )
    return total


@njit(cache=True)
def _rates_at(
    m: Mechanics, time: float, position: float, velocity: float, signal: float, memory: Array, rates: Array
) -> None:
    """Rates of the inner states, in scaled time."""
    for i in range(len(m.rate_address)):
        rates[i] = 0.0
        if m.rate_address[i] != 0:
            values = m.values.ctypes.data + i * m.values.shape[1] * 8
            rates[i] = m.time_unit * _call(m.rate_address[i], time, position, velocity, signal, memory[i], values)


@njit(cache=True)
def _rates(m: Mechanics, time: float, state: Array, signal: float, memory: Array, rates: Array) -> None:
    velocity = _dot(m.velocity, state) / m.time_unit
    _rates_at(m, time, _dot(m.position, state), velocity, signal, memory, rates)


@njit(cache=True)
def _slope(
    m: Mechanics, time: float, state: Array, signal: float, memory: Array, direction: float, stuck: bool, result: Array
) -> None:
    """Derivative of the state by the scaled time; a stuck body keeps its velocity."""
    force = _force(m, time, state, signal, memory, 0.0 if stuck else direction)
    size = len(state)
    for i in range(size):
        total = m.input_vector[i] * signal + m.force_vector[i] * force
        for j in range(size):
            total += m.state_matrix[i, j] * state[j]
        result[i] = total
    if stuck:
        hold = _dot(m.velocity, result) / _dot(m.velocity, m.force_vector)
        for i in range(size):
            result[i] -= m.force_vector[i] * hold


@njit(cache=True)
def _holding_force(m: Mechanics, time: float, state: Array, signal: float, memory: Array, work: Array) -> float:
    """Force along the input that a body at rest would have to overcome to keep from accelerating."""
    _slope(m, time, state, signal, memory, 0.0, False, work)
    return _dot(m.velocity, work) / _dot(m.velocity, m.force_vector)


@njit(cache=True)
def _runge_kutta(
    m: Mechanics,
    time: float,
    step: float,
    state: Array,
    memory: Array,
    first: float,
    last: float,
    direction: float,
    stuck: bool,
    result: Array,
    remembered: Array,
    work: Array,
) -> None:
    """Classical step of scaled length ``step``; the input goes from ``first`` to ``last``."""
    size, count = len(state), len(memory)
    middle = 0.5 * (first + last)
    for stage in range(4):
        share = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
        signal = first if stage == 0 else (last if stage == 3 else middle)
        for i in range(size):
            work[8, i] = state[i] + (share * step * work[stage - 1, i] if stage > 0 else 0.0)
        for i in range(count):
            remembered[i] = memory[i] + (share * step * work[4 + stage - 1, i] if stage > 0 else 0.0)
        now = time + share * step * m.time_unit
        _slope(m, now, work[8, :size], signal, remembered, direction, stuck, work[stage, :size])
        _rates(m, now, work[8, :size], signal, remembered, work[4 + stage, :count])
    for i in range(size):
        result[i] = state[i] + step / 6.0 * (work[0, i] + 2.0 * work[1, i] + 2.0 * work[2, i] + work[3, i])
    for i in range(count):
        remembered[i] = memory[i] + step / 6.0 * (work[4, i] + 2.0 * work[5, i] + 2.0 * work[6, i] + work[7, i])


@njit(cache=True)
def _first_root(start: float, start_slope: float, end: float, end_slope: float) -> float:
    """Where in [0, 1] the cubic through values and slopes at both ends, of opposite sign, is zero."""
    low, high = 0.0, 1.0
    guess = start / (start - end)
    for _ in range(40):
        a = 2.0 * start - 2.0 * end + start_slope + end_slope
        b = -3.0 * start + 3.0 * end - 2.0 * start_slope - end_slope
        value = ((a * guess + b) * guess + start_slope) * guess + start
        if (value > 0.0) == (start > 0.0):
            low = guess
        else:
            high = guess
        slope = (3.0 * a * guess + 2.0 * b) * guess + start_slope
        following = guess - value / slope if slope != 0.0 else 0.5 * (low + high)
        if not low < following < high:
            following = 0.5 * (low + high)
        if abs(following - guess) < 1e-12:
            return following
        guess = following
    return guess


@njit(cache=True)
def _switches(m: Mechanics, time: float, state: Array, result: Array) -> None:
    position = _dot(m.position, state)
    velocity = _dot(m.velocity, state) / m.time_unit
    for i in range(len(m.switch_address)):
        result[i] = 1.0
        if m.switch_address[i] != 0:
            values = m.values.ctypes.data + i * m.values.shape[1] * 8
            result[i] = _call(m.switch_address[i], time, position, velocity, 0.0, 0.0, values)


@njit(cache=True)
def _settle(m: Mechanics, time: float, state: Array, signal: float, memory: Array, work: Array) -> tuple[float, bool]:
    """Direction of slip, or that the body sticks, where the velocity is zero."""
    if not m.sticks:
        return 0.0, False
    hold = _holding_force(m, time, state, signal, memory, work)
    if abs(hold) <= _level_at_rest(m, time, _dot(m.position, state), signal):
        return 0.0, True
    return (1.0 if hold * _dot(m.velocity, m.force_vector) > 0.0 else -1.0), False


@njit(cache=True)
def _careful_step(
    m: Mechanics,
    time: float,
    step: float,
    state: Array,
    memory: Array,
    first: float,
    last: float,
    direction: float,
    stuck: bool,
    dry: bool,
    work: Array,
    before: Array,
    after: Array,
) -> tuple[float, bool]:
    """Advance ``state`` and ``memory`` in place over a step that may hold events; direction and stuck at its end."""
    size, count = len(state), len(memory)
    result, remembered = work[9, :size], work[10, :count]
    done = 0.0
    for _ in range(MOST_EVENTS):
        left = step - done
        if left <= SHORTEST_PART * step:
            break
        signal = first + (last - first) * done / step
        now = time + done * m.time_unit
        velocity = _dot(m.velocity, state)
        if dry and not stuck and direction == 0.0:
            if velocity == 0.0 and m.sticks:
                direction, stuck = _settle(m, now, state, signal, memory, work[11, :size])
            else:
                direction = 1.0 if velocity >= 0.0 else -1.0
        if stuck:
            hold = _holding_force(m, now, state, signal, memory, work[11, :size])
            if abs(hold) > _level_at_rest(m, now, _dot(m.position, state), signal) * (1.0 + 1e-12):
                stuck = False
                direction = 1.0 if hold * _dot(m.velocity, m.force_vector) > 0.0 else -1.0
        _switches(m, now, state, before)
        _runge_kutta(m, now, left, state, memory, signal, last, direction, stuck, result, remembered, work)
        share = 1.0
        event = 0
        if stuck:
            ending = now + left * m.time_unit
            hold_end = _holding_force(m, ending, result, last, remembered, work[11, :size])
            level = _level_at_rest(m, ending, _dot(m.position, result), last)
            if abs(hold_end) > level:
                hold_start = _holding_force(m, now, state, signal, memory, work[11, :size])
                sign = 1.0 if hold_end > 0.0 else -1.0
                excess = sign * hold_end - level
                reserve = level - sign * hold_start
                share = max(reserve / (reserve + excess), 0.0) if reserve + excess > 0.0 else 0.0
                event = 1
        else:
            velocity_end = _dot(m.velocity, result)
            # A body that has just begun to slip leaves zero in its direction; anything else is a reversal.
            if dry and direction * velocity_end < 0.0:
                if direction * velocity > 0.0:
                    slope_start = left * _dot(m.velocity, work[0, :size])
                    _slope(
                        m,
                        now + left * m.time_unit,
                        result,
                        last,
                        remembered,
                        direction,
                        False,
                        work[11, :size],
                    )
                    slope_end = left * _dot(m.velocity, work[11, :size])
                    share = _first_root(velocity, slope_start, velocity_end, slope_end)
                else:
                    share = 0.0
                event = 2
        _switches(m, now + left * m.time_unit, result, after)
        for i in range(len(after)):
            if m.switch_address[i] != 0 and before[i] != 0.0 and (before[i] > 0.0) != (after[i] > 0.0):
                crossing = before[i] / (before[i] - after[i])
                # The switch is a smooth function of the motion: its slope follows from a short step.
                _runge_kutta(
                    m,
                    now,
                    1e-3 * left,
                    state,
                    memory,
                    signal,
                    signal + 1e-3 * (last - signal),
                    direction,
                    stuck,
                    work[12, :size],
                    work[13, :count],
                    work,
                )
                _switches(m, now, work[12, :size], work[14, :count])
                slope_start = (work[14, i] - before[i]) * 1e3
                # The cubic needs the slope at the end, too; the chord and the start give a parabola through it.
                slope_end = 2.0 * (after[i] - before[i]) - slope_start
                crossing = _first_root(before[i], slope_start, after[i], slope_end)
                if crossing < share:
                    share = crossing
                    event = 3
        if event == 0:
            state[:] = result
            memory[:] = remembered
            break
        part = share * left
        if share > SHORTEST_PART:
            middle = signal + (last - signal) * share
            _runge_kutta(m, now, part, state, memory, signal, middle, direction, stuck, result, remembered, work)
            state[:] = result
            memory[:] = remembered
        done += part
        signal = first + (last - first) * done / step
        now = time + done * m.time_unit
        if event == 1:
            stuck = False
            hold = _holding_force(m, now, state, signal, memory, work[11, :size])
            direction = 1.0 if hold * _dot(m.velocity, m.force_vector) > 0.0 else -1.0
        elif event == 2:
            if m.sticks:
                # The rest of the velocity is the error of the root; it would count as a direction.
                correction = _dot(m.velocity, state) / _dot(m.velocity, m.force_vector)
                for i in range(size):
                    state[i] -= m.force_vector[i] * correction
                direction, stuck = _settle(m, now, state, signal, memory, work[11, :size])
            else:
                direction = -direction
        elif event == 3:
            # A minute step carries the state past the kink, so that it is not found again.
            tiny = 1e-6 * step
            if done + tiny < step:
                following = first + (last - first) * (done + tiny) / step
                _runge_kutta(m, now, tiny, state, memory, signal, following, direction, stuck, result, remembered, work)
                state[:] = result
                memory[:] = remembered
                done += tiny
    return direction, stuck


@njit(cache=True)
def _coefficients(matrix: Array, vector: Array, step: float) -> tuple[Array, Array]:
    """exp(A h) and the columns h φ1 b, h φ2 b and h φ3 b of a vector b, shape (q, 3)."""
    size = len(vector)
    augmented = np.zeros((size + 3, size + 3))
    augmented[:size, :size] = matrix * step
    augmented[:size, size] = vector * step
    augmented[size, size + 1] = 1.0
    augmented[size + 1, size + 2] = 1.0
    exponential, _ = _exponential_and_integral(augmented, 1.0)
    return exponential[:size, :size].copy(), exponential[:size, size:].copy()


class _Smooth(NamedTuple):
    """Coefficients of a step without events; see Cox & Matthews (2002), equations (26)–(29).

    Forces depend on position and velocity only, so the stages need these two of the state and not the state itself:
    ``rows_half`` and ``rows_whole`` give them after half a step and a whole one without forces, shape (2, q);
    ``input_half``, ``input_whole`` (2, 2) add the input and its change over the step, ``force_half`` (2,) half a step
    of force, and ``force_carried`` (2,) the force of the first half at the end of the second.
    """

    whole: Array
    input_columns: Array
    force_columns: Array
    rows_half: Array
    rows_whole: Array
    input_half: Array
    input_whole: Array
    force_half: Array
    force_carried: Array


@njit(cache=True)
def _smooth(m: Mechanics, scaled: float) -> _Smooth:
    """Coefficients for steps of a scaled length."""
    whole, whole_force = _coefficients(m.state_matrix, m.force_vector, scaled)
    half, half_force = _coefficients(m.state_matrix, m.force_vector, 0.5 * scaled)
    _, whole_input = _coefficients(m.state_matrix, m.input_vector, scaled)
    _, half_input = _coefficients(m.state_matrix, m.input_vector, 0.5 * scaled)
    size = len(m.force_vector)
    columns = np.empty((size, 3))
    columns[:, 0] = whole_force[:, 0] - 3.0 * whole_force[:, 1] + 4.0 * whole_force[:, 2]
    columns[:, 1] = 2.0 * whole_force[:, 1] - 4.0 * whole_force[:, 2]
    columns[:, 2] = 4.0 * whole_force[:, 2] - whole_force[:, 1]
    rows = np.empty((2, size))
    rows[0] = m.position
    rows[1] = m.velocity / m.time_unit
    entering = np.empty((size, 2))
    entering[:, 0] = half_input[:, 0]
    entering[:, 1] = 0.5 * half_input[:, 1]
    rows_half = rows @ half
    return _Smooth(
        whole,
        whole_input[:, :2].copy(),
        columns,
        rows_half,
        rows @ whole,
        rows @ entering,
        rows @ np.ascontiguousarray(whole_input[:, :2]),
        rows @ np.ascontiguousarray(half_force[:, 0]),
        rows_half @ np.ascontiguousarray(half_force[:, 0]),
    )


@njit(cache=True)
def _smooth_step(
    m: Mechanics,
    c: _Smooth,
    time: float,
    step: float,
    state: Array,
    memory: Array,
    first: float,
    last: float,
    direction: float,
    remembers: bool,
    rates: Array,
    remembered: Array,
    following: Array,
) -> None:
    """Step without events: the state at its end, and in ``remembered`` the inner states."""
    size, count = len(state), len(memory)
    slope = last - first
    middle = first + 0.5 * slope
    position, velocity = _dot(m.position, state), _dot(m.velocity, state) / m.time_unit
    half_position = c.input_half[0, 0] * first + c.input_half[0, 1] * slope
    half_velocity = c.input_half[1, 0] * first + c.input_half[1, 1] * slope
    whole_position = c.input_whole[0, 0] * first + c.input_whole[0, 1] * slope
    whole_velocity = c.input_whole[1, 0] * first + c.input_whole[1, 1] * slope
    for i in range(size):
        half_position += c.rows_half[0, i] * state[i]
        half_velocity += c.rows_half[1, i] * state[i]
        whole_position += c.rows_whole[0, i] * state[i]
        whole_velocity += c.rows_whole[1, i] * state[i]
    scaled = step / m.time_unit
    at_half, finish = time + 0.5 * step, time + step
    for i in range(count):
        remembered[i] = memory[i]
    force_1 = _force_at(m, time, position, velocity, first, remembered, direction)
    if remembers:
        _rates_at(m, time, position, velocity, first, memory, rates[0])
        for i in range(count):
            remembered[i] = memory[i] + 0.5 * scaled * rates[0, i]
    position = half_position + c.force_half[0] * force_1
    velocity = half_velocity + c.force_half[1] * force_1
    force_2 = _force_at(m, at_half, position, velocity, middle, remembered, direction)
    if remembers:
        _rates_at(m, at_half, position, velocity, middle, remembered, rates[1])
        for i in range(count):
            remembered[i] = memory[i] + 0.5 * scaled * rates[1, i]
    position = half_position + c.force_half[0] * force_2
    velocity = half_velocity + c.force_half[1] * force_2
    force_3 = _force_at(m, at_half, position, velocity, middle, remembered, direction)
    if remembers:
        _rates_at(m, at_half, position, velocity, middle, remembered, rates[2])
        for i in range(count):
            remembered[i] = memory[i] + scaled * rates[2, i]
    change = 2.0 * force_3 - force_1
    position = whole_position + c.force_carried[0] * force_1 + c.force_half[0] * change
    velocity = whole_velocity + c.force_carried[1] * force_1 + c.force_half[1] * change
    force_4 = _force_at(m, finish, position, velocity, last, remembered, direction)
    if remembers:
        _rates_at(m, finish, position, velocity, last, remembered, rates[3])
        for i in range(count):
            mean = rates[0, i] + 2.0 * rates[1, i] + 2.0 * rates[2, i] + rates[3, i]
            remembered[i] = memory[i] + scaled / 6.0 * mean
    for i in range(size):
        total = c.input_columns[i, 0] * first + c.input_columns[i, 1] * slope
        total += c.force_columns[i, 0] * force_1
        total += c.force_columns[i, 1] * (force_2 + force_3)
        total += c.force_columns[i, 2] * force_4
        for j in range(size):
            total += c.whole[i, j] * state[j]
        following[i] = total


@njit(cache=True, nogil=True)
def integrate(
    m: Mechanics,
    initial: Array,
    start: Array,
    end: Array,
    begin: float,
    step: float,
    breaks: Array,
    impulse_times: Array,
    impulse_sizes: Array,
) -> tuple[Array, Array, Array]:
    """Run the system over a grid of equal steps.

    Parameters
    ----------
    m : Mechanics
    initial : ndarray, shape (q,)
        State at the begin of the grid.
    start, end : ndarray, shape (M,)
        Input at the begin and at the end of each step.
    begin, step : float
        Begin and step of the grid in seconds.
    breaks : ndarray
        Sorted times in seconds at which a force jumps.
    impulse_times, impulse_sizes : ndarray
        Sorted times in seconds, and sizes in units of u times seconds.

    Returns
    -------
    measured, rate, integral : ndarray, shape (M + 1,)
        Motion before the sensor, its derivative by time in seconds, and its integral over time in seconds.
    """
    size, count, steps = len(initial), len(m.force_address), len(start)
    scaled = step / m.time_unit
    c = _smooth(m, scaled)
    dry, kinks, remembers, forced = False, False, False, False
    for i in range(count):
        dry = dry or m.level_address[i] != 0
        kinks = kinks or m.switch_address[i] != 0
        remembers = remembers or m.rate_address[i] != 0
        forced = forced or m.force_address[i] != 0 or m.level_address[i] != 0
    row = m.state_matrix[size - 1].copy()  # the integral grows by the measured motion
    derivative = np.zeros(size)
    for j in range(size):
        for i in range(size):
            derivative[j] += row[i] * m.state_matrix[i, j]
    direct_input, direct_force = _dot(row, m.input_vector), _dot(row, m.force_vector)
    measured, rate, integral = np.empty(steps + 1), np.empty(steps + 1), np.empty(steps + 1)
    state, memory = initial.copy(), np.zeros(count)
    following, remembered, rates = np.empty(size), np.zeros(count), np.zeros((4, count))
    work = np.zeros((15, max(size, count)))
    before, after = np.ones(count), np.ones(count)
    direction, stuck = 0.0, False
    next_break, next_impulse = 0, 0
    if dry:
        velocity = _dot(m.velocity, state)
        direction = 0.0 if velocity == 0.0 else (1.0 if velocity > 0.0 else -1.0)
    while next_break < len(breaks) and breaks[next_break] <= begin:
        next_break += 1
    while next_impulse < len(impulse_times) and impulse_times[next_impulse] < begin:
        next_impulse += 1

    for k in range(steps + 1):
        time = begin + k * step
        measured[k] = _dot(row, state)
        integral[k] = state[size - 1] * m.time_unit
        slope = _dot(derivative, state)
        if direct_input != 0.0 or direct_force != 0.0:
            signal = start[min(k, steps - 1)]
            slope += direct_input * signal
            if forced:
                slope += direct_force * _force(m, time, state, signal, memory, direction)
        rate[k] = slope / m.time_unit
        if k == steps:
            break
        finish = time + step
        breaking = next_break < len(breaks) and breaks[next_break] <= finish
        striking = next_impulse < len(impulse_times) and impulse_times[next_impulse] < finish
        if breaking or striking:
            at = time
            value = start[k]
            while True:
                until = finish
                kind = 0
                if next_break < len(breaks) and breaks[next_break] <= until:
                    until, kind = breaks[next_break], 1
                if next_impulse < len(impulse_times) and impulse_times[next_impulse] < until:
                    until, kind = impulse_times[next_impulse], 2
                until_value = start[k] + (end[k] - start[k]) * (until - time) / step
                if until > at:
                    # Times just inside the part, so that a force which jumps at its ends is taken from within.
                    margin = 1e-9 * (until - at)
                    direction, stuck = _careful_step(
                        m,
                        at + margin,
                        (until - at - 2.0 * margin) / m.time_unit,
                        state,
                        memory,
                        value,
                        until_value,
                        direction,
                        stuck,
                        dry,
                        work,
                        before,
                        after,
                    )
                at, value = until, until_value
                if kind == 1:
                    next_break += 1
                elif kind == 2:
                    for i in range(size):
                        state[i] += m.force_vector[i] * impulse_sizes[next_impulse] / m.time_unit
                    next_impulse += 1
                    stuck, direction = False, 0.0
                else:
                    break
            continue
        if not forced:
            for i in range(size):
                total = c.input_columns[i, 0] * start[k] + c.input_columns[i, 1] * (end[k] - start[k])
                for j in range(size):
                    total += c.whole[i, j] * state[j]
                following[i] = total
            for i in range(size):
                state[i] = following[i]
            continue
        if not stuck and not (dry and direction == 0.0):
            _smooth_step(
                m,
                c,
                time,
                step,
                state,
                memory,
                start[k],
                end[k],
                direction,
                remembers,
                rates,
                remembered,
                following,
            )
            event = dry and direction * _dot(m.velocity, following) < 0.0
            if kinks and not event:
                _switches(m, time, state, before)
                _switches(m, finish, following, after)
                for i in range(count):
                    event = event or (before[i] > 0.0) != (after[i] > 0.0)
            if not event:
                for i in range(size):
                    state[i] = following[i]
                for i in range(count):
                    memory[i] = remembered[i]
                continue
        direction, stuck = _careful_step(
            m, time, scaled, state, memory, start[k], end[k], direction, stuck, dry, work, before, after
        )
    return measured, rate, integral
