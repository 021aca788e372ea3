"""The compiled integrator: a linear system with forces that depend on its motion, on a grid of equal steps.

Between events a step is that of Cox & Matthews (2002, ETDRK4): exact for the linear part and for an input that is a
straight line over the step, of fourth order in the forces. A step in which a force jumps or has a kink is taken again
by :mod:`camid.engine.events`.

Reference: Cox, S. M. & Matthews, P. C. (2002), J. Comput. Phys. 176, 430–455.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.chain.exact import _exponential_and_integral
from camid.compiled import kernel, njit
from camid.engine.events import careful_step
from camid.engine.forces import Mechanics, dot, force_at, force_in, remember, switches, switches_at

Array = NDArray[np.float64]


@njit
def _coefficients(matrix: Array, vector: Array, step: float) -> tuple[Array, Array]:
    """exp(A h) and the columns h φ1 b, h φ2 b and h φ3 b of a vector b, shape (q, 3)."""
    size = len(vector)
    augmented = np.zeros((size + 3, size + 3))
    for i in range(size):
        augmented[i, size] = vector[i] * step
        for j in range(size):
            augmented[i, j] = matrix[i, j] * step
    augmented[size, size + 1] = 1.0
    augmented[size + 1, size + 2] = 1.0
    exponential, _ = _exponential_and_integral(augmented, 1.0)
    whole, columns = np.empty((size, size)), np.empty((size, 3))
    for i in range(size):
        for j in range(size):
            whole[i, j] = exponential[i, j]
        for j in range(3):
            columns[i, j] = exponential[i, size + j]
    return whole, columns


# Beyond this the motion runs away.
ASTRAY = 1e100


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


@njit
def _smooth(m: Mechanics, scaled: float) -> _Smooth:
    """Coefficients for steps of a scaled length."""
    whole, whole_force = _coefficients(m.state_matrix, m.force_vector, scaled)
    half, half_force = _coefficients(m.state_matrix, m.force_vector, 0.5 * scaled)
    _, whole_input = _coefficients(m.state_matrix, m.input_vector, scaled)
    _, half_input = _coefficients(m.state_matrix, m.input_vector, 0.5 * scaled)
    size = len(m.force_vector)
    columns, rows, entering = np.empty((size, 3)), np.empty((2, size)), np.empty((size, 2))
    input_columns, force_half = np.empty((size, 2)), np.empty(size)
    for i in range(size):
        columns[i, 0] = whole_force[i, 0] - 3.0 * whole_force[i, 1] + 4.0 * whole_force[i, 2]
        columns[i, 1] = 2.0 * whole_force[i, 1] - 4.0 * whole_force[i, 2]
        columns[i, 2] = 4.0 * whole_force[i, 2] - whole_force[i, 1]
        rows[0, i] = m.position[i]
        rows[1, i] = m.velocity[i] / m.time_unit
        entering[i, 0] = half_input[i, 0]
        entering[i, 1] = 0.5 * half_input[i, 1]
        input_columns[i, 0] = whole_input[i, 0]
        input_columns[i, 1] = whole_input[i, 1]
        force_half[i] = half_force[i, 0]
    rows_half = rows @ half
    input_half = rows @ entering
    input_whole = rows @ input_columns
    # What the input does to the velocity at once.
    input_half[1, 0] += m.velocity_input
    input_half[1, 1] += 0.5 * m.velocity_input
    input_whole[1, 0] += m.velocity_input
    input_whole[1, 1] += m.velocity_input
    return _Smooth(
        whole,
        input_columns,
        columns,
        rows_half,
        rows @ whole,
        input_half,
        input_whole,
        rows @ force_half,
        rows_half @ force_half,
    )


@kernel(error_model="numpy", fastmath={"reassoc", "contract", "nsz"}, forceinline=True)
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
    remembered: Array,
    following: Array,
) -> tuple[float, float, float, float]:
    """Step without events: the state at its end, and in ``remembered`` the inner states.

    Returns
    -------
    halfway, speed, largest, doubt : float
        Position and velocity in the middle, largest force, and the difference of the two forces in the middle: it is of
        third order in the step, and so measures how well the step resolves the force.
    """
    whole, input_columns, force_columns = c.whole, c.input_columns, c.force_columns
    rows_half, rows_whole, input_half, input_whole = c.rows_half, c.rows_whole, c.input_half, c.input_whole
    force_half, force_carried = c.force_half, c.force_carried
    position_row, velocity_row, forces, inverse = m.position, m.velocity, m.forces, 1.0 / m.time_unit
    size = len(state)
    slope = last - first
    middle = first + 0.5 * slope
    origin, velocity = 0.0, m.velocity_input * first
    half_position = input_half[0, 0] * first + input_half[0, 1] * slope
    half_velocity = input_half[1, 0] * first + input_half[1, 1] * slope
    whole_position = input_whole[0, 0] * first + input_whole[0, 1] * slope
    whole_velocity = input_whole[1, 0] * first + input_whole[1, 1] * slope
    for i in range(size):
        value = state[i]
        origin += position_row[i] * value
        velocity += velocity_row[i] * inverse * value
        half_position += rows_half[0, i] * value
        half_velocity += rows_half[1, i] * value
        whole_position += rows_whole[0, i] * value
        whole_velocity += rows_whole[1, i] * value
    at_half, finish = time + 0.5 * step, time + step
    force_1 = force_at(forces, time, origin, velocity, first, memory, direction)
    position = half_position + force_half[0] * force_1
    halfway = half_velocity + force_half[1] * force_1
    if remembers:
        remember(forces, at_half, position - origin, memory, remembered)
    force_2 = force_at(forces, at_half, position, halfway, middle, remembered, direction)
    position = half_position + force_half[0] * force_2
    halfway = half_velocity + force_half[1] * force_2
    if remembers:
        remember(forces, at_half, position - origin, memory, remembered)
    force_3 = force_at(forces, at_half, position, halfway, middle, remembered, direction)
    middle_position = position
    change = 2.0 * force_3 - force_1
    position = whole_position + force_carried[0] * force_1 + force_half[0] * change
    velocity = whole_velocity + force_carried[1] * force_1 + force_half[1] * change
    if remembers:
        remember(forces, finish, position - origin, memory, remembered)
    force_4 = force_at(forces, finish, position, velocity, last, remembered, direction)
    both = force_2 + force_3
    ending = 0.0
    for i in range(size):
        total = input_columns[i, 0] * first + input_columns[i, 1] * slope
        total += force_columns[i, 0] * force_1
        total += force_columns[i, 1] * both
        total += force_columns[i, 2] * force_4
        for j in range(size):
            total += whole[i, j] * state[j]
        following[i] = total
        ending += position_row[i] * total
    if remembers:
        remember(forces, finish, ending - origin, memory, remembered)
    return middle_position, halfway, max(abs(force_1), abs(force_3)), abs(force_3 - force_2)


@kernel
def _direct_rate(
    m: Mechanics,
    time: float,
    state: Array,
    signal: float,
    memory: Array,
    direction: float,
    direct_input: float,
    direct_force: float,
) -> float:
    """What input and forces contribute at once to the derivative of the measured motion by the time in seconds."""
    total = direct_input * signal
    if direct_force != 0.0:
        total += direct_force * force_in(m, time, state, signal, memory, direction)
    return total / m.time_unit


class Feedback(NamedTuple):
    """A controller u_k = clip(k_v (k_p (r_k − y) − ẏ)) that acts on the plant's input and is held for a period.

    ``steps`` is the number of integration steps per period, 0 without a controller; ``control``, shape (N,), is filled
    with what the controller did.
    """

    steps: int
    reference: Array
    position_gain: float
    velocity_gain: float
    limit: float
    control: Array


@kernel
def _passed(times: Array, now: float, inclusive: bool) -> int:
    """How many of sorted times lie before now, or at it."""
    count = 0
    while count < len(times) and (times[count] < now or (inclusive and times[count] == now)):
        count += 1
    return count


@kernel
def _run_away(node: int, measured: Array, rate: Array, integral: Array, rate_end: Array) -> None:
    """Nothing that follows a motion which runs away means anything."""
    for i in range(node, len(measured)):
        measured[i], rate[i], integral[i], rate_end[max(i - 1, 0)] = np.nan, np.nan, np.nan, np.nan


@kernel
def _controlled(feedback: Feedback, sample: int, position: float, speed: float) -> float:
    """What the controller puts out at a sample, and keeps."""
    wanted = feedback.velocity_gain * (feedback.position_gain * (feedback.reference[sample] - position) - speed)
    held = min(max(wanted, -feedback.limit), feedback.limit)
    feedback.control[sample] = held
    return held


class _Room(NamedTuple):
    """Room for the state of a run and for what its steps work with; kernels allocate nothing.

    Attributes
    ----------
    state, following, derivative : ndarray, shape (q,)
        State now and after a step, and the row that gives the derivative of the measured motion.
    memory, remembered : ndarray, shape (f,)
        Inner states of the effects now and after a step.
    before, between, after : ndarray, shape (f + 2,)
        Switches at the start of a step, in its middle and at its end.
    work : ndarray, shape (10, max(q, f + 2))
    """

    state: Array
    following: Array
    memory: Array
    remembered: Array
    before: Array
    between: Array
    after: Array
    derivative: Array
    work: Array


@kernel
def _integrate(  # noqa: C901, PLR0912, PLR0915 - its parts share more variables than a call can return
    m: Mechanics,
    c: _Smooth,
    start: Array,
    end: Array,
    start_time: float,
    step: float,
    breaks: Array,
    impulse_times: Array,
    impulse_sizes: Array,
    feedback: Feedback,
    room: _Room,
    measured: Array,
    rate: Array,
    integral: Array,
    rate_end: Array,
) -> float:
    state, following, memory, remembered = room.state, room.following, room.memory, room.remembered
    before, between, after = room.before, room.between, room.after
    derivative, work = room.derivative, room.work
    size, count, steps = len(state), m.forces.functions.shape[1], len(start)
    dry, kinks, remembers, forced = False, m.forces.implicit, False, False
    for i in range(count):
        dry = dry or (m.forces.functions[1, i] != 0 and m.sticks)
        kinks = kinks or m.forces.functions[3, i] != 0
        remembers = remembers or m.forces.functions[2, i] != 0
        forced = forced or m.forces.functions[0, i] != 0 or m.forces.functions[1, i] != 0
    row = m.state_matrix[size - 1]  # the integral grows by the measured motion
    for j in range(size):
        for i in range(size):
            derivative[j] += row[i] * m.state_matrix[i, j]
    direct_input, direct_force = dot(row, m.input_vector), dot(row, m.force_vector) if forced else 0.0
    direct = direct_input != 0.0 or direct_force != 0.0
    known = False  # whether ``before`` holds the switches at the start of the step
    direction, stuck = 0.0, False
    next_break, next_impulse = _passed(breaks, start_time, True), _passed(impulse_times, start_time, False)
    largest, doubt = 0.0, 0.0
    held, held_before = 0.0, 0.0
    if dry:
        velocity = dot(m.velocity, state)
        direction = 0.0 if velocity == 0.0 else (1.0 if velocity > 0.0 else -1.0)

    for k in range(steps + 1):
        time = start_time + k * step
        measured[k] = dot(row, state)
        integral[k] = state[size - 1] * m.time_unit
        if not abs(measured[k]) < ASTRAY:
            _run_away(k, measured, rate, integral, rate_end)
            return np.inf
        rate[k] = dot(derivative, state) / m.time_unit
        held_before = held
        if feedback.steps > 0 and k % feedback.steps == 0 and k // feedback.steps < len(feedback.reference):
            speed = rate[k]
            if direct:
                signal = (end[k - 1] if k > 0 else start[0]) + held
                speed += _direct_rate(m, time, state, signal, memory, direction, direct_input, direct_force)
            held = _controlled(feedback, k // feedback.steps, measured[k], speed)
        first = (start[k] if k < steps else end[k - 1]) + held
        if direct:
            # A jump of the input makes one of the velocity.
            slope = rate[k]
            rate[k] = slope + _direct_rate(m, time, state, first, memory, direction, direct_input, direct_force)
            if k > 0:
                rate_end[k - 1] = rate[k]
                if end[k - 1] + held_before != first:
                    signal = end[k - 1] + held_before
                    rate_end[k - 1] = slope + _direct_rate(
                        m, time, state, signal, memory, direction, direct_input, direct_force
                    )
        elif k > 0:
            rate_end[k - 1] = rate[k]
        if k == steps:
            break
        last = end[k] + held
        largest = max(largest, abs(first))
        finish = time + step
        breaking = next_break < len(breaks) and breaks[next_break] <= finish
        striking = next_impulse < len(impulse_times) and impulse_times[next_impulse] < finish
        if not (forced or breaking or striking):
            for i in range(size):
                total = c.input_columns[i, 0] * first + c.input_columns[i, 1] * (last - first)
                for j in range(size):
                    total += c.whole[i, j] * state[j]
                following[i] = total
            for i in range(size):
                state[i] = following[i]
            continue
        tried = not (breaking or striking) and not stuck and not (dry and direction == 0.0)
        twice = False
        if tried:
            halfway, speed, size_of_force, difference = _smooth_step(
                m, c, time, step, state, memory, first, last, direction, remembers, remembered, following
            )
            event = dry and direction * dot(m.velocity, following) < 0.0
            twice = dry and not event and direction * speed < 0.0
            if kinks:
                if not known or direct:
                    switches(m, time, state, first, memory, direction, before)
                switches(m, finish, following, last, remembered, direction, after)
                middle = 0.5 * (first + last)
                switches_at(m.forces, time + 0.5 * step, halfway, speed, middle, memory, direction, between)
                for i in range(count + 2):
                    event = event or before[i] * after[i] < 0.0
                    twice = twice or (before[i] * after[i] > 0.0 and before[i] * between[i] < 0.0)
                known = not (event or twice)
                if known:
                    for i in range(count + 2):
                        before[i] = after[i]
            if not (event or twice):
                largest = max(largest, size_of_force)
                doubt = max(doubt, difference)
                for i in range(size):
                    state[i] = following[i]
                if remembers:
                    for i in range(count):
                        memory[i] = remembered[i]
                continue
        known = False
        at, value = time, first
        # Two events of one kind in a step: each half has one of them.
        part = 0.5 * step if twice else step
        whole = tried and not twice
        while True:
            until, kind = min(at + part, finish), 0
            if finish - until < 0.25 * step:
                until = finish
            if next_break < len(breaks) and breaks[next_break] <= until:
                until, kind = breaks[next_break], 1
            if next_impulse < len(impulse_times) and impulse_times[next_impulse] < until:
                until, kind = impulse_times[next_impulse], 2
            until_value = first + (last - first) * (until - time) / step
            if until > at:
                # Times just inside the part, so that a force which jumps at its ends is taken from within.
                margin = 1e-9 * (until - at) if breaking else 0.0
                direction, stuck = careful_step(
                    m, at + margin, (until - at - 2.0 * margin) / m.time_unit, state, memory, value, until_value,
                    direction, stuck, dry, kinks, whole, following, remembered, work,
                )  # fmt: skip
            at, value = until, until_value
            if kind == 1:
                next_break += 1
            elif kind == 2:
                for i in range(size):
                    state[i] += m.force_vector[i] * impulse_sizes[next_impulse] / m.time_unit
                next_impulse += 1
                stuck, direction = False, 0.0
            elif until >= finish:
                break
    return doubt / largest if largest > 0.0 else 0.0


@njit(nogil=True)
def integrate(
    m: Mechanics,
    initial: Array,
    start: Array,
    end: Array,
    start_time: float,
    step: float,
    breaks: Array,
    impulse_times: Array,
    impulse_sizes: Array,
    feedback: Feedback,
) -> tuple[Array, Array, Array, Array, float]:
    """Run the system over a grid of equal steps.

    Parameters
    ----------
    m : Mechanics
    initial : ndarray, shape (q,)
        State at the start of the grid.
    start, end : ndarray, shape (M,)
        Input at the start and at the end of each step.
    start_time, step : float
        Of the grid, in seconds.
    breaks : ndarray
        Sorted times in seconds at which a force jumps.
    impulse_times, impulse_sizes : ndarray
        Sorted times in seconds, and sizes in units of u times seconds.
    feedback : Feedback
        What a controller adds to the input.

    Returns
    -------
    measured, rate, integral : ndarray, shape (M + 1,)
        Motion before the sensor, its derivative by time in seconds, and its integral over time in seconds.
    rate_end : ndarray, shape (M,)
        Derivative at the end of each step: another one than at the start of the next where the input jumps.
    doubt : float
        The largest difference of two forces that a step of infinite fineness would take for the same, as a share of the
        largest force or input.
    """
    size, count, steps = len(initial), m.forces.functions.shape[1], len(start)
    measured, rate, integral = np.empty(steps + 1), np.empty(steps + 1), np.empty(steps + 1)
    rate_end = np.empty(steps)
    room = _Room(
        initial.copy(),
        np.empty(size),
        np.zeros(count),
        np.zeros(count),
        np.ones(count + 2),
        np.ones(count + 2),
        np.ones(count + 2),
        np.zeros(size),
        np.zeros((10, max(size, count + 2))),
    )
    coefficients = _smooth(m, step / m.time_unit)
    doubt = _integrate(
        m, coefficients, start, end, start_time, step, breaks, impulse_times, impulse_sizes, feedback, room,
        measured, rate, integral, rate_end,
    )  # fmt: skip
    return measured, rate, integral, rate_end, doubt
