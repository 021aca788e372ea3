"""Derivatives of a run by the values of a law that a force or the input follows, beside one run and not one for each.

A run is kept node by node (:mod:`camid.engine.path`). A matrix carries small changes of the state over each of its
steps; what changes of the law add to them, they add where the motion is near. So their number hardly counts.

A step without events is differentiated stage by stage: a value of the law acts on the stages between whose knots they
lie. Any other step is taken again from a state moved in each direction, and with each value of the law changed that may
matter: it is the same step, whatever happens in it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.compiled import kernel, njit
from camid.engine.force_step import Shocks, is_shocked
from camid.engine.forces import Mechanics, dot, free_velocity
from camid.engine.integrator import Grid, begin
from camid.engine.law_stages import Law, Stages, add_values, carry_smoothly, stages_of
from camid.engine.path import HELD, IN_PARTS, SMOOTH, Path, Run, path_of, take_step, walk
from camid.engine.smooth_step import held_step_of, smooth_step_of
from camid.engine.workspace import Workspace, copy, kinds_of, workspace_of

Array = NDArray[np.float64]

# Change of a state from which a derivative is taken, as a share of the largest value that the state has in the run.
STATE_DIFFERENCE = 1e-6
# By how much the range of a law's variable in a step is widened on either side, as a share of it: a stage may lie a
# little outside of what the ends and the middle of the step show, and the parts of one with events further.
BESIDE, BESIDE_IN_PARTS = 0.5, 2.0


class Driven(NamedTuple):
    """Changes of the input at the start and at the end of each step, shapes (M, c); (0, c) where it does not change."""

    start: Array
    end: Array


class Changes(NamedTuple):
    """Derivatives of what a run leaves at some nodes, by each change of the law: shapes (w, c).

    The rate at the end of a step is that at the start of the next one, since the input does not depend on the law.
    """

    measured: Array
    rate: Array
    integral: Array


@kernel(inline="always")
def _difference(room: Workspace, path: Path, k: int, size: float, result: Array) -> None:
    """By how much a step beside one of the run led elsewhere, by the size of what was moved, shape (q + f,)."""
    count = len(room.state)
    for i in range(count):
        result[i] = (room.state[i] - path.states[k + 1, i]) / size
    for i in range(len(room.memory)):
        result[count + i] = (room.memory[i] - path.memories[k + 1, i]) / size


@kernel(inline="always")
def _range(m: Mechanics, run: Run, path: Path, k: int, over_velocity: bool) -> tuple[float, float]:
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
    m: Mechanics, run: Run, room: Workspace, path: Path, law: Law, sizes: Array, k: int,
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
            way, _, _, _, _ = take_step(
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
def _add_driven(
    m: Mechanics, run: Run, room: Workspace, path: Path, driven: Driven, size: float, k: int,
    by_input: Array, changed: Array,
) -> None:  # fmt: skip
    """Add to the changes of the state what those of the input in step ``k`` do."""
    for side in range(2):
        values = run.grid.start if side == 0 else run.grid.end
        changes = driven.start[k] if side == 0 else driven.end[k]
        if path.way[k] == HELD:
            columns = run.held.input_columns
            for i in range(len(by_input)):
                by_input[i] = 0.0
            for i in range(len(room.state)):
                by_input[i] = columns[i, 0] - columns[i, 1] if side == 0 else columns[i, 1]
        else:
            kept, moved = values[k], size
            for trial in range(2):
                copy(path.states[k], room.state)
                copy(path.memories[k], room.memory)
                values[k] = kept + moved
                way, _, _, _, _ = take_step(
                    m, run, room, k, path.direction[k], path.stuck[k], False, path.next_break[k], path.next_impulse[k]
                )
                if trial == 1 or way == path.way[k]:
                    break
                moved = -moved
            values[k] = kept
            _difference(room, path, k, moved, by_input)
        for i in range(len(by_input)):
            share, row = by_input[i], changed[i]
            if share != 0.0:
                for c in range(len(row)):
                    row[c] += share * changes[c]


@kernel
def _tangents(
    m: Mechanics, run: Run, room: Workspace, path: Path, law: Law, driven: Driven, stages: Stages, sizes: Array,
    size_of_input: float, carried: Array, following: Array, changed: Array, result: Changes,
) -> None:  # fmt: skip
    """Carry the changes of the state, shape (q + f, c), over the run, and record them at the nodes."""
    grid, states = run.grid, len(room.state)
    for k in range(len(grid.start)):
        _record_changes(m, room, run.rows[k], changed, result)
        if run.kinds.remembers or path.way[k] == IN_PARTS:
            _carry_by_steps(m, run, room, path, law, sizes, k, carried, following, changed)
        elif path.way[k] == SMOOTH:
            carry_smoothly(
                m, run.smooth, law, stages, grid.start_time + k * grid.step, grid.step, path.states[k],
                path.memories[k], grid.start[k], grid.end[k], path.direction[k], carried,
            )  # fmt: skip
            _carry_changes(carried[:states], changed, following)
            add_values(law, stages, states, changed)
        else:
            # A law of the forces moves no body that sticks.
            for i in range(states):
                for j in range(states):
                    carried[i, j] = run.held.whole[j, i]
            _carry_changes(carried[:states], changed, following)
        if len(driven.start) > 0:
            _add_driven(m, run, room, path, driven, size_of_input, k, following[:, 0], changed)
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
    driven: Driven,
    rows: NDArray[np.int64],
) -> Changes:
    """Derivatives of a run by changes of a law or of the input; the first arguments are those of ``integrate``.

    ``rows``, shape (M + 1,), says in which row of the result a node is, -1 where it is in none.

    The plant has no equations, no force changes a velocity that it depends on at once, nor the rate of the measured
    motion, and nor does an input that changes. What starts and ends the steps are two arrays.
    """
    steps, size, count = len(start), len(initial), m.forces.functions.shape[1]
    room, kinds = workspace_of(m, initial), kinds_of(m)
    run = Run(
        smooth_step_of(m, step / m.time_unit),
        held_step_of(m, step / m.time_unit, kinds.dry),
        Grid(start, end, start_time, step),
        Shocks(breaks, impulse_times, impulse_sizes),
        kinds,
        rows,
    )
    path = path_of(steps, size, count)
    direct, direction = begin(m, room, kinds)
    walk(m, run, direct.input != 0.0, direction, room, path)
    columns, numbers, nodes = len(law.low), size + count, np.max(rows) + 1
    result = Changes(np.empty((nodes, columns)), np.empty((nodes, columns)), np.empty((nodes, columns)))
    fastest, farthest = 0.0, 0.0
    for k in range(steps):
        farthest = max(farthest, abs(dot(m.position, path.states[k])))
        fastest = max(fastest, abs(free_velocity(m, path.states[k], start[k])))
    stages = stages_of(size, STATE_DIFFERENCE * farthest, STATE_DIFFERENCE * fastest)
    largest = STATE_DIFFERENCE * max(np.max(np.abs(start)), np.max(np.abs(end)))
    _tangents(
        m, run, room, path, law, driven, stages, _differences(m, path), largest if largest > 0.0 else STATE_DIFFERENCE,
        np.zeros((numbers, numbers)), np.empty((numbers, columns)), np.zeros((numbers, columns)), result,
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
