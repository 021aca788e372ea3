"""A step of a system with forces: without an event, or split at events.

Between events a step is that of :mod:`camid.engine.smooth_step`. A step in which a force jumps or has a kink is taken
again by :mod:`camid.engine.events`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.compiled import kernel
from camid.engine.events import careful_step, runge_kutta
from camid.engine.forces import Mechanics, dot, free_velocity, switches, switches_at
from camid.engine.plant_equations import remember_extremes
from camid.engine.smooth_step import SmoothStep, smooth_step
from camid.engine.workspace import Kinds, Workspace, copy

Array = NDArray[np.float64]


class Shocks(NamedTuple):
    """Sorted times in seconds at which a force jumps, and times and sizes of impulses."""

    breaks: Array
    impulse_times: Array
    impulse_sizes: Array


@kernel(inline="always")
def is_shocked(shocks: Shocks, next_break: int, next_impulse: int, finish: float) -> bool:
    """Whether a force jumps until a time, or an impulse strikes before it."""
    breaking = next_break < len(shocks.breaks) and shocks.breaks[next_break] <= finish
    return breaking or (next_impulse < len(shocks.impulse_times) and shocks.impulse_times[next_impulse] < finish)


@kernel(inline="always")
def can_be_smooth(kinds: Kinds, shocked: bool, stuck: bool, direction: float) -> bool:
    """Whether nothing that is known at the start of a step keeps it from being one without events."""
    return not (shocked or stuck or (kinds.dry and direction == 0.0))


@kernel(forceinline=True)
def _equations_step(
    m: Mechanics, room: Workspace, time: float, step: float, first: float, last: float, direction: float
) -> tuple[float, float]:
    """Step of a plant of equations without events; position and velocity in its middle."""
    runge_kutta(
        m, time, step, room.state, room.memory, first, last, direction, False,
        room.following, room.remembered, room.work,
    )  # fmt: skip
    remember_extremes(m.equations, room.following, room.work[1], room.work[2], step)
    start, end = dot(m.position, room.state), dot(m.position, room.following)
    slope, slope_end = free_velocity(m, room.state, first), free_velocity(m, room.following, last)
    halfway = 0.5 * (start + end) + 0.125 * step * (slope - slope_end)
    return halfway, 1.5 * (end - start) / step - 0.25 * (slope + slope_end)


@kernel(inline="always")
def step_unless_event(
    m: Mechanics,
    c: SmoothStep,
    kinds: Kinds,
    room: Workspace,
    time: float,
    step: float,
    first: float,
    last: float,
    direction: float,
    known: bool,
) -> tuple[bool, bool, float, float]:
    """Step without events, taken back where there is one; ``known`` says that ``room.before`` holds the switches.

    Returns
    -------
    event, twice : bool
        Whether the step holds an event, and whether it holds two of a kind, which its ends do not show.
    largest, doubt : float
        See :func:`camid.engine.smooth_step.smooth_step`.
    """
    state, following, memory, remembered = room.state, room.following, room.memory, room.remembered
    before, between, after = room.before, room.between, room.after
    if m.equations.function != 0:
        halfway, speed = _equations_step(m, room, time, step, first, last, direction)
        largest, doubt = abs(first), 0.0
    else:
        halfway, speed, largest, doubt = smooth_step(
            m, c, time, step, state, memory, first, last, direction, kinds.remembers, remembered, following
        )
    event = kinds.dry and direction * dot(m.velocity, following) < 0.0
    twice = kinds.dry and not event and direction * speed < 0.0
    if kinds.kinks:
        if not known:
            switches(m, time, state, first, memory, direction, before)
        switches(m, time + step, following, last, remembered, direction, after)
        middle = 0.5 * (first + last)
        switches_at(m.forces, time + 0.5 * step, halfway, speed, middle, memory, direction, between)
        for i in range(len(before)):
            event = event or before[i] * after[i] < 0.0
            twice = twice or (before[i] * after[i] > 0.0 and before[i] * between[i] < 0.0)
    if not (event or twice):
        copy(following, state)
        if kinds.kinks:
            copy(after, before)
        if kinds.remembers:
            copy(remembered, memory)
    return event, twice, largest, doubt


@kernel(inline="always")
def step_in_parts(
    m: Mechanics,
    kinds: Kinds,
    room: Workspace,
    shocks: Shocks,
    time: float,
    step: float,
    first: float,
    last: float,
    direction: float,
    stuck: bool,
    tried: bool,
    twice: bool,
    next_break: int,
    next_impulse: int,
) -> tuple[float, bool, int, int]:
    """Step with events, in parts between the times at which a force jumps or an impulse strikes.

    Returns direction and stuck at its end, and the next break and impulse. ``tried`` says that ``room`` holds what a
    step without events led to, ``twice`` that two events of one kind were found: each half has one of them.
    """
    breaks, impulse_times = shocks.breaks, shocks.impulse_times
    finish = time + step
    breaking = next_break < len(breaks) and breaks[next_break] <= finish
    at, value = time, first
    part, whole = (0.5 * step, False) if twice else (step, tried)
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
            scaled = (until - at - 2.0 * margin) / m.time_unit
            direction, stuck = careful_step(
                m, kinds, room, at + margin, scaled, value, until_value, direction, stuck, whole
            )
        at, value = until, until_value
        if kind == 1:
            next_break += 1
        elif kind == 2:
            for i in range(len(room.state)):
                room.state[i] += m.force_vector[i] * shocks.impulse_sizes[next_impulse] / m.time_unit
            next_impulse += 1
            stuck, direction = False, 0.0
        elif until >= finish:
            return direction, stuck, next_break, next_impulse
