"""A run of the integrator that is kept node by node, so that each step can be taken again from another state."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.compiled import kernel, njit
from camid.engine.events import held_step
from camid.engine.force_step import Shocks, can_be_smooth, is_shocked, step_in_parts, step_unless_event
from camid.engine.forces import Mechanics
from camid.engine.integrator import Grid, passed
from camid.engine.smooth_step import HeldStep, SmoothStep
from camid.engine.workspace import Kinds, Workspace, copy

Array = NDArray[np.float64]

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


class Run(NamedTuple):
    """What all steps of a run share; ``rows`` says where a node's changes are recorded, -1 where they are not."""

    smooth: SmoothStep
    held: HeldStep
    grid: Grid
    shocks: Shocks
    kinds: Kinds
    rows: NDArray[np.int64]


@kernel
def take_step(
    m: Mechanics,
    run: Run,
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
def walk(m: Mechanics, run: Run, at_once: bool, direction: float, room: Workspace, path: Path) -> None:
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
        way, direction, stuck, next_break, next_impulse = take_step(
            m, run, room, k, direction, stuck, known and not at_once, next_break, next_impulse
        )
        path.way[k] = way
        known = way == SMOOTH
    copy(room.state, path.states[len(grid.start)])
    copy(room.memory, path.memories[len(grid.start)])


@njit
def path_of(steps: int, size: int, count: int) -> Path:
    """Room for a run of so many steps, of q = ``size`` states and f = ``count`` effects."""
    return Path(
        np.empty((steps + 1, size)),
        np.empty((steps + 1, count)),
        np.empty(steps),
        np.empty(steps, np.bool_),
        np.empty(steps, np.int64),
        np.empty(steps, np.int64),
        np.empty(steps, np.int64),
    )
