"""Integration of a rig in time: Runge-Kutta of fourth order with located reversals, compiled by numba.

The plant is x' = A x + B (u' + d - f), y = C x. Between two samples there is a fixed number of substeps. Dry friction
is set-valued: the body moves in one direction under a friction of known sign until its velocity vanishes, which is
located by bisection, and then sticks as long as the friction that holds it is within its limits.
"""

import math

import numpy as np

from camid.compiled import njit

from .actuator import STATES, Array, act
from .forces import MEMORIES, differentiate, friction_level
from .quantities import Force, Friction

BISECTIONS = 40
REVERSALS = 6  # within one substep, at most


@njit(error_model="numpy")
def _advance(
    time: float,
    state: Array,
    step: float,
    driven: Array,
    part: int,
    disturbance: Array,
    whole: int,
    direction: int,
    plant: Array,
    force: Array,
    friction: Array,
    slopes: Array,
    result: Array,
) -> None:
    """Write the state after one step (s) of the classical Runge-Kutta method; inputs (u) at start, middle and end."""
    size = state.shape[0]
    result[:] = state
    # one call in a loop: four of them take four times as long to compile
    for stage in range(4):
        point = (stage + 1) // 2
        now = time + 0.5 * point * step
        u_now, d_now = driven[part, point], disturbance[whole, point]
        differentiate(now, result, u_now, d_now, direction, plant, force, friction, slopes, stage)
        reach = step if stage == 2 else 0.5 * step
        if stage < 3:
            for i in range(size):
                result[i] = state[i] + reach * slopes[stage, i]
    for i in range(size):
        result[i] = state[i] + step / 6.0 * (slopes[0, i] + 2.0 * (slopes[1, i] + slopes[2, i]) + slopes[3, i])


@njit(error_model="numpy")
def _dot(plant: Array, row: int, state: Array) -> float:
    """Return the output (row 1), or its rate (row 2)."""
    order = plant.shape[1]
    total = 0.0
    for i in range(order):
        total += plant[order + row, i] * state[i]
    return total


@njit(error_model="numpy")
def _cut(ends: Array, row: int, start: float, stop: float, cuts: Array, place: int) -> None:
    """Write the values at start, middle and end of a part of a substep, on a parabola through those of the whole."""
    for i in range(3):
        s = start + (stop - start) * 0.5 * i
        cuts[place, i] = (
            ends[row, 0] * (1.0 - s) * (1.0 - 2.0 * s)
            + ends[row, 1] * 4.0 * s * (1.0 - s)
            + ends[row, 2] * s * (2.0 * s - 1.0)
        )


@njit(error_model="numpy")
def _departure(
    time: float,
    state: Array,
    driven: float,
    disturbance: float,
    plant: Array,
    force: Array,
    friction: Array,
    slopes: Array,
) -> int:
    """Return the direction in which a body at rest starts to move, 0 if it sticks."""
    holding = differentiate(time, state, driven, disturbance, 0, plant, force, friction, slopes, 0)
    position = _dot(plant, 1, state)
    if holding > friction_level(1, position, 0.0, driven, friction):
        return 1
    if holding < -friction_level(-1, position, 0.0, driven, friction):
        return -1
    return 0


@njit(error_model="numpy")
def _stop(state: Array, plant: Array) -> None:
    """Remove the velocity of the output from the state."""
    order = plant.shape[1]
    rest = _dot(plant, 2, state) / _dot(plant, 2, plant[order])
    for i in range(order):
        state[i] -= plant[order, i] * rest


@njit(error_model="numpy")
def _with_friction(
    time: float,
    state: Array,
    step: float,
    driven: Array,
    part: int,
    disturbance: Array,
    whole: int,
    direction: int,
    plant: Array,
    force: Array,
    friction: Array,
    slopes: Array,
    cuts: Array,
    result: Array,
) -> int:
    """Advance a body with dry friction by one step (s), locate its reversals, and return its direction."""
    done = 0.0
    for reversal in range(REVERSALS + 1):
        _cut(driven, part, done, 1.0, cuts, 0)
        _cut(disturbance, whole, done, 1.0, cuts, 1)
        now = time + done * step
        if reversal == REVERSALS:
            # more reversals than this are the shudder of rounding about rest: the body sticks for the rest of the step
            direction = 0
        elif direction == 0:
            direction = _departure(now, state, cuts[0, 0], cuts[1, 0], plant, force, friction, slopes)
        low, high, share = 0.0, 1.0, 1.0
        for trial in range(BISECTIONS + 1):
            if trial > 0:
                share = 0.5 * (low + high)
                _cut(driven, part, done, done + share * (1.0 - done), cuts, 0)
                _cut(disturbance, whole, done, done + share * (1.0 - done), cuts, 1)
            span = share * (1.0 - done) * step
            _advance(now, state, span, cuts, 0, cuts, 1, direction, plant, force, friction, slopes, result)
            onward = direction == 0 or _dot(plant, 2, result) * direction >= 0.0
            if onward and trial == 0:
                state[:] = result
                return direction
            if onward:
                low = share
            else:
                high = share
        state[:] = result
        _stop(state, plant)
        direction = 0
        done += high * (1.0 - done)
        if done > 1.0 - 1e-9:
            return 0
    return 0


@njit(error_model="numpy")
def _kick(state: Array, impulse: float, direction: int, plant: Array) -> int:
    """Add an impulse (u s) to the state, and return the direction of the motion after it."""
    order = plant.shape[1]
    for i in range(order):
        state[i] += plant[order, i] * impulse
    return direction if direction == 2 else int(np.sign(_dot(plant, 2, state)))


@njit(error_model="numpy")
def _rate(
    time: float,
    state: Array,
    driven: float,
    disturbance: float,
    plant: Array,
    through: float,
    force: Array,
    friction: Array,
    slopes: Array,
) -> float:
    """Return the velocity (y/s); that of a storage depends on what flows in now."""
    if through == 0.0:
        return _dot(plant, 2, state)
    differentiate(time, state, driven, disturbance, 2, plant, force, friction, slopes, 0)
    rate = _dot(plant, 1, slopes[0])
    full = force[Force.CEILING_ON] > 0.0 and _dot(plant, 1, state) >= force[Force.CEILING] * (1.0 - 1e-12)
    return min(rate, 0.0) if full else rate


@njit(error_model="numpy")
def _control(command: float, reference: float, controller: Array, state: Array, plant: Array) -> float:
    """Return the command (u), in a closed loop that of the controller."""
    if controller.shape[0] == 0:
        return command
    error = controller[0] * (reference - _dot(plant, 1, state)) - _dot(plant, 2, state)
    return float(max(-controller[2], min(controller[1] * error, controller[2])))


@njit(error_model="numpy")
def _spill(state: Array, plant: Array, force: Array) -> None:
    """Let a storage overflow that is more than full."""
    if force[Force.CEILING_ON] > 0.0 and _dot(plant, 1, state) > force[Force.CEILING]:
        state[0] = force[Force.CEILING] / plant[2, 0]


@njit(error_model="numpy")
def integrate(
    start: float,
    period: float,
    substeps: int,
    command: Array,
    lead: int,
    straight: bool,
    reference: Array,
    controller: Array,
    disturbance: Array,
    impulses: Array,
    initial: Array,
    plant: Array,
    through: float,
    actuator: Array,
    force: Array,
    friction: Array,
) -> tuple[Array, Array]:
    """Return the motion, shape (4, samples * substeps), and the command, a value a sample.

    The motion is position and velocity at the start, and position and velocity at the end of each substep. ``start``
    (s) is the time of the first sample; ``command`` (u) is held, or joined by straight lines from the sample ``lead``
    on, before which the actuator is off; with a controller (position gain, velocity gain, limit; empty without one)
    the command is computed from ``reference`` (y). ``plant`` has the rows of A, then B, C and C A. ``disturbance`` (u)
    has three values a substep; ``impulses`` (u s) act at the start of their substep. ``through`` is the part of the
    force that shows in the velocity at once (y/s/u), for storages.
    """
    samples = command.shape[0]
    step = period / substeps
    order = initial.shape[0]
    state = np.zeros(order + MEMORIES)
    state[:order] = initial
    result = np.zeros(order + MEMORIES)
    slopes = np.zeros((4, order + MEMORIES))
    cuts = np.zeros((2, 3))
    memory = np.zeros(STATES)
    driven = np.zeros((substeps, 3))
    motion = np.empty((4, samples * substeps))
    given = command.copy()
    levels = friction[Friction.FORWARD] + friction[Friction.BACKWARD] + friction[Friction.BREAKAWAY_EXCESS]
    dry = levels > 0.0 or friction[Friction.LOAD] > 0.0
    direction = int(np.sign(_dot(plant, 2, state))) if dry else 2
    for k in range(samples):
        aim = reference[k] if reference.shape[0] > 0 else 0.0
        given[k] = _control(given[k], aim, controller, state, plant)
        if k >= lead:
            following = given[k + 1] if straight and k < samples - 1 else given[k]
            act(given[k], following, actuator, memory, step, driven)
        for j in range(substeps):
            index = k * substeps + j
            now = start + k * period + j * step
            if impulses[index] != 0.0:
                direction = _kick(state, impulses[index], direction, plant)
            motion[0, index] = _dot(plant, 1, state)
            motion[1, index] = _rate(
                now, state, driven[j, 0], disturbance[index, 0], plant, through, force, friction, slopes
            )
            if dry:
                direction = _with_friction(
                    now,
                    state,
                    step,
                    driven,
                    j,
                    disturbance,
                    index,
                    direction,
                    plant,
                    force,
                    friction,
                    slopes,
                    cuts,
                    result,
                )
            else:
                _advance(now, state, step, driven, j, disturbance, index, 2, plant, force, friction, slopes, result)
                state[:] = result
            _spill(state, plant, force)
            motion[2, index] = _dot(plant, 1, state)
            motion[3, index] = _rate(
                now + step, state, driven[j, 2], disturbance[index, 2], plant, through, force, friction, slopes
            )
        if not math.isfinite(motion[2, (k + 1) * substeps - 1]):
            motion[:, k * substeps :] = np.nan
            break
    return motion, given
