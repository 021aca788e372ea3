"""Compiled integrator: classical Runge–Kutta of fourth order between events that are located in time.

Events are the reversal of a mass that slides on dry friction, its breaking away from sticking, the start and the end of
a contact, and every corner of the input. Steps end at all of them, so that none crosses a kink of the force but those
of a spring with a gap and of Jenkins elements that begin to slip, which cost the third order of the step.

Source: Hairer, Nørsett & Wanner (1993), Solving Ordinary Differential Equations I, sections II.1 and II.6.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.compiled import kernel, njit
from camid.proof.concealed import vector_layout as s
from camid.proof.concealed.machine_forces import (
    contact,
    derivative,
    jenkins,
    net_force,
    resting_level,
    scale_of_reading,
)

Array = NDArray[np.float64]

LARGEST_PHASE = 0.06  # rad of the fastest oscillation in a step
LARGEST_DECAY = 1.0  # of a step beside the shortest time constant
FEWEST_STEPS, MOST_STEPS = 10, 2000
LOCATED = 1e-12  # share of a step to which an event is located
REVERSAL, CONTACT, BREAK_AWAY = 1, 2, 3


class DivergedError(ValueError):
    """The motion left every bound: a softening spring was pulled over its top, say."""


@dataclass(frozen=True)
class Segments:
    """Input as it reaches the actuator: straight pieces, zero before the first.

    Attributes
    ----------
    start : ndarray, shape (n,)
        Times in s, not descending.
    value, slope : ndarray, shape (n,)
        V and V/s.
    kick : ndarray, shape (n,)
        Jump of the velocity at the start, in m/s (of the position in m without mass).
    """

    start: Array
    value: Array
    slope: Array
    kick: Array


@dataclass(frozen=True)
class Trajectory:
    """Measured point on a fine grid.

    Attributes
    ----------
    start, step : float
        Time of the first node and distance of two nodes, in s.
    position, integral : ndarray, shape (n + 1,)
        m, and m s from the first node.
    velocity_after, velocity_before : ndarray, shape (n,)
        Velocity in m/s at the start and at the end of each interval between nodes.
    command : ndarray, shape (N,), optional
        In V at the frames, of a motion that is recorded.
    """

    start: float
    step: float
    position: Array
    integral: Array
    velocity_after: Array
    velocity_before: Array
    command: Array | None = None


@kernel
def _beside(state: Array, h: float, rate: Array, result: Array) -> None:
    """A state a time h further on at a rate."""
    for i in range(s.STATES):
        result[i] = state[i] + h * rate[i]


@kernel
def _step(
    p: Array, state: Array, memory: Array, value: float, slope: float, t: float, h: float, direction: int, work: Array
) -> None:
    """One Runge–Kutta step; the new state is in ``work[5]``."""
    derivative(p, state, memory, value, t, direction, work[0])
    _beside(state, 0.5 * h, work[0], work[4])
    derivative(p, work[4], memory, value + 0.5 * h * slope, t + 0.5 * h, direction, work[1])
    _beside(state, 0.5 * h, work[1], work[4])
    derivative(p, work[4], memory, value + 0.5 * h * slope, t + 0.5 * h, direction, work[2])
    _beside(state, h, work[2], work[4])
    derivative(p, work[4], memory, value + h * slope, t + h, direction, work[3])
    for i in range(s.STATES):
        work[5, i] = state[i] + h / 6.0 * (work[0, i] + 2.0 * work[1, i] + 2.0 * work[2, i] + work[3, i])


@kernel
def _indicator(
    kind: int, p: Array, state: Array, memory: Array, command: float, t: float, direction: int, touching: bool
) -> float:
    """Positive before the event, negative after it."""
    if kind == REVERSAL:
        return direction * state[s.VELOCITY]
    if kind == CONTACT:
        depth = contact(p, state[s.POSITION], state[s.VELOCITY])
        return depth if touching else -depth
    force = net_force(p, state, memory, command, t, True)
    return resting_level(p, state, command, t, force) - abs(force)


@kernel
def _locate(
    kind: int,
    p: Array,
    state: Array,
    memory: Array,
    value: float,
    slope: float,
    t: float,
    h: float,
    direction: int,
    touching: bool,
    work: Array,
) -> float:
    """Duration after which the indicator of an event is just negative, by bisection."""
    low, high = 0.0, h
    while high - low > LOCATED * h:
        middle = 0.5 * (low + high)
        _step(p, state, memory, value, slope, t, middle, direction, work)
        if _indicator(kind, p, work[5], memory, value + slope * middle, t + middle, direction, touching) < 0.0:
            high = middle
        else:
            low = middle
    return high


@kernel
def _watched(kind: int, dry: bool, stop: bool, direction: int) -> bool:
    """Whether an event can happen."""
    if kind == CONTACT:
        return stop
    return direction != 0 if kind == REVERSAL else dry and direction == 0


@kernel
def _advance(
    p: Array, state: Array, memory: Array, value: float, slope: float, t: float, end: float, direction: int, work: Array
) -> int:
    """Bring the state from t to the end through all events; returns the direction of sliding (0: sticking)."""
    dry, stop = p[s.DRY_BREAKAWAY] != 0.0, p[s.STOP_SIDE] != 0.0
    # These forces have a kink where the motion turns round, but nothing sticks there.
    turning = p[s.BRISTLE_STIFFNESS] + p[s.LOOP_FORCE] + p[s.JENKINS_STIFFNESS] + p[s.SPEED_LIMIT] != 0.0
    memory[s.WITHIN] = 0.5 * (t + end)
    length = end - t
    rounds = 0
    while end - t > LOCATED * length:
        rounds += 1
        if dry and state[s.VELOCITY] == 0.0:
            force = net_force(p, state, memory, value, t, True)
            # The mass breaks away from rest, or stays in or comes to rest.
            direction = 0 if abs(force) <= resting_level(p, state, value, t, force) else int(np.sign(force))
        elif turning:
            direction = int(np.sign(state[s.VELOCITY]))
        touching = stop and contact(p, state[s.POSITION], state[s.VELOCITY]) > 0.0
        memory[s.TOUCHING] = 1.0 if touching else 0.0
        h = end - t
        _step(p, state, memory, value, slope, t, h, direction, work)
        if rounds < 50:
            for kind in (REVERSAL, CONTACT, BREAK_AWAY):
                if not _watched(kind, dry, stop, direction):
                    continue
                after = _indicator(kind, p, work[5], memory, value + slope * h, t + h, direction, touching)
                if after < 0.0:
                    h = _locate(kind, p, state, memory, value, slope, t, h, direction, touching, work)
                    _step(p, state, memory, value, slope, t, h, direction, work)
        if dry and direction != 0 and direction * work[5, s.VELOCITY] < 0.0:
            work[5, s.VELOCITY] = 0.0
        if p[s.JENKINS_STIFFNESS] != 0.0:
            x = work[5, s.POSITION]
            for element in range(s.JENKINS_ELEMENTS):
                memory[element] = jenkins(p, x, memory, element)
            memory[s.LAST_POSITION] = x
        for i in range(s.STATES):
            state[i] = work[5, i]
        if p[s.EDGE_HEIGHT] > 0.0 and p[s.EDGE_WEIR] == 0.0:
            state[s.POSITION] -= p[s.EDGE_SIDE] * max(p[s.EDGE_SIDE] * state[s.POSITION] - p[s.EDGE_HEIGHT], 0.0)
        t += h
        value += slope * h
    return direction


@njit
def _run(p: Array, begin: float, h: float, count: int, start: Array, value: Array, slope: Array, kick: Array) -> Array:
    """Nodes of the measured point: columns are position, integral, velocity after the node and before the next."""
    state, work, rate = np.zeros(s.STATES), np.zeros((6, s.STATES)), np.zeros(s.STATES)
    memory = np.zeros(s.MEMORY)
    table = np.zeros((count + 1, 4))
    segment, direction = -1, 0
    for i in range(count):
        t, end = begin + i * h, begin + (i + 1) * h
        first = True
        while True:
            while segment + 1 < len(start) and start[segment + 1] <= t + 1e-9 * h:
                segment += 1
                state[s.POSITION if p[s.MASS] == 0.0 else s.VELOCITY] += kick[segment]
                if kick[segment] != 0.0 and direction != 0:  # a blow may turn what slides, which does not stop then
                    direction = int(np.sign(state[s.VELOCITY]))
            now, rise = 0.0, 0.0
            if segment >= 0:
                now, rise = value[segment] + slope[segment] * (t - start[segment]), slope[segment]
            if first:
                memory[s.WITHIN] = t + 1e-6 * h
                derivative(p, state, memory, now, t, _direction(p, state, direction), rate)
                table[i, 2] = _measured_velocity(p, state, rate)
                first = False
            until = end
            if segment + 1 < len(start) and start[segment + 1] < end - 1e-9 * h:
                until = start[segment + 1]
            direction = _advance(p, state, memory, now, rise, t, until, direction, work)
            now += rise * (until - t)
            t = until
            if until == end:
                break
        derivative(p, state, memory, now, t, _direction(p, state, direction), rate)
        table[i, 3] = _measured_velocity(p, state, rate)
        table[i + 1, 0], table[i + 1, 1] = rate[s.INTEGRAL], state[s.INTEGRAL]
        if not abs(state[s.POSITION]) < 1e12:
            table[count, 0] = np.nan
            return table
    return table


@kernel
def _direction(p: Array, state: Array, direction: int) -> int:
    """A mass at rest does not slide."""
    return 0 if state[s.VELOCITY] == 0.0 and p[s.DRY_BREAKAWAY] != 0.0 else direction


@kernel
def _measured_velocity(p: Array, state: Array, rate: Array) -> float:
    """Velocity in m/s that the sensor reads."""
    velocity = _seen_velocity(p, state, rate)
    if p[s.SUPPLY_SAG] != 0.0:
        scale = scale_of_reading(p, state)
        velocity = scale * velocity - p[s.SUPPLY_SAG] * rate[s.DRAWN] * rate[s.INTEGRAL] / scale
    return velocity


@kernel
def _seen_velocity(p: Array, state: Array, rate: Array) -> float:
    """Velocity in m/s of the point that the camera sees."""
    if p[s.SECOND_SERIES_FREQUENCY] != 0.0:
        return rate[s.SECOND_SERIES]
    if p[s.SERIES_FREQUENCY] != 0.0 or p[s.SERIES_LAG] != 0.0:
        return rate[s.SERIES]
    return (rate[s.HIDDEN] if p[s.HIDDEN_IS_SEEN] != 0.0 else rate[s.POSITION]) + rate[s.BESIDE]


def steps_per_frame(parameters: Array, period: float) -> int:
    """Nodes in a frame that resolve the fastest motion of the machine."""
    p = parameters
    rates = [p[s.SERIES_FREQUENCY], p[s.SECOND_SERIES_FREQUENCY], p[s.BESIDE_FREQUENCY]]
    decays = [
        1.0 / p[i]
        for i in (s.LAG, s.SECOND_LAG, s.SERIES_LAG, s.SOFT_SLEW_TIME, s.WINDING_TIME, s.SUPPLY_TIME)
        if p[i] > 0.0
    ]
    if p[s.MASS] > 0.0:
        stiffness = p[s.STIFFNESS] + p[s.BRISTLE_STIFFNESS] + p[s.JENKINS_STIFFNESS] + p[s.MAXWELL_STIFFNESS]
        # A contact or a spring that hardens may be a few times as stiff as the mount.
        stiffness += p[s.STOP_STIFFNESS] if p[s.STOP_EXPONENT] == 1.0 else 3.0 * p[s.STIFFNESS]
        stiffness += p[s.HIDDEN_STIFFNESS] + p[s.LOOP_FORCE] * p[s.LOOP_SHAPE]
        rates.append(np.sqrt(stiffness / p[s.MASS]))
    else:
        rates.append(p[s.STIFFNESS] / p[s.DAMPING])
    if p[s.HIDDEN_MASS] > 0.0:
        rates.append(np.sqrt(p[s.HIDDEN_STIFFNESS] / p[s.HIDDEN_MASS]))
    if p[s.MAXWELL_STIFFNESS] > 0.0:
        decays.append(1.0 / (p[s.MAXWELL_TIME] * p[s.MAXWELL_RATIO] ** 2))
    if p[s.BRISTLE_STIFFNESS] > 0.0:
        decays.append(p[s.TOP_SPEED] * p[s.BRISTLE_STIFFNESS] / p[s.BRISTLE_COULOMB])
    decays.append(p[s.TOP_SPEED] * p[s.LOOP_SHAPE])
    needed = period * max(max(rates) / LARGEST_PHASE, max(decays) / LARGEST_DECAY)
    return int(np.clip(np.ceil(needed), FEWEST_STEPS, MOST_STEPS))


def integrate(
    parameters: Array, segments: Segments, period: float, first: int, last: int, refinement: int = 1
) -> Trajectory:
    """Motion of the machine, at rest at the first frame.

    Parameters
    ----------
    parameters : ndarray, shape (slots.PARAMETERS,)
        Physical units, see :mod:`camid.proof.concealed.vector_layout`.
    segments : Segments
    period : float
        s.
    first, last : int
        The motion runs from ``first * period`` to ``last * period``.
    refinement : int
        Divides the step.

    Raises
    ------
    DivergedError
        If the motion leaves every bound.
    """
    nodes = refinement * steps_per_frame(parameters, period)
    h, count = period / nodes, (last - first) * nodes
    table = _run(parameters, first * period, h, count, segments.start, segments.value, segments.slope, segments.kick)
    if not np.all(np.isfinite(table)):
        raise DivergedError("the motion diverges")
    return Trajectory(
        first * period,
        h,
        np.ascontiguousarray(table[:, 0]),
        np.ascontiguousarray(table[:, 1]),
        np.ascontiguousarray(table[:-1, 2]),
        np.ascontiguousarray(table[:-1, 3]),
    )
