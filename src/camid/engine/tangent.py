"""Derivatives of a run by the values of a law that one of its forces follows, beside one run and not one for each.

A run is kept node by node. A matrix carries small changes of the state over each of its steps; what changes of the law
add to them, they add where the motion is near. So their number hardly counts.

A step without events is differentiated stage by stage: a value of the law acts on the stages between whose knots they
lie. Any other step is taken again from a state moved in each direction, and with each value of the law changed that may
matter: it is the same step, whatever happens in it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.compiled import kernel, njit
from camid.engine.events import held_step
from camid.engine.force_step import Shocks, can_be_smooth, is_shocked, step_in_parts, step_unless_event
from camid.engine.forces import Mechanics, dot, free_velocity
from camid.engine.integrator import Grid, begin, passed
from camid.engine.law_stages import Law, Stages, add_values, carry_smoothly, stages_of
from camid.engine.smooth_step import HeldStep, SmoothStep, held_step_of, smooth_step_of
from camid.engine.workspace import Kinds, Workspace, copy, kinds_of, workspace_of

Array = NDArray[np.float64]

# Change of a state from which a derivative is taken, as a share of the largest value that the state has in the run.
STATE_DIFFERENCE = 1e-6
# By how much the range of a law's variable in a step is widened on either side, as a share of it: a stage may lie a
# little outside of what the ends and the middle of the step show, and the parts of one with events further.
BESIDE, BESIDE_IN_PARTS = 0.5, 2.0
# Ways to take a step: without an event, of a body that sticks, and split at events.
SMOOTH, HELD, IN_PARTS = range(3)


class Path(NamedTuple):
    """A run, node by node, and how each of its steps was taken.

    Attributes
    ----------
    states, memories : ndarray, shapes (M + 1, q) and (M + 1, f)
    direction, stuck, next_break, next_impulse, way : ndarray, shape (M,)
        At the start of each step, and how it was taken.
    """

    states: Array
    memories: Array
    direction: Array
    stuck: NDArray[np.bool_]
    next_break: NDArray[np.int64]
    next_impulse: NDArray[np.int64]
    way: NDArray[np.int64]


class Changes(NamedTuple):
    """Derivatives of what a run leaves at some nodes, by each change of the law: shapes (w, c).

    The rate at the end of a step is that at the start of the next one, since the input does not depend on the law.
    """

    measured: Array
    rate: Array
    integral: Array


class _Run(NamedTuple):
    """What all steps of a run share; ``rows`` says where a node's changes are recorded, -1 where they are not."""

    smooth: SmoothStep
    held: HeldStep
    grid: Grid
    shocks: Shocks
    kinds: Kinds
    rows: NDArray[np.int64]


@kernel(inline="always")
def _take_step(
    m: Mechanics,
    run: _Run,
    room: Workspace,
    k: int,
    direction: float,
    stuck: bool,
    known: bool,
    next_break: int,
    next_impulse: int,
) -> tuple[int, float, bool, int, int]:
    """Step ``k`` of a run from the state in ``room``, as :func:`camid.engine.integrator.integrate` takes it.

    Returns how it was taken, and direction, stuck, and the next break and impulse at its end.
    """
    grid, kinds, shocks = run.grid, run.kinds, run.shocks
    step, time = grid.step, grid.start_time + k * grid.step
    first, last = grid.start[k], grid.end[k]
    before = grid.end[k - 1] if k > 0 else grid.start[0]
    shocked = is_shocked(shocks, next_break, next_impulse, time + step)
    tried, twice = can_be_smooth(kinds, shocked, stuck, direction), False
    if tried:
        event, twice, _, _ = step_unless_event(m, run.smooth, kinds, room, time, step, first, last, direction, known)
        if not (event or twice):
            return SMOOTH, direction, stuck, next_break, next_impulse
    if stuck and first == before and not shocked and held_step(m, run.held, room, time, step, first, last, kinds):
        return HELD, direction, stuck, next_break, next_impulse
    direction, stuck, next_break, next_impulse = step_in_parts(
        m, kinds, room, shocks, time, step, first, last, direction, stuck, tried, twice, next_break, next_impulse
    )
    return IN_PARTS, direction, stuck, next_break, next_impulse


@kernel
def _walk(m: Mechanics, run: _Run, at_once: bool, direction: float, room: Workspace, path: Path) -> None:
    """Run over the grid and keep each node."""
    grid, shocks = run.grid, run.shocks
    known, stuck = False, False
    next_break = passed(shocks.breaks, grid.start_time, True)
    next_impulse = passed(shocks.impulse_times, grid.start_time, False)
    for k in range(len(grid.start)):
        copy(room.state, path.states[k])
        copy(room.memory, path.memories[k])
        path.direction[k], path.stuck[k] = direction, stuck
        path.next_break[k], path.next_impulse[k] = next_break, next_impulse
        way, direction, stuck, next_break, next_impulse = _take_step(
            m, run, room, k, direction, stuck, known and not at_once, next_break, next_impulse
        )
        path.way[k] = way
        known = way == SMOOTH
    copy(room.state, path.states[len(grid.start)])
    copy(room.memory, path.memories[len(grid.start)])


@kernel(inline="always")
def _difference(room: Workspace, path: Path, k: int, size: float, result: Array) -> None:
    """By how much a step beside one of the run led elsewhere, by the size of what was moved, shape (q + f,)."""
    count = len(room.state)
    for i in range(count):
        result[i] = (room.state[i] - path.states[k + 1, i]) / size
    for i in range(len(room.memory)):
        result[count + i] = (room.memory[i] - path.memories[k + 1, i]) / size


@kernel(inline="always")
def _range(m: Mechanics, run: _Run, path: Path, k: int, over_velocity: bool) -> tuple[float, float]:
    """What a law's variable is in a step, widened; everything where the motion is shocked."""
    step, time = run.grid.step, run.grid.start_time + k * run.grid.step
    if is_shocked(run.shocks, path.next_break[k], path.next_impulse[k], time + step):
        return -np.inf, np.inf
    here, there = path.states[k], path.states[k + 1]
    start, end = dot(m.position, here), dot(m.position, there)
    slope = free_velocity(m, here, run.grid.start[k])
    slope_end = free_velocity(m, there, run.grid.end[k])
    middle = 0.5 * (start + end) + 0.125 * step * (slope - slope_end)
    if over_velocity:
        start, end, middle = slope, slope_end, 1.5 * (end - start) / step - 0.25 * (slope + slope_end)
    low, high = min(start, middle, end), max(start, middle, end)
    beside = (BESIDE if path.way[k] == SMOOTH else BESIDE_IN_PARTS) * (high - low)
    return low - beside, high + beside


@kernel(inline="always")
def _record_changes(m: Mechanics, room: Workspace, k: int, changed: Array, result: Changes) -> None:
    """What the changes of the state make of the measured motion at a node, in a row of the result, if there is one."""
    if k < 0:
        return
    last = len(room.state) - 1
    measured, rate, integral = result.measured[k], result.rate[k], result.integral[k]
    for c in range(len(measured)):
        measured[c], rate[c], integral[c] = 0.0, 0.0, changed[last, c] * m.time_unit
    for i in range(last):
        weight, slope, row = m.state_matrix[last, i], room.derivative[i] / m.time_unit, changed[i]
        if weight != 0.0:
            for c in range(len(measured)):
                measured[c] += weight * row[c]
        if slope != 0.0:
            for c in range(len(measured)):
                rate[c] += slope * row[c]


@kernel(inline="always")
def _carry_changes(carried: Array, changed: Array, following: Array) -> None:
    """Changes of the state, shape (q + f, c), after a step; row i of ``carried`` is what becomes of one of number i."""
    for i in range(len(carried)):
        row = following[i]
        for c in range(len(row)):
            row[c] = 0.0
        for j in range(len(carried)):
            share, source = carried[j, i], changed[j]
            if share != 0.0:
                for c in range(len(row)):
                    row[c] += share * source[c]
    for i in range(len(carried)):
        copy(following[i], changed[i])


@kernel(inline="always")
def _change_law(m: Mechanics, law: Law, c: int, changed: bool) -> None:
    """Let the law's heights be changed, or what they are in the run."""
    values = m.forces.values[law.effect]
    for j in range(law.begins[c], law.ends[c]):
        values[law.first + j] = law.heights[j] + law.changes[c, j] if changed else law.heights[j]


@kernel(inline="always")
def _is_idle(law: Law, sizes: Array, trial: int, last: int, low: float, high: float) -> bool:
    """Whether a step need not be taken with a number of the state moved or, behind those, with the law changed.

    Nothing depends on the integral but itself, and nothing on a number that no force remembers.
    """
    if trial < len(sizes):
        return trial == last or sizes[trial] == 0.0
    return law.low[trial - len(sizes)] >= high or law.high[trial - len(sizes)] <= low


@kernel
def _carry_by_steps(
    m: Mechanics, run: _Run, room: Workspace, path: Path, law: Law, sizes: Array, k: int,
    carried: Array, following: Array, changed: Array,
) -> None:  # fmt: skip
    """Carry the changes over step ``k`` by steps beside it, all taken in one place, which is one piece of code."""
    states, last, numbers = len(room.state), len(room.state) - 1, len(sizes)
    low, high = _range(m, run, path, k, law.over_velocity)
    for i in range(numbers):
        for j in range(numbers):
            carried[i, j] = 0.0
    carried[last, last] = 1.0
    for trial in range(numbers + len(law.low)):
        c = trial - numbers
        if c == 0:
            _carry_changes(carried, changed, following)
        if _is_idle(law, sizes, trial, last, low, high):
            continue
        size = law.size if c >= 0 else sizes[trial]
        for side in range(2):
            copy(path.states[k], room.state)
            copy(path.memories[k], room.memory)
            if c >= 0:
                _change_law(m, law, c, True)
            elif trial < states:
                room.state[trial] += size
            else:
                room.memory[trial - states] += size
            way, _, _, _, _ = _take_step(
                m, run, room, k, path.direction[k], path.stuck[k], False, path.next_break[k], path.next_impulse[k]
            )
            # A step taken in another way differs by the error of the ways, too: there the other side may do.
            if c >= 0 or side == 1 or way == path.way[k]:
                break
            size = -size
        if c < 0:
            _difference(room, path, k, size, carried[trial])
            continue
        _change_law(m, law, c, False)
        _difference(room, path, k, size, following[:, 0])
        for i in range(numbers):
            changed[i, c] += following[i, 0]


@kernel
def _tangents(
    m: Mechanics, run: _Run, room: Workspace, path: Path, law: Law, stages: Stages, sizes: Array,
    carried: Array, following: Array, changed: Array, result: Changes,
) -> None:  # fmt: skip
    """Carry the changes of the state, shape (q + f, c), over the run, and record them at the nodes."""
    grid, states = run.grid, len(room.state)
    for k in range(len(grid.start)):
        _record_changes(m, room, run.rows[k], changed, result)
        if run.kinds.remembers or path.way[k] == IN_PARTS:
            _carry_by_steps(m, run, room, path, law, sizes, k, carried, following, changed)
            continue
        smooth = path.way[k] == SMOOTH
        if smooth:
            time = grid.start_time + k * grid.step
            carry_smoothly(
                m, run.smooth, law, stages, time, grid.step, path.states[k], path.memories[k],
                grid.start[k], grid.end[k], path.direction[k], carried,
            )  # fmt: skip
        else:
            # A law moves no body that sticks.
            for i in range(states):
                for j in range(states):
                    carried[i, j] = run.held.whole[j, i]
        _carry_changes(carried[:states], changed, following)
        if smooth:
            add_values(law, stages, states, changed)
    _record_changes(m, room, run.rows[len(grid.start)], changed, result)


@njit(nogil=True)
def law_tangents(
    m: Mechanics,
    initial: Array,
    start: Array,
    end: Array,
    start_time: float,
    step: float,
    breaks: Array,
    impulse_times: Array,
    impulse_sizes: Array,
    law: Law,
    rows: NDArray[np.int64],
) -> Changes:
    """Derivatives of a run by changes of a law; the arguments but the last two are those of ``integrate``.

    ``rows``, shape (M + 1,), says in which row of the result a node is, -1 where it is in none.

    The plant has no equations, no force changes a velocity that it depends on at once, nor the rate of the measured
    motion.
    """
    steps, size, count = len(start), len(initial), m.forces.functions.shape[1]
    room, kinds = workspace_of(m, initial), kinds_of(m)
    run = _Run(
        smooth_step_of(m, step / m.time_unit),
        held_step_of(m, step / m.time_unit, kinds.dry),
        Grid(start, end, start_time, step),
        Shocks(breaks, impulse_times, impulse_sizes),
        kinds,
        rows,
    )
    path = Path(
        np.empty((steps + 1, size)),
        np.empty((steps + 1, count)),
        np.empty(steps),
        np.empty(steps, np.bool_),
        np.empty(steps, np.int64),
        np.empty(steps, np.int64),
        np.empty(steps, np.int64),
    )
    direct, direction = begin(m, room, kinds)
    _walk(m, run, direct.input != 0.0, direction, room, path)
    columns, numbers, nodes = len(law.low), size + count, np.max(rows) + 1
    result = Changes(np.empty((nodes, columns)), np.empty((nodes, columns)), np.empty((nodes, columns)))
    fastest, farthest = 0.0, 0.0
    for k in range(steps):
        farthest = max(farthest, abs(dot(m.position, path.states[k])))
        fastest = max(fastest, abs(free_velocity(m, path.states[k], start[k])))
    stages = stages_of(size, STATE_DIFFERENCE * farthest, STATE_DIFFERENCE * fastest)
    _tangents(
        m, run, room, path, law, stages, _differences(m, path), np.zeros((numbers, numbers)),
        np.empty((numbers, columns)), np.zeros((numbers, columns)), result,
    )  # fmt: skip
    return result


@njit
def _differences(m: Mechanics, path: Path) -> Array:
    """Changes of each number of the state that derivatives are taken from, shape (q + f,); 0 where no force remembers.

    A state that stays zero in the run is measured by the others: a law may move it.
    """
    size, count = path.states.shape[1], path.memories.shape[1]
    sizes = np.zeros(size + count)
    for i in range(size):
        sizes[i] = STATE_DIFFERENCE * np.max(np.abs(path.states[:, i]))
    largest = np.max(sizes[: size - 1])
    for i in range(size):
        if sizes[i] == 0.0:
            sizes[i] = largest if largest > 0.0 else STATE_DIFFERENCE
    for i in range(count):
        if m.forces.functions[2, i] != 0:
            found = STATE_DIFFERENCE * np.max(np.abs(path.memories[:, i]))
            sizes[size + i] = found if found > 0.0 else STATE_DIFFERENCE
    return sizes
