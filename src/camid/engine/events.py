"""Steps that hold events: reversals under dry friction, stick and slip, and kinks of a force.

The step is split where the cubic through values and slopes at its ends says that the event is, and the parts are
classical Runge–Kutta steps. A body that sticks is held by whatever force keeps its velocity at zero, up to the level of
friction at rest.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.compiled import kernel
from camid.engine.forces import Mechanics, dot, force_in, free_velocity, friction_level, remember, switches
from camid.engine.plant_equations import entering, free_rates, held_rates, plant_rates, project
from camid.engine.smooth_step import HeldStep
from camid.engine.workspace import Kinds, Workspace, copy

Array = NDArray[np.float64]

# Events that one step may be split at; more than a few mean that the step is too long for the force.
MOST_EVENTS = 12
# A part of a step shorter than this share of it is not worth a step of its own.
SHORTEST_PART = 1e-9
# Share of a step over which the slope of a switch is taken.
PROBE = 1e-4
# Kinds of events: a body that sticks starts to slip, one that slips comes to rest, and a force has a kink.
NO_EVENT, RELEASE, REVERSAL, KINK = range(4)


@kernel(forceinline=True)
def _slope(
    m: Mechanics, time: float, state: Array, signal: float, memory: Array, direction: float, stuck: bool, result: Array
) -> None:
    """Derivative of the state by the scaled time; a stuck body keeps its velocity."""
    size, force = len(state), 0.0
    if m.equations.function == 0 or m.equations.forced:
        if m.equations.function != 0:
            project(m.equations, state)
        force = force_in(m, time, state, signal, memory, 0.0 if stuck else direction)
    for i in range(size):
        total = m.input_vector[i] * signal + m.force_vector[i] * force
        for j in range(size):
            total += m.state_matrix[i, j] * state[j]
        result[i] = total
    if m.equations.function != 0:
        driven = entering(m.equations, state, signal, force)
        if not m.equations.forced:
            at = m.equations.first + m.equations.order + (2 if m.equations.reads else 0)
            output = state[at]
            free_rates(m.equations, state, driven, result)
            # What follows the plant was taken to be driven by the output of an earlier stage.
            for i in range(at + 2, size):
                result[i] += m.state_matrix[i, at] * (state[at] - output)
        elif stuck:
            held_rates(m.equations, state, driven, result)
        else:
            plant_rates(m.equations, state, driven, result)
        return
    if stuck:
        hold = dot(m.velocity, result) / dot(m.velocity, m.force_vector)
        for i in range(size):
            result[i] -= m.force_vector[i] * hold


@kernel
def _holding_force(m: Mechanics, time: float, state: Array, signal: float, memory: Array, work: Array) -> float:
    """Force along the input that a body at rest would have to overcome to keep from accelerating."""
    if m.equations.function != 0:
        project(m.equations, state)
        force = force_in(m, time, state, signal, memory, 0.0)
        return held_rates(m.equations, state, entering(m.equations, state, signal, force), work)
    _slope(m, time, state, signal, memory, 0.0, False, work)
    return dot(m.velocity, work) / dot(m.velocity, m.force_vector)


@kernel(forceinline=True)
def runge_kutta(
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
        elapsed = share * step * m.time_unit
        now = time + elapsed
        if m.equations.forced:
            project(m.equations, work[4, :size])
        remember(m.forces, now, elapsed, dot(m.position, work[4, :size]) - origin, memory, remembered)
        signal = first + share * (last - first)
        _slope(m, now, work[4, :size], signal, remembered, direction, stuck, work[stage, :size])
    for i in range(size):
        result[i] = state[i] + step / 6.0 * (work[0, i] + 2.0 * work[1, i] + 2.0 * work[2, i] + work[3, i])
    if m.equations.function != 0:
        project(m.equations, result)
    elapsed = step * m.time_unit
    remember(m.forces, time + elapsed, elapsed, dot(m.position, result) - origin, memory, remembered)


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


class _Part(NamedTuple):
    """What is left of a step: time in seconds, scaled length, input at its start and end, direction and stuck."""

    time: float
    length: float
    first: float
    last: float
    direction: float
    stuck: bool


@kernel(inline="always")
def _how_it_starts(
    m: Mechanics, dry: bool, time: float, signal: float, direction: float, stuck: bool, room: Workspace, spare: Array
) -> tuple[float, bool]:
    """Direction of slip and whether the body sticks, where the velocity is zero or the input may have jumped."""
    state, memory = room.state, room.memory
    if dry and not stuck and direction == 0.0:
        velocity = free_velocity(m, state, signal)
        if velocity == 0.0:
            return settle(m, time, state, signal, memory, spare)
        return (1.0 if velocity > 0.0 else -1.0), False
    if stuck:
        hold = _holding_force(m, time, state, signal, memory, spare)
        if abs(hold) > friction_level(m.forces, time, dot(m.position, state), 0.0, signal) * (1.0 + 1e-12):
            return (m.forces.along if hold > 0.0 else -m.forces.along), False
    return direction, stuck


@kernel(inline="always")
def _release(m: Mechanics, part: _Part, room: Workspace, spare: Array) -> tuple[float, int]:
    """Share of a part at which a body that sticks starts to slip, with the event's kind."""
    ending = part.time + part.length * m.time_unit
    hold_end = _holding_force(m, ending, room.following, part.last, room.remembered, spare)
    level = friction_level(m.forces, ending, dot(m.position, room.following), 0.0, part.last)
    if not abs(hold_end) > level:
        return 1.0, NO_EVENT
    hold = _holding_force(m, part.time, room.state, part.first, room.memory, spare)
    sign = 1.0 if hold_end > 0.0 else -1.0
    held = friction_level(m.forces, part.time, dot(m.position, room.state), 0.0, part.first)
    reserve = max(held - sign * hold, 0.0)
    return reserve / (reserve + sign * hold_end - level), RELEASE


@kernel(inline="always")
def _reversal(m: Mechanics, part: _Part, room: Workspace, spare: Array) -> tuple[float, int]:
    """Share of a part at which a body that slips comes to rest, with the event's kind."""
    direction, velocity_end = part.direction, dot(m.velocity, room.following)
    if not direction * velocity_end < 0.0:
        return 1.0, NO_EVENT
    velocity = dot(m.velocity, room.state)
    # A body that has just started to slip leaves zero in its direction; anything else is a reversal.
    if not direction * velocity > 0.0:
        return 0.0, REVERSAL
    _slope(m, part.time, room.state, part.first, room.memory, direction, False, spare)
    slope_start = part.length * dot(m.velocity, spare)
    ending = part.time + part.length * m.time_unit
    _slope(m, ending, room.following, part.last, room.remembered, direction, False, spare)
    return _first_root(velocity, slope_start, velocity_end, part.length * dot(m.velocity, spare)), REVERSAL


@kernel
def _crossing(m: Mechanics, index: int, part: _Part, room: Workspace, before: float, after: float) -> float:
    """Share of a part at which a switch changes its sign."""
    work, size, count = room.work, len(room.state), len(room.memory)
    probe = PROBE * part.length
    slope_start, slope_end = 0.0, 0.0
    for end in range(2):
        at = part.time + end * part.length * m.time_unit
        here, kept = (room.state, room.memory) if end == 0 else (room.following, room.remembered)
        signal = part.first if end == 0 else part.last
        sign = 1.0 if end == 0 else -1.0
        _slope(m, at, here, signal, kept, part.direction, part.stuck, work[5, :size])
        for i in range(size):
            work[4, i] = here[i] + sign * probe * work[5, i]
        beside = signal + sign * PROBE * (part.last - part.first)
        switches(m, at, work[4, :size], beside, kept, part.direction, work[6, : count + 2])
        slope = sign * (work[6, index] - (before if end == 0 else after)) / PROBE
        slope_start, slope_end = (slope, 0.0) if end == 0 else (slope_start, slope)
    return _first_root(before, slope_start, after, slope_end)


@kernel(inline="always")
def _first_event(
    m: Mechanics, kinds: Kinds, part: _Part, room: Workspace, before: Array, after: Array
) -> tuple[float, int, int]:
    """Share of a part at which its first event lies, the event's kind and, for a kink, the index of its switch.

    ``room`` holds the part's end; ``after`` is filled with the switches there.
    """
    share, event, which = 1.0, NO_EVENT, 0
    spare = room.work[7, : len(room.state)]
    if part.stuck:
        share, event = _release(m, part, room, spare)
    elif kinds.dry:
        share, event = _reversal(m, part, room, spare)
    if kinds.kinks:
        ending = part.time + part.length * m.time_unit
        switches(m, ending, room.following, part.last, room.remembered, part.direction, after)
        for i in range(len(after)):
            if before[i] * after[i] < 0.0:
                crossing = _crossing(m, i, part, room, before[i], after[i])
                if crossing < share:
                    share, event, which = crossing, KINK, i
    return share, event, which


@kernel
def held_step(
    m: Mechanics, c: HeldStep, room: Workspace, time: float, step: float, first: float, last: float, kinds: Kinds
) -> bool:
    """Step of a body that sticks over ``step`` seconds, taken back unless friction holds it at the end, too.

    What holds it cancels every other force, so that the rest of the system is linear and the step exact. It is not
    for a step at whose start the input jumps, which may release the body at once.
    """
    state, following, memory, remembered = room.state, room.following, room.memory, room.remembered
    if len(c.whole) == 0:
        return False
    for i in range(len(state)):
        total = c.input_columns[i, 0] * first + c.input_columns[i, 1] * (last - first)
        for j in range(len(state)):
            total += c.whole[i, j] * state[j]
        following[i] = total
    finish = time + step
    if kinds.remembers:
        moved = dot(m.position, following) - dot(m.position, state)
        remember(m.forces, finish, step, moved, memory, remembered)
    hold = _holding_force(m, finish, following, last, remembered, room.work[7, : len(state)])
    if not abs(hold) <= friction_level(m.forces, finish, dot(m.position, following), 0.0, last):
        return False
    copy(following, state)
    if kinds.remembers:
        copy(remembered, memory)
    return True


@kernel(inline="always")
def _advance(m: Mechanics, part: _Part, room: Workspace) -> None:
    """Step over a part from state and memory of ``room`` to those that follow."""
    runge_kutta(
        m, part.time, part.length, room.state, room.memory, part.first, part.last, part.direction, part.stuck,
        room.following, room.remembered, room.work,
    )  # fmt: skip


@kernel(inline="always")
def _accept(room: Workspace) -> None:
    copy(room.following, room.state)
    copy(room.remembered, room.memory)


@kernel(inline="always")
def _after_event(
    m: Mechanics, event: int, time: float, signal: float, direction: float, stuck: bool, room: Workspace, spare: Array
) -> tuple[float, bool]:
    """Direction of slip and whether the body sticks after an event."""
    state, memory = room.state, room.memory
    if event == RELEASE:
        hold = _holding_force(m, time, state, signal, memory, spare)
        return (m.forces.along if hold > 0.0 else -m.forces.along), False
    if event == REVERSAL:
        # The rest of the velocity is the error of the root; it would count as a direction.
        correction = dot(m.velocity, state) / dot(m.velocity, m.force_vector)
        for i in range(len(state)):
            state[i] -= m.force_vector[i] * correction
        return settle(m, time, state, signal, memory, spare)
    return direction, stuck


@kernel
def careful_step(
    m: Mechanics,
    kinds: Kinds,
    room: Workspace,
    time: float,
    step: float,
    first: float,
    last: float,
    direction: float,
    stuck: bool,
    tried: bool,
) -> tuple[float, bool]:
    """Advance state and memory in ``room`` over a step that may hold events; direction and stuck at its end.

    ``step`` is scaled; the input goes from ``first`` to ``last``. ``tried`` says that ``room.following`` and
    ``room.remembered`` hold what a step without events led to.
    """
    size, count = len(room.state), len(room.memory)
    spare = room.work[7, :size]
    before, after = room.work[8, : count + 2], room.work[9, : count + 2]
    done, now, signal = 0.0, time, first
    if kinds.kinks:
        switches(m, time, room.state, first, room.memory, direction, before)
    for _ in range(MOST_EVENTS):
        left = step - done
        if left <= SHORTEST_PART * step:
            return direction, stuck
        signal = first + (last - first) * done / step
        now = time + done * m.time_unit
        direction, stuck = _how_it_starts(m, kinds.dry, now, signal, direction, stuck, room, spare)
        part = _Part(now, left, signal, last, direction, stuck)
        if not tried:
            _advance(m, part, room)
        tried = False
        share, event, which = _first_event(m, kinds, part, room, before, after)
        if event == NO_EVENT:
            _accept(room)
            return direction, stuck
        if share > SHORTEST_PART:
            middle = signal + (last - signal) * share
            _advance(m, _Part(now, share * left, signal, middle, direction, stuck), room)
            _accept(room)
        done += share * left
        signal = first + (last - first) * done / step
        now = time + done * m.time_unit
        direction, stuck = _after_event(m, event, now, signal, direction, stuck, room, spare)
        if kinds.kinks:
            switches(m, now, room.state, signal, room.memory, direction, before)
            if event == KINK:
                # The rounding of the root must not lead to the same kink again.
                before[which] = 1e-300 if after[which] > 0.0 else -1e-300
    # More events than that are chatter: the rest of the step as it goes.
    _advance(m, _Part(now, step - done, signal, last, direction, stuck), room)
    _accept(room)
    if kinds.dry and not stuck and direction * dot(m.velocity, room.state) < 0.0:
        direction = -direction
    return direction, stuck
