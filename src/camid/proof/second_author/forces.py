"""Forces at the plant's input that depend on the motion, and the derivative of the whole state, compiled by numba."""

import math

from camid.compiled import njit

from .actuator import Array
from .quantities import Force, Friction

MEMORIES = 3  # hysteresis or bristles, heat, relaxing spring


@njit(error_model="numpy")
def friction_level(direction: int, position: float, velocity: float, load: float, friction: Array) -> float:
    """Return the size of dry friction (u) in a direction, +1 to larger y; the load (u) is the transmitted force."""
    level = friction[Friction.FORWARD] if direction > 0 else friction[Friction.BACKWARD]
    if friction[Friction.BREAKAWAY_EXCESS] != 0.0:
        squared = (velocity / friction[Friction.VELOCITY]) ** 2
        share = 1.0 / (1.0 + squared) if friction[Friction.LORENTZIAN] > 0.0 else math.exp(-squared)
        level += friction[Friction.BREAKAWAY_EXCESS] * share
    level = max(level + friction[Friction.GRADIENT] * position, 0.0)
    return float(level + friction[Friction.LOAD] * abs(load))


@njit(error_model="numpy")
def _springs(position: float, force: Array) -> float:
    """Return the forces (u) that depend on the position alone."""
    total = position * position * (force[Force.QUADRATIC] + position * force[Force.CUBIC])
    total += force[Force.QUINTIC] * position**5
    if force[Force.COGGING] != 0.0:
        phase = force[Force.COGGING_PHASE]
        angle = 2.0 * math.pi * position / force[Force.COGGING_PERIOD]
        wave = math.sin(angle + phase) - math.sin(phase)
        wave += force[Force.COGGING_SECOND] * (math.sin(2.0 * (angle + phase)) - math.sin(2.0 * phase))
        total += force[Force.COGGING] * wave
    if force[Force.STOP_STIFFNESS] > 0.0:
        stop = force[Force.STOP_POSITION]
        depth = position - stop if stop > 0.0 else stop - position
        if depth > 0.0:
            total += math.copysign(force[Force.STOP_STIFFNESS] * depth ** force[Force.STOP_EXPONENT], stop)
    if force[Force.SINE_AMPLITUDE] > 0.0:
        amplitude = force[Force.SINE_AMPLITUDE]
        total += force[Force.SINE_STIFFNESS] * (amplitude * math.sin(position / amplitude) - position)
    if force[Force.OUTFLOW] != 0.0:
        total += math.copysign(force[Force.OUTFLOW] * abs(position) ** force[Force.OUTFLOW_EXPONENT], position)
    width = force[Force.GAP_WIDTH]
    return float(total - force[Force.GAP_STIFFNESS] * max(-width, min(position, width)))


@njit(error_model="numpy")
def _dampers(position: float, velocity: float, force: Array) -> float:
    """Return the forces (u) that depend on the velocity, and on the position."""
    total = force[Force.AMPLITUDE_DAMPING] * position * position * velocity
    if force[Force.DRAG] != 0.0:
        total += math.copysign(force[Force.DRAG] * abs(velocity) ** force[Force.DRAG_EXPONENT], velocity)
    total += force[Force.ONE_SIDED_DAMPING] * max(velocity, 0.0)
    total += force[Force.CENTRIFUGAL] * position * velocity * velocity
    if force[Force.EDDY] != 0.0:
        total += force[Force.EDDY] * velocity / (1.0 + (velocity / force[Force.EDDY_VELOCITY]) ** 2)
    return float(total)


@njit(error_model="numpy")
def _remembered(
    position: float, velocity: float, driven: float, state: Array, first: int, force: Array, slopes: Array, row: int
) -> float:
    """Return the forces (u) with a memory, and write their derivatives, which start at ``first``."""
    total = 0.0
    slopes[row, first] = slopes[row, first + 1] = slopes[row, first + 2] = 0.0
    if force[Force.HYSTERESIS] != 0.0:
        # Bouc and Wen with an exponent: one is the catalogue's law
        z = state[first]
        power = abs(z) ** force[Force.SHAPE_EXPONENT]
        turning = 0.5 * (math.copysign(1.0, velocity * z) + 1.0) * power
        slopes[row, first] = force[Force.SHAPE] * velocity * (1.0 - turning)
        total += force[Force.HYSTERESIS] * z
    if force[Force.LUGRE_STIFFNESS] > 0.0:
        stiffness = force[Force.LUGRE_STIFFNESS]
        slopes[row, first] = velocity - stiffness * abs(velocity) / force[Force.LUGRE_FORCE] * state[first]
        total += stiffness * state[first] + force[Force.LUGRE_DAMPING] * slopes[row, first]
    if force[Force.HEAT] != 0.0:
        slopes[row, first + 1] = (driven * driven - state[first + 1]) / force[Force.HEAT_TIME]
        total += min(force[Force.HEAT] * state[first + 1], 0.9) * driven
    if force[Force.RELAXING_STIFFNESS] != 0.0:
        stretch = position - state[first + 2]
        slopes[row, first + 2] = stretch / force[Force.RELAXING_TIME]
        total += force[Force.RELAXING_STIFFNESS] * stretch
    return total


@njit(error_model="numpy")
def _over_time(time: float, position: float, velocity: float, driven: float, force: Array) -> float:
    """Return the forces (u) that depend on the time (s)."""
    memory = force[Force.DRIFT_MEMORY]
    elapsed = time if memory <= 0.0 else memory * (1.0 - math.exp(-time / memory))
    total = elapsed * (force[Force.STIFFNESS_DRIFT] * position + force[Force.DAMPING_DRIFT] * velocity)
    total -= elapsed * force[Force.GAIN_DRIFT] * driven
    total += force[Force.FADING_GAIN] * position * position * driven
    return float(total + force[Force.PUMP] * math.sin(force[Force.PUMP_FREQUENCY] * time) * position)


@njit(error_model="numpy")
def differentiate(
    time: float,
    state: Array,
    driven: float,
    disturbance: float,
    direction: int,
    plant: Array,
    force: Array,
    friction: Array,
    slopes: Array,
    row: int,
) -> float:
    """Write the derivative of the state into a row, and return the friction (u) that would hold a body at rest.

    ``direction`` is that of the motion, 0 for a body that sticks, 2 where there is no dry friction. ``driven`` (u) is
    the force of the actuator and ``disturbance`` (u) what is added to it. ``plant`` has the rows of A, then B, C
    and C A.
    """
    order = plant.shape[1]
    position = 0.0
    velocity = 0.0
    for i in range(order):
        position += plant[order + 1, i] * state[i]
        velocity += plant[order + 2, i] * state[i]
    total = _springs(position, force) + _dampers(position, velocity, force)
    total += _remembered(position, velocity, driven, state, order, force, slopes, row)
    total += _over_time(time, position, velocity, driven, force)
    if direction == 1 or direction == -1:  # noqa: PLR1714 (a set is slow here)
        total += direction * friction_level(direction, position, velocity, driven, friction)
    acting = driven + disturbance - total
    for i in range(order):
        slope = plant[order, i] * acting
        for j in range(order):
            slope += plant[i, j] * state[j]
        slopes[row, i] = slope
    if force[Force.PENDULUM] > 0.0:
        slopes[row, 1] -= force[Force.PENDULUM] * math.sin(state[0])
    if direction != 0:
        return 0.0
    acceleration = 0.0
    mobility = 0.0
    for i in range(order):
        acceleration += plant[order + 2, i] * slopes[row, i]
        mobility += plant[order + 2, i] * plant[order, i]
    holding = acceleration / mobility
    for i in range(order):
        slopes[row, i] -= plant[order, i] * holding
    return holding
