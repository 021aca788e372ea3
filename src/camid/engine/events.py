"""Steps that hold events: reversals under dry friction, stick and slip, and kinks of a force.

The step is split where the cubic through values and slopes at its ends says that the event is, and the parts are
classical Runge–Kutta steps. A body that sticks is held by whatever force keeps its velocity at zero, up to the level of
friction at rest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.compiled import kernel
from camid.engine.forces import Mechanics, dot, force_in, free_velocity, friction_level, remember, switches

Array = NDArray[np.float64]

# Events that one step may be split at; more than a few mean that the step is too long for the force.
MOST_EVENTS = 12
# A part of a step shorter than this share of it is not worth a step of its own.
SHORTEST_PART = 1e-9
# Share of a step over which the slope of a switch is taken.
PROBE = 1e-4


@kernel
def _slope(
    m: Mechanics, time: float, state: Array, signal: float, memory: Array, direction: float, stuck: bool, result: Array
) -> None:
    """Derivative of the state by the scaled time; a stuck body keeps its velocity."""
    force = force_in(m, time, state, signal, memory, 0.0 if stuck else direction)
    size = len(state)
    for i in range(size):
        total = m.input_vector[i] * signal + m.force_vector[i] * force
        for j in range(size):
            total += m.state_matrix[i, j] * state[j]
        result[i] = total
    if stuck:
        hold = dot(m.velocity, result) / dot(m.velocity, m.force_vector)
        for i in range(size):
            result[i] -= m.force_vector[i] * hold


@kernel
def _holding_force(m: Mechanics, time: float, state: Array, signal: float, memory: Array, work: Array) -> float:
    """Force along the input that a body at rest would have to overcome to keep from accelerating."""
    _slope(m, time, state, signal, memory, 0.0, False, work)
    return dot(m.velocity, work) / dot(m.velocity, m.force_vector)


@kernel
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
    size = len(state)
    origin = dot(m.position, state)
    for stage in range(4):
        share = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
        for i in range(size):
            work[4, i] = state[i] + (share * step * work[stage - 1, i] if stage > 0 else 0.0)
        now = time + share * step * m.time_unit
        remember(m.forces, now, dot(m.position, work[4, :size]) - origin, memory, remembered)
        signal = first + share * (last - first)
        _slope(m, now, work[4, :size], signal, remembered, direction, stuck, work[stage, :size])
    for i in range(size):
        result[i] = state[i] + step / 6.0 * (work[0, i] + 2.0 * work[1, i] + 2.0 * work[2, i] + work[3, i])
    remember(m.forces, time + step * m.time_unit, dot(m.position, result) - origin, memory, remembered)


@kernel
def _first_root(start: float, start_slope: float, end: float, end_slope: float) -> float:
    """Where in [0, 1] the cubic through values and slopes at both ends, of opposite sign, is zero."""
    low, high = 0.0, 1.0
    guess = start / (start - end)
    a = 2.0 * start - 2.0 * end + start_slope + end_slope
    b = -3.0 * start + 3.0 * end - 2.0 * start_slope - end_slope
    for _ in range(40):
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


@kernel
def settle(m: Mechanics, time: float, state: Array, signal: float, memory: Array, work: Array) -> tuple[float, bool]:
    """Direction of slip, or that the body sticks, where the velocity is zero."""
    hold = _holding_force(m, time, state, signal, memory, work)
    if abs(hold) <= friction_level(m.forces, time, dot(m.position, state), 0.0, signal):
        return 0.0, True
    return (m.forces.along if hold > 0.0 else -m.forces.along), False


@kernel
def _crossing(
    m: Mechanics,
    index: int,
    time: float,
    step: float,
    state: Array,
    memory: Array,
    first: float,
    result: Array,
    remembered: Array,
    last: float,
    direction: float,
    stuck: bool,
    before: float,
    after: float,
    work: Array,
) -> float:
    """Share of the step at which a switch changes its sign."""
    count = len(memory)
    probe = PROBE * step
    slope_start, slope_end = 0.0, 0.0
    for end in range(2):
        at = time + end * step * m.time_unit
        here, kept = (state, memory) if end == 0 else (result, remembered)
        signal = first if end == 0 else last
        sign = 1.0 if end == 0 else -1.0
        _slope(m, at, here, signal, kept, direction, stuck, work[5, : len(state)])
        for i in range(len(state)):
            work[4, i] = here[i] + sign * probe * work[5, i]
        beside = signal + sign * PROBE * (last - first)
        switches(m, at, work[4, : len(state)], beside, kept, direction, work[6, : count + 2])
        slope = sign * (work[6, index] - (before if end == 0 else after)) / PROBE
        slope_start, slope_end = (slope, 0.0) if end == 0 else (slope_start, slope)
    return _first_root(before, slope_start, after, slope_end)


@kernel
def _copy(source: Array, target: Array) -> None:
    for i in range(len(source)):
        target[i] = source[i]


@kernel
def careful_step(  # noqa: C901, PLR0912, PLR0915 - its parts share more variables than a call can return
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
    kinks: bool,
    tried: bool,
    result: Array,
    remembered: Array,
    work: Array,
) -> tuple[float, bool]:
    """Advance ``state`` and ``memory`` in place over a step that may hold events; direction and stuck at its end.

    ``tried`` says that ``result`` and ``remembered`` hold what a step without events led to. ``work`` has ten rows.
    """
    size, count = len(state), len(memory)
    spare = work[7, :size]
    before, after = work[8, : count + 2], work[9, : count + 2]
    done = 0.0
    if kinks:
        switches(m, time, state, first, memory, direction, before)
    for _ in range(MOST_EVENTS):
        left = step - done
        if left <= SHORTEST_PART * step:
            return direction, stuck
        signal = first + (last - first) * done / step
        now = time + done * m.time_unit
        hold = 0.0
        if dry and not stuck and direction == 0.0:
            velocity = free_velocity(m, state, signal)
            if velocity == 0.0:
                direction, stuck = settle(m, now, state, signal, memory, spare)
            else:
                direction = 1.0 if velocity > 0.0 else -1.0
        elif stuck:
            # The input may have jumped since.
            hold = _holding_force(m, now, state, signal, memory, spare)
            if abs(hold) > friction_level(m.forces, now, dot(m.position, state), 0.0, signal) * (1.0 + 1e-12):
                stuck, direction = False, (m.forces.along if hold > 0.0 else -m.forces.along)
        if not tried:
            _runge_kutta(m, now, left, state, memory, signal, last, direction, stuck, result, remembered, work)
        tried = False
        ending = now + left * m.time_unit
        share, event, which = 1.0, 0, 0
        if stuck:
            hold_end = _holding_force(m, ending, result, last, remembered, spare)
            level = friction_level(m.forces, ending, dot(m.position, result), 0.0, last)
            if abs(hold_end) > level:
                hold = _holding_force(m, now, state, signal, memory, spare)
                sign = 1.0 if hold_end > 0.0 else -1.0
                reserve = max(friction_level(m.forces, now, dot(m.position, state), 0.0, signal) - sign * hold, 0.0)
                share, event = reserve / (reserve + sign * hold_end - level), 1
        elif dry:
            velocity_end = dot(m.velocity, result)
            if direction * velocity_end < 0.0:
                velocity = dot(m.velocity, state)
                # A body that has just started to slip leaves zero in its direction; anything else is a reversal.
                share, event = 0.0, 2
                if direction * velocity > 0.0:
                    _slope(m, now, state, signal, memory, direction, False, spare)
                    slope_start = left * dot(m.velocity, spare)
                    _slope(m, ending, result, last, remembered, direction, False, spare)
                    share = _first_root(velocity, slope_start, velocity_end, left * dot(m.velocity, spare))
        if kinks:
            switches(m, ending, result, last, remembered, direction, after)
            for i in range(count + 2):
                if before[i] * after[i] < 0.0:
                    crossing = _crossing(
                        m, i, now, left, state, memory, signal, result, remembered, last, direction, stuck, before[i],
                        after[i], work,
                    )  # fmt: skip
                    if crossing < share:
                        share, event, which = crossing, 3, i
        if event == 0:
            _copy(result, state)
            _copy(remembered, memory)
            return direction, stuck
        part = share * left
        side = after[which]
        if share > SHORTEST_PART:
            middle = signal + (last - signal) * share
            _runge_kutta(m, now, part, state, memory, signal, middle, direction, stuck, result, remembered, work)
            _copy(result, state)
            _copy(remembered, memory)
        done += part
        signal = first + (last - first) * done / step
        now = time + done * m.time_unit
        if event == 1:
            stuck = False
            hold = _holding_force(m, now, state, signal, memory, spare)
            direction = m.forces.along if hold > 0.0 else -m.forces.along
        elif event == 2:
            # The rest of the velocity is the error of the root; it would count as a direction.
            correction = dot(m.velocity, state) / dot(m.velocity, m.force_vector)
            for i in range(size):
                state[i] -= m.force_vector[i] * correction
            direction, stuck = settle(m, now, state, signal, memory, spare)
        if kinks:
            switches(m, now, state, signal, memory, direction, before)
            if event == 3:
                # The rounding of the root must not lead to the same kink again.
                before[which] = 1e-300 if side > 0.0 else -1e-300
    # More events than that are chatter: the rest of the step as it goes.
    left = step - done
    signal = first + (last - first) * done / step
    now = time + done * m.time_unit
    _runge_kutta(m, now, left, state, memory, signal, last, direction, stuck, result, remembered, work)
    _copy(result, state)
    _copy(remembered, memory)
    if dry and not stuck and direction * dot(m.velocity, state) < 0.0:
        direction = -direction
    return direction, stuck
