"""The compiled integrator: a linear system with forces that depend on its motion, on a grid of equal steps.

Each step of a system with forces is that of :mod:`camid.engine.force_step`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.compiled import kernel, njit
from camid.engine.events import held_step
from camid.engine.feedback import Feedback, answered, passed_on, samples_at
from camid.engine.force_step import Shocks, can_be_smooth, is_shocked, step_in_parts, step_unless_event
from camid.engine.forces import Mechanics, dot, force_in
from camid.engine.plant_equations import doubt_of, project
from camid.engine.smooth_step import HeldStep, SmoothStep, held_step_of, linear_step, smooth_step_of
from camid.engine.workspace import Kinds, Workspace, copy, kinds_of, workspace_of

Array = NDArray[np.float64]

# Beyond this the motion runs away.
ASTRAY = 1e100


class Grid(NamedTuple):
    """Nodes of a run, with the input at the start and at the end of each step, shape (M,); times in seconds."""

    start: Array
    end: Array
    start_time: float
    step: float


class _Record(NamedTuple):
    """What a run leaves: measured motion, its rate and its integral at the nodes, and the rate at the end of a step."""

    measured: Array
    rate: Array
    integral: Array
    rate_end: Array


class _Direct(NamedTuple):
    """What a unit of input and a unit of force contribute at once to the derivative of the measured motion."""

    input: float
    force: float


@kernel
def _direct_rate(
    m: Mechanics, time: float, state: Array, signal: float, memory: Array, direction: float, direct: _Direct
) -> float:
    """What input and forces contribute at once to the derivative of the measured motion by the time in seconds."""
    total = direct.input * signal
    if direct.force != 0.0:
        total += direct.force * force_in(m, time, state, signal, memory, direction)
    return total / m.time_unit


@kernel
def passed(times: Array, now: float, inclusive: bool) -> int:
    """How many of sorted times lie before now, or at it."""
    count = 0
    while count < len(times) and (times[count] < now or (inclusive and times[count] == now)):
        count += 1
    return count


@kernel
def _run_away(node: int, record: _Record) -> None:
    """Nothing that follows a motion which runs away means anything."""
    for i in range(node, len(record.measured)):
        record.measured[i], record.rate[i], record.integral[i] = np.nan, np.nan, np.nan
        record.rate_end[max(i - 1, 0)] = np.nan


@kernel(inline="always")
def begin(m: Mechanics, room: Workspace, kinds: Kinds) -> tuple[_Direct, float]:
    """Fill the row of the derivative; what acts on it at once, and the direction of dry friction at the start."""
    size = len(room.state)
    row = m.state_matrix[size - 1]  # the integral grows by the measured motion
    for j in range(size):
        for i in range(size):
            room.derivative[j] += row[i] * m.state_matrix[i, j]
    if m.equations.function != 0:
        project(m.equations, room.state)
    direct = _Direct(dot(row, m.input_vector), dot(row, m.force_vector) if kinds.forced else 0.0)
    velocity = dot(m.velocity, room.state)
    if not kinds.dry or velocity == 0.0:
        return direct, 0.0
    return direct, 1.0 if velocity > 0.0 else -1.0


@kernel(inline="always")
def _record_rates(
    m: Mechanics,
    node: int,
    time: float,
    first: float,
    before: float,
    direction: float,
    direct: _Direct,
    room: Workspace,
    record: _Record,
) -> None:
    """Add to the rate at a node what ``first`` makes at once of it, and keep it as that of the last step's end.

    A jump of the input, which is ``before`` at the end of the last step, makes one of the velocity.
    """
    slope, state, memory = record.rate[node], room.state, room.memory
    record.rate[node] = slope + _direct_rate(m, time, state, first, memory, direction, direct)
    if node > 0:
        record.rate_end[node - 1] = record.rate[node]
        if before != first:
            record.rate_end[node - 1] = slope + _direct_rate(m, time, state, before, memory, direction, direct)


@kernel(inline="always")
def _doubt_about(m: Mechanics, doubt: float, largest: float) -> float:
    """How coarse the steps were, from the largest difference of forces and the largest force or input."""
    if m.equations.function != 0:
        return doubt_of(m.equations)
    return doubt / largest if largest > 0.0 else 0.0


@kernel
def _integrate(
    m: Mechanics, c: SmoothStep, h: HeldStep, grid: Grid, shocks: Shocks, feedback: Feedback, room: Workspace,
    record: _Record,
) -> float:  # fmt: skip
    """Run over the grid, fill the record and return the doubt; see :func:`integrate`."""
    state, memory, step, steps = room.state, room.memory, grid.step, len(grid.start)
    kinds = kinds_of(m)
    row = m.state_matrix[len(state) - 1]
    direct, direction = begin(m, room, kinds)
    at_once = direct.input != 0.0 or direct.force != 0.0
    known, stuck = False, False  # whether ``room.before`` holds the switches at the start of the step
    next_break = passed(shocks.breaks, grid.start_time, True)
    next_impulse = passed(shocks.impulse_times, grid.start_time, False)
    largest, doubt, held, passed_first, passed_last = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(steps + 1):
        time = grid.start_time + k * step
        measured = dot(row, state)
        record.measured[k] = measured
        record.integral[k] = state[len(state) - 1] * m.time_unit
        if not abs(measured) < ASTRAY:
            _run_away(k, record)
            return np.inf
        rate = dot(room.derivative, state) / m.time_unit
        record.rate[k] = rate
        before = (grid.end[k - 1] if k > 0 else grid.start[0]) + passed_last
        if samples_at(feedback, k):
            if at_once:
                rate += _direct_rate(m, time, state, before, memory, direction, direct)
            held = answered(feedback, k, step, rate, record.measured, record.rate, record.integral)
        passed_first, passed_last = passed_on(feedback, m.forces, step, held, memory)
        first = (grid.start[k] if k < steps else grid.end[k - 1]) + passed_first
        if at_once:
            _record_rates(m, k, time, first, before, direction, direct, room, record)
        elif k > 0:
            record.rate_end[k - 1] = record.rate[k]
        if k == steps:
            break
        last = grid.end[k] + passed_last
        largest = max(largest, abs(first))
        shocked = is_shocked(shocks, next_break, next_impulse, time + step)
        if not (kinds.stepwise or shocked):
            linear_step(c, state, first, last, room.following)
            copy(room.following, state)
            continue
        tried, twice = can_be_smooth(kinds, shocked, stuck, direction), False
        if tried:
            event, twice, size_of_force, difference = step_unless_event(
                m, c, kinds, room, time, step, first, last, direction, known and not at_once
            )
            known = not (event or twice)
            if known:
                largest, doubt = max(largest, size_of_force), max(doubt, difference)
                continue
        known = False
        if stuck and first == before and not shocked and held_step(m, h, room, time, step, first, last, kinds):
            continue
        direction, stuck, next_break, next_impulse = step_in_parts(
            m, kinds, room, shocks, time, step, first, last, direction, stuck, tried, twice, next_break, next_impulse
        )
    return _doubt_about(m, doubt, largest)


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
        What a controller or an observer adds to the input.

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
    steps = len(start)
    record = _Record(np.empty(steps + 1), np.empty(steps + 1), np.empty(steps + 1), np.empty(steps))
    grid = Grid(start, end, start_time, step)
    shocks = Shocks(breaks, impulse_times, impulse_sizes)
    room = workspace_of(m, initial)
    holds = kinds_of(m).dry and m.equations.function == 0
    smooth, held = smooth_step_of(m, step / m.time_unit), held_step_of(m, step / m.time_unit, holds)
    doubt = _integrate(m, smooth, held, grid, shocks, feedback, room, record)
    return record.measured, record.rate, record.integral, record.rate_end, doubt
