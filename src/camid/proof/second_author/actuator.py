"""What an actuator makes of its command between two samples, compiled by numba."""

import math
from typing import Any

import numpy as np

from camid.compiled import njit

from .quantities import Actuator

Array = np.ndarray[Any, np.dtype[np.float64]]
STATES = 4  # play, rate-limited force, first and second lag


@njit(error_model="numpy")
def _without_memory(command: float, actuator: Array) -> float:
    """Return the command after the laws that have no memory (u)."""
    force = command + actuator[Actuator.BIAS]
    width = actuator[Actuator.DEAD_ZONE]
    if width > 0.0:
        soft = actuator[Actuator.DEAD_ZONE_SOFTNESS]
        size = abs(force)
        if soft > 0.0:
            # a softened corner that still starts at zero
            beyond = soft * (math.log1p(math.exp((size - width) / soft)) - math.log1p(math.exp(-width / soft)))
        else:
            beyond = max(size - width, 0.0)
        force = math.copysign(beyond, force)
    limit = actuator[Actuator.SATURATION]
    if limit > 0.0:
        if actuator[Actuator.SATURATION_ROUNDED] > 0.0:
            force = limit * math.tanh(force / limit)
        else:
            force = max(-limit, min(force, limit))
    if force < 0.0:
        force *= 1.0 + actuator[Actuator.NEGATIVE_GAIN_EXCESS]
    if actuator[Actuator.POWER_SCALE] > 0.0 and force != 0.0:
        force *= (abs(force) / actuator[Actuator.POWER_SCALE]) ** actuator[Actuator.POWER_EXCESS]
    if actuator[Actuator.LEVELS] > 0.0:
        force = actuator[Actuator.LEVELS] * math.floor(force / actuator[Actuator.LEVELS] + 0.5)
    return float(force)


@njit(error_model="numpy")
def _lagged(state: float, start: float, end: float, duration: float, time_constant: float) -> float:
    """Return the exact response (u) of a first-order lag to a straight line of that duration (s)."""
    if duration <= 0.0:
        return state
    slope = (end - start) / duration
    return end - time_constant * slope + (state - start + time_constant * slope) * math.exp(-duration / time_constant)


@njit(error_model="numpy")
def _play(state: float, force: float, width: float) -> float:
    """Return the position (u) of what a play of that half width (u) drags along."""
    return min(max(state, force - width), force + width)


@njit(error_model="numpy")
def _approach(state: float, force: float, duration: float, rate: float, softness: float) -> float:
    """Return what follows a force (u) no faster than a rate (u/s) after a duration (s)."""
    error = force - state
    if softness <= 0.0:
        return state + max(-rate * duration, min(error, rate * duration))
    middle = state + 0.5 * duration * rate * math.tanh(error / softness)
    change = duration * rate * math.tanh((force - middle) / softness)
    # a stiff approach does not pass its aim
    return state + max(-abs(error), min(change, abs(error)))


@njit(error_model="numpy")
def _with_memory(previous: float, current: float, duration: float, actuator: Array, state: Array) -> float:
    """Return the force (u) at the end of a straight line of that duration (s), at once where it is zero."""
    value = current
    if actuator[Actuator.BACKLASH] > 0.0:
        state[0] = _play(state[0], current, actuator[Actuator.BACKLASH])
        slope = actuator[Actuator.BACKLASH_SLOPE]
        value = (1.0 - slope) * state[0] + slope * current
    if actuator[Actuator.RATE] > 0.0:
        state[1] = _approach(state[1], current, duration, actuator[Actuator.RATE], actuator[Actuator.RATE_SOFTNESS])
        value = state[1]
    if actuator[Actuator.LAG] > 0.0:
        first = state[2]
        state[2] = _lagged(first, previous, current, duration, actuator[Actuator.LAG])
        value = state[2]
        if actuator[Actuator.SECOND_LAG] > 0.0:
            state[3] = _lagged(state[3], first, value, duration, actuator[Actuator.SECOND_LAG])
            value = state[3]
    return value


@njit(error_model="numpy")
def act(start: float, end: float, actuator: Array, state: Array, step: float, force: Array) -> None:
    """Write the force (u) at start, middle and end of each substep of ``step`` seconds; the state goes on.

    The command is a straight line between ``start`` and ``end`` (u), a level if they are equal.
    """
    substeps = force.shape[0]
    previous = _without_memory(start, actuator)
    force[0, 0] = _with_memory(previous, previous, 0.0, actuator, state)
    for point in range(1, 2 * substeps + 1):
        current = _without_memory(start + (end - start) * point / (2.0 * substeps), actuator)
        value = _with_memory(previous, current, 0.5 * step, actuator, state)
        previous = current
        if point % 2 == 1:
            force[point // 2, 1] = value
        else:
            force[point // 2 - 1, 2] = value
            if point < 2 * substeps:
                force[point // 2, 0] = value
