"""A step without events, differentiated stage by stage by its state and by the values of a law.

The stages are those of :mod:`camid.engine.smooth_step`. A force depends on position and velocity of its stage, so its
change is a row over the changes of the state, and a unit of force that a stage adds leads to a change of the state at
the end of the step, whatever adds it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.compiled import kernel, njit
from camid.engine.forces import Mechanics, force_at
from camid.engine.smooth_step import SmoothStep

Array = NDArray[np.float64]


class Law(NamedTuple):
    """A law among the forces, linear between knots, and the changes of it that derivatives are taken by.

    Attributes
    ----------
    effect, first : int
        Its row among the forces' values, and where the heights at its knots begin there.
    over_velocity : bool
        Whether its variable is the velocity, and not the position.
    times : int
        What the force is the law times: 0 nothing, 1 the velocity, 2 the input.
    knots, heights : ndarray, shape (k,)
    place : ndarray of int, shape (k + 1,)
        Where the changes of each height begin among ``column`` and ``share``, and where the last ones end.
    column, share : ndarray
        Changes in which a height has a part, and which, in units of the heights among the values.
    changes : ndarray, shape (c, k)
        The same changes times ``size``, so small that differences by them are derivatives.
    size : float
    begins, ends : ndarray of int, shape (c,)
        Heights that each changes: the first one, and the one behind the last.
    low, high : ndarray, shape (c,)
        Range of the variable in which each acts.
    """

    effect: int
    first: int
    over_velocity: bool
    times: int
    knots: Array
    heights: Array
    place: NDArray[np.int64]
    column: NDArray[np.int64]
    share: Array
    changes: Array
    size: float
    begins: NDArray[np.int64]
    ends: NDArray[np.int64]
    low: Array
    high: Array


class Stages(NamedTuple):
    """Room for the derivatives of one step, and the changes of position and velocity that they are taken from.

    Attributes
    ----------
    by_state : ndarray, shape (4, q)
        Derivative of the force at each stage by the state at the start of the step.
    to_end : ndarray, shape (4, q)
        Derivative of the state at the end of the step by what a stage adds to the force.
    at, factor : ndarray, shape (4,)
        Variable of the law at each stage, and what a height is multiplied with there.
    slopes : ndarray, shape (4, 2)
        Derivatives of the force at each stage by its position and its velocity.
    farther, faster : float
        Differences.
    """

    by_state: Array
    to_end: Array
    at: Array
    factor: Array
    slopes: Array
    farther: float
    faster: float


@njit
def stages_of(size: int, farther: float, faster: float) -> Stages:
    """Room for steps of a state, shape (q,)."""
    return Stages(
        np.zeros((4, size)),
        np.zeros((4, size)),
        np.zeros(4),
        np.zeros(4),
        np.zeros((4, 2)),
        farther if farther > 0.0 else 1.0,
        faster if faster > 0.0 else 1.0,
    )


@kernel(error_model="numpy", inline="always")
def _force_at_stage(
    m: Mechanics,
    law: Law,
    stages: Stages,
    stage: int,
    time: float,
    position: float,
    velocity: float,
    signal: float,
    memory: Array,
    direction: float,
) -> float:
    """Force at a stage; keeps its slopes there and what the law is multiplied with."""
    f, farther, faster = m.forces, stages.farther, stages.faster
    stages.at[stage] = velocity if law.over_velocity else position
    # The law acts against the motion: forces are taken from the input.
    stages.factor[stage] = -velocity if law.times == 1 else (-signal if law.times == 2 else -1.0)
    force = force_at(f, time, position, velocity, signal, memory, direction)
    slopes = stages.slopes[stage]
    slopes[0] = (force_at(f, time, position + farther, velocity, signal, memory, direction) - force) / farther
    slopes[1] = (force_at(f, time, position, velocity + faster, signal, memory, direction) - force) / faster
    return force


@kernel(error_model="numpy", inline="always")
def _fill_stages(
    m: Mechanics,
    c: SmoothStep,
    law: Law,
    stages: Stages,
    time: float,
    step: float,
    state: Array,
    memory: Array,
    first: float,
    last: float,
    direction: float,
) -> None:
    """The stages of a step, one after the other."""
    slope, inverse, at_half = last - first, 1.0 / m.time_unit, time + 0.5 * step
    middle = first + 0.5 * slope
    origin, velocity = 0.0, m.velocity_input * first
    half_position = c.input_half[0, 0] * first + c.input_half[0, 1] * slope
    half_velocity = c.input_half[1, 0] * first + c.input_half[1, 1] * slope
    whole_position = c.input_whole[0, 0] * first + c.input_whole[0, 1] * slope
    whole_velocity = c.input_whole[1, 0] * first + c.input_whole[1, 1] * slope
    for i in range(len(state)):
        origin += m.position[i] * state[i]
        velocity += m.velocity[i] * inverse * state[i]
        half_position += c.rows_half[0, i] * state[i]
        half_velocity += c.rows_half[1, i] * state[i]
        whole_position += c.rows_whole[0, i] * state[i]
        whole_velocity += c.rows_whole[1, i] * state[i]
    there, moving = c.force_half[0], c.force_half[1]
    begun = _force_at_stage(m, law, stages, 0, time, origin, velocity, first, memory, direction)
    position, halfway = half_position + there * begun, half_velocity + moving * begun
    force = _force_at_stage(m, law, stages, 1, at_half, position, halfway, middle, memory, direction)
    position, halfway = half_position + there * force, half_velocity + moving * force
    force = _force_at_stage(m, law, stages, 2, at_half, position, halfway, middle, memory, direction)
    change = 2.0 * force - begun
    position = whole_position + c.force_carried[0] * begun + there * change
    velocity = whole_velocity + c.force_carried[1] * begun + moving * change
    _force_at_stage(m, law, stages, 3, time + step, position, velocity, last, memory, direction)


@kernel(error_model="numpy")
def carry_smoothly(
    m: Mechanics,
    c: SmoothStep,
    law: Law,
    stages: Stages,
    time: float,
    step: float,
    state: Array,
    memory: Array,
    first: float,
    last: float,
    direction: float,
    carried: Array,
) -> None:
    """Rows of ``carried``: what becomes over a step of a change of each state; ``stages`` is filled.

    The force of a stage depends on those before it, with derivatives ``a``, ``b`` and ``d`` of the second by the first,
    the third by the second and the fourth by the third, and ``e`` of the fourth by the first.
    """
    _fill_stages(m, c, law, stages, time, step, state, memory, first, last, direction)
    slopes, size = stages.slopes, len(state)
    there, moving, rows_half, rows_whole = c.force_half[0], c.force_half[1], c.rows_half, c.rows_whole
    a = slopes[1, 0] * there + slopes[1, 1] * moving
    b = slopes[2, 0] * there + slopes[2, 1] * moving
    d = 2.0 * (slopes[3, 0] * there + slopes[3, 1] * moving)
    e = slopes[3, 0] * (c.force_carried[0] - there) + slopes[3, 1] * (c.force_carried[1] - moving)
    by, to, columns = stages.by_state, stages.to_end, c.force_columns
    for i in range(size):
        by[0, i] = slopes[0, 0] * m.position[i] + slopes[0, 1] * m.velocity[i] / m.time_unit
        by[1, i] = slopes[1, 0] * rows_half[0, i] + slopes[1, 1] * rows_half[1, i] + a * by[0, i]
        by[2, i] = slopes[2, 0] * rows_half[0, i] + slopes[2, 1] * rows_half[1, i] + b * by[1, i]
        by[3, i] = slopes[3, 0] * rows_whole[0, i] + slopes[3, 1] * rows_whole[1, i] + e * by[0, i] + d * by[2, i]
        to[3, i] = columns[i, 2]
        to[2, i] = columns[i, 1] + d * to[3, i]
        to[1, i] = columns[i, 1] + b * to[2, i]
        to[0, i] = columns[i, 0] + e * to[3, i] + a * to[1, i]
    for j in range(size):
        for i in range(size):
            total = c.whole[i, j] + columns[i, 0] * by[0, j]
            total += columns[i, 1] * (by[1, j] + by[2, j]) + columns[i, 2] * by[3, j]
            carried[j, i] = total


@kernel(error_model="numpy")
def add_values(law: Law, stages: Stages, size: int, changed: Array) -> None:
    """Add to the changes of the state, shape (q, c), what those of the law do at the stages of a step."""
    knots = law.knots
    last = len(knots) - 1
    for stage in range(4):
        at = stages.at[stage]
        low, share = 0, 0.0
        if at >= knots[last]:
            low, share = last - 1, 1.0
        elif at > knots[0]:
            low = min(int((at - knots[0]) / (knots[last] - knots[0]) * last), last - 1)
            # Most knots are about equally far apart, so that the right ones are near.
            while knots[low] > at:
                low -= 1
            while knots[low + 1] <= at:
                low += 1
            share = (at - knots[low]) / (knots[low + 1] - knots[low])
        for side in range(2):
            weight = (share if side == 1 else 1.0 - share) * stages.factor[stage]
            if weight == 0.0:
                continue
            for place in range(law.place[low + side], law.place[low + side + 1]):
                column, size_of_change = law.column[place], weight * law.share[place]
                for i in range(size):
                    changed[i, column] += size_of_change * stages.to_end[stage, i]
