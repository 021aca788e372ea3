"""The equations of motion of the machine with everything that may be hidden in it (compiled).

Sources: Canudas de Wit et al. (1995), IEEE Transactions on Automatic Control 40(3) (LuGre); Dahl (1976), AIAA Journal
14(12); Wen (1976), Journal of the Engineering Mechanics Division 102(2) (hysteresis); Iwan (1966), Journal of Applied
Mechanics 33(4) (Jenkins elements); Johnson (1985), Contact Mechanics, ch. 4 (Hertz). Those of what no catalogue has
stand in :mod:`camid.proof.concealed.outside_laws` and :mod:`camid.proof.concealed.changing_laws`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.compiled import kernel
from camid.proof.concealed import vector_layout as s

Array = NDArray[np.float64]


@kernel
def drift(p: Array, kind: int, t: float) -> float:
    """Factor of stiffness (1), damping (2) or actuator constant (3) at time t in s; nothing drifts before t = 0."""
    if p[s.DRIFT_KIND] != kind or t <= 0.0:
        return 1.0
    tau = p[s.DRIFT_TIME]
    return 1.0 + p[s.DRIFT_RATE] * (t if tau == 0.0 else tau * (1.0 - np.exp(-t / tau)))


@kernel
def contact(p: Array, x: float, v: float) -> float:
    """Positive while the stop pushes: depth in m, or force in N where its damper would have to pull."""
    side = p[s.STOP_SIDE]
    depth = side * x - p[s.STOP_POSITION]
    if p[s.STOP_DAMPING] == 0.0 or depth <= 0.0:
        return depth
    push = depth + p[s.STOP_DAMPING] / p[s.STOP_STIFFNESS] * side * v
    return min(depth, push)


@kernel
def disturbance(p: Array, t: float, within: float) -> float:
    """Disturbing force in V at the actuator at a time of the step around another; steps end where a force begins."""
    force = 0.0
    if p[s.SINE] != 0.0 and within > 0.0:
        force += p[s.SINE] * np.sin(p[s.SINE_FREQUENCY] * t + p[s.SINE_PHASE])
        force += p[s.HARMONIC] * np.sin(2.0 * p[s.SINE_FREQUENCY] * t + p[s.HARMONIC_PHASE])
    if p[s.STEP] != 0.0 and within > p[s.STEP_TIME]:
        force += p[s.STEP]
    if p[s.PULSE] != 0.0 and 0.0 < within - p[s.PULSE_TIME] < p[s.PULSE_DURATION]:
        force += p[s.PULSE] * np.sin(np.pi * (t - p[s.PULSE_TIME]) / p[s.PULSE_DURATION])
    return force


@kernel
def jenkins(p: Array, x: float, memory: Array, element: int) -> float:
    """Force in N of one spring-slider element, from its force at the last committed position in ``memory``."""
    limit = p[s.JENKINS_FORCE] * (element + 1.0) / s.JENKINS_ELEMENTS
    force = memory[element] + p[s.JENKINS_STIFFNESS] / s.JENKINS_ELEMENTS * (x - memory[s.LAST_POSITION])
    return min(max(force, -limit), limit)


@kernel
def bristle_rate(p: Array, z: float, v: float) -> float:
    """Rate of the bristle deflection in m/s."""
    level = p[s.BRISTLE_COULOMB]
    if p[s.BRISTLE_VELOCITY] != 0.0:
        level += (p[s.BRISTLE_BREAKAWAY] - level) * np.exp(-((v / p[s.BRISTLE_VELOCITY]) ** 2))
    return v - p[s.BRISTLE_STIFFNESS] * abs(v) / level * z


@kernel
def spring_force(p: Array, x: float, t: float) -> float:
    """Restoring force in N of the mount and of what is fixed beside it."""
    stiffness = p[s.STIFFNESS] * drift(p, 1, t)
    if p[s.STIFFNESS_SWING] != 0.0:
        stiffness *= 1.0 + p[s.STIFFNESS_SWING] * np.sin(
            p[s.STIFFNESS_SWING_FREQUENCY] * t + p[s.STIFFNESS_SWING_PHASE]
        )
    stretch = x
    if p[s.GAP] != 0.0:
        stretch = x - min(max(x, -p[s.GAP]), p[s.GAP])
    if p[s.PENDULUM] != 0.0:
        stretch = p[s.PENDULUM] * np.sin(x / p[s.PENDULUM])
    force = stiffness * stretch + x * x * (p[s.QUADRATIC] + x * (p[s.CUBIC] + x * x * p[s.QUINTIC]))
    if p[s.SIDE_STIFFNESS] != 0.0:
        length = p[s.SIDE_LENGTH]
        force += 2.0 * p[s.SIDE_STIFFNESS] * x * (1.0 - length / np.sqrt(x * x + length * length))
    if p[s.DETENT] != 0.0:
        angle = 2.0 * np.pi * x / p[s.DETENT_PITCH]
        first, second = p[s.DETENT_PHASE], p[s.DETENT_HARMONIC_PHASE]
        # The machine rests at zero, wherever between two poles that is.
        force += p[s.DETENT] * (np.sin(angle + first) - np.sin(first))
        force += p[s.DETENT] * p[s.DETENT_HARMONIC] * (np.sin(2.0 * angle + second) - np.sin(second))
    if p[s.OUTFLOW] != 0.0:
        force += p[s.OUTFLOW] * np.sign(x) * abs(x) ** p[s.OUTFLOW_EXPONENT]
    if p[s.EDGE_WEIR] != 0.0:
        depth = max(p[s.EDGE_SIDE] * x - p[s.EDGE_HEIGHT], 0.0)
        force += p[s.EDGE_SIDE] * p[s.EDGE_WEIR] * depth**1.5
    return force


@kernel
def motor_force(p: Array, x: float, v: float, command: float, t: float) -> float:
    """Force in N of the actuator for what reaches it, in V."""
    force = p[s.ACTUATOR_CONSTANT] * command * drift(p, 3, t)
    if p[s.POSITION_GAIN] != 0.0:
        force *= 1.0 + p[s.POSITION_GAIN] * x
    if p[s.SPEED_LIMIT] != 0.0:
        force /= 1.0 + abs(v) / p[s.SPEED_LIMIT]
    if p[s.RIPPLE] != 0.0:
        force *= 1.0 + p[s.RIPPLE] * np.sin(2.0 * np.pi * x / p[s.RIPPLE_PITCH] + p[s.RIPPLE_PHASE])
    if p[s.HORIZONTAL_FORCE] != 0.0:
        force *= np.cos(x / p[s.PENDULUM])
    if p[s.RELUCTANCE] != 0.0:
        force -= p[s.RELUCTANCE] * command * command * x
    return force


@kernel
def reaching(p: Array, state: Array, command: float) -> float:
    """Command in V behind the actuator's lags, less what a warm winding takes away."""
    if p[s.WINDING_HEATING] != 0.0:
        return command / (1.0 + state[s.WARMTH])
    if p[s.LAG] != 0.0 or p[s.SOFT_SLEW] != 0.0:
        return state[s.SECOND_ACTUATOR] if p[s.SECOND_LAG] != 0.0 else state[s.ACTUATOR]
    return command


@kernel
def net_force(p: Array, state: Array, memory: Array, command: float, t: float, damped: bool) -> float:
    """All forces on the mass in N but dry friction; without the viscous damper where ``damped`` is false."""
    x, v = state[s.POSITION], state[s.VELOCITY]
    force = motor_force(p, x, v, reaching(p, state, command), t) - spring_force(p, x, t)
    force += p[s.ACTUATOR_CONSTANT] * disturbance(p, t, memory[s.WITHIN])
    if damped:
        force -= p[s.DAMPING] * drift(p, 2, t) * v
    if p[s.DRAG] != 0.0:
        force -= p[s.DRAG] * abs(v) ** (p[s.DRAG_EXPONENT] - 1.0) * v
    if p[s.POSITION_DAMPING] != 0.0:
        force -= p[s.POSITION_DAMPING] * x * x * v
    if p[s.DISTANCE_DAMPING] != 0.0:
        force -= p[s.DISTANCE_DAMPING] * abs(x) * v
    if memory[s.TOUCHING] != 0.0:
        depth = max(p[s.STOP_SIDE] * x - p[s.STOP_POSITION], 0.0)
        push = p[s.STOP_STIFFNESS] * depth ** p[s.STOP_EXPONENT] + p[s.STOP_DAMPING] * p[s.STOP_SIDE] * v
        force -= p[s.STOP_SIDE] * push
    if p[s.BRISTLE_STIFFNESS] != 0.0:
        force -= p[s.BRISTLE_STIFFNESS] * state[s.BRISTLE]
        force -= p[s.BRISTLE_DAMPING] * bristle_rate(p, state[s.BRISTLE], v)
    if p[s.LOOP_FORCE] != 0.0:
        force -= p[s.LOOP_FORCE] * state[s.LOOP]
    if p[s.JENKINS_STIFFNESS] != 0.0:
        for element in range(s.JENKINS_ELEMENTS):
            force -= jenkins(p, x, memory, element)
    if p[s.HIDDEN_MASS] != 0.0:
        force -= hidden_pull(p, state)
    if p[s.MAXWELL_STIFFNESS] != 0.0:
        force -= state[s.MAXWELL] + state[s.MAXWELL + 1] + state[s.MAXWELL + 2]
    if p[s.WAVE] != 0.0 and memory[s.WITHIN] > 0.0:
        force += p[s.WAVE] * np.sin(p[s.WAVE_FREQUENCY] * t - 2.0 * np.pi * x / p[s.WAVE_LENGTH])
    return force


@kernel
def hidden_pull(p: Array, state: Array) -> float:
    """Force in N with which the hidden mass holds the mass back."""
    stretch = state[s.POSITION] - state[s.HIDDEN]
    force = p[s.HIDDEN_STIFFNESS] * stretch + p[s.HIDDEN_CUBIC] * stretch**3
    return force + p[s.HIDDEN_DAMPING] * (state[s.VELOCITY] - state[s.HIDDEN_RATE])


@kernel
def _swing_beside(p: Array, state: Array, force: float, rate: Array) -> None:
    """Rates of the mode beside the machine under the actuator's force in N."""
    omega = p[s.BESIDE_FREQUENCY]
    rate[s.BESIDE] = state[s.BESIDE_RATE]
    pull = omega * (p[s.BESIDE_COMPLIANCE] * force - state[s.BESIDE])
    rate[s.BESIDE_RATE] = omega * (pull - 2.0 * p[s.BESIDE_DAMPING] * state[s.BESIDE_RATE])


@kernel
def _follow_command(p: Array, state: Array, command: float, rate: Array) -> None:
    """Rates of the actuator's lags, or of its soft slew, under a command in V."""
    if p[s.LAG] != 0.0:
        rate[s.ACTUATOR] = (command - state[s.ACTUATOR]) / p[s.LAG]
        if p[s.SECOND_LAG] != 0.0:
            rate[s.SECOND_ACTUATOR] = (state[s.ACTUATOR] - state[s.SECOND_ACTUATOR]) / p[s.SECOND_LAG]
    if p[s.SOFT_SLEW] != 0.0:
        gap = (command - state[s.ACTUATOR]) / (p[s.SOFT_SLEW] * p[s.SOFT_SLEW_TIME])
        rate[s.ACTUATOR] = p[s.SOFT_SLEW] * np.tanh(gap)


@kernel
def _follow_current(p: Array, state: Array, command: float, rate: Array) -> None:
    """Rates of what remembers the currents that commands in V have drawn: a winding's warmth, a supply's sag."""
    if p[s.WINDING_HEATING] != 0.0:
        heat = p[s.WINDING_HEATING] * command * command / (1.0 + state[s.WARMTH])
        rate[s.WARMTH] = (heat - state[s.WARMTH]) / p[s.WINDING_TIME]
    if p[s.SUPPLY_SAG] != 0.0:
        rate[s.DRAWN] = (abs(command) - state[s.DRAWN]) / p[s.SUPPLY_TIME]


@kernel
def scale_of_reading(p: Array, state: Array) -> float:
    """Factor of a reading that is given in shares of a supply, which sags."""
    return 1.0 - p[s.SUPPLY_SAG] * state[s.DRAWN]


@kernel
def derivative(  # noqa: PLR0912, PLR0915 - a branch for every part that a machine can have
    p: Array, state: Array, memory: Array, command: float, t: float, direction: int, rate: Array
) -> None:
    """Time derivative of the state; ``direction`` is that of sliding, or 0 where the mass sticks."""
    v = state[s.VELOCITY]
    dry = p[s.DRY_BREAKAWAY] != 0.0
    if p[s.MASS] == 0.0:
        v = net_force(p, state, memory, command, t, False) / (p[s.DAMPING] * drift(p, 2, t))
        if p[s.EDGE_SIDE] * state[s.POSITION] >= p[s.EDGE_HEIGHT] > 0.0 == p[s.EDGE_WEIR]:
            v = p[s.EDGE_SIDE] * min(p[s.EDGE_SIDE] * v, 0.0)
        rate[s.POSITION], rate[s.VELOCITY] = v, 0.0
    elif dry and direction == 0:
        v = 0.0
        rate[s.POSITION], rate[s.VELOCITY] = 0.0, 0.0
    else:
        force = net_force(p, state, memory, command, t, True)
        if dry:
            load = motor_force(p, state[s.POSITION], v, reaching(p, state, command), t)
            force -= direction * dry_level(p, state[s.POSITION], v, load, direction)
        rate[s.POSITION], rate[s.VELOCITY] = v, force / p[s.MASS]
    measured = state[s.HIDDEN] if p[s.HIDDEN_IS_SEEN] != 0.0 else state[s.POSITION]
    if p[s.BESIDE_FREQUENCY] != 0.0:
        _swing_beside(p, state, motor_force(p, state[s.POSITION], v, reaching(p, state, command), t), rate)
        measured += state[s.BESIDE]
    if p[s.SERIES_LAG] != 0.0:
        rate[s.SERIES] = (measured - state[s.SERIES]) / p[s.SERIES_LAG]
        measured = state[s.SERIES]
    if p[s.SERIES_FREQUENCY] != 0.0:
        omega = p[s.SERIES_FREQUENCY]
        rate[s.SERIES] = state[s.SERIES_RATE]
        pull = omega * (measured - state[s.SERIES]) - 2.0 * p[s.SERIES_DAMPING] * state[s.SERIES_RATE]
        rate[s.SERIES_RATE] = omega * pull
        measured = state[s.SERIES]
    if p[s.SECOND_SERIES_FREQUENCY] != 0.0:
        omega = p[s.SECOND_SERIES_FREQUENCY]
        rate[s.SECOND_SERIES] = state[s.SECOND_SERIES_RATE]
        pull = omega * (measured - state[s.SECOND_SERIES])
        pull -= 2.0 * p[s.SECOND_SERIES_DAMPING] * state[s.SECOND_SERIES_RATE]
        rate[s.SECOND_SERIES_RATE] = omega * pull
        measured = state[s.SECOND_SERIES]
    if p[s.SUPPLY_SAG] != 0.0:
        measured *= scale_of_reading(p, state)
    rate[s.INTEGRAL] = measured
    if p[s.HIDDEN_MASS] != 0.0:
        rate[s.HIDDEN] = state[s.HIDDEN_RATE]
        rate[s.HIDDEN_RATE] = hidden_pull(p, state) / p[s.HIDDEN_MASS]
    if p[s.BRISTLE_STIFFNESS] != 0.0:
        rate[s.BRISTLE] = bristle_rate(p, state[s.BRISTLE], v)
    if p[s.LOOP_FORCE] != 0.0:
        z = state[s.LOOP]
        power = abs(z) ** p[s.LOOP_EXPONENT]
        rate[s.LOOP] = p[s.LOOP_SHAPE] * (v - 0.5 * abs(v) * power * np.sign(z) - 0.5 * v * power)
    if p[s.MAXWELL_STIFFNESS] != 0.0:
        time = p[s.MAXWELL_TIME]
        for i in range(3):
            rate[s.MAXWELL + i] = p[s.MAXWELL_STIFFNESS] / 3.0 * v - state[s.MAXWELL + i] / time
            time *= p[s.MAXWELL_RATIO]
    _follow_command(p, state, command, rate)
    _follow_current(p, state, command, rate)


@kernel
def dry_level(p: Array, x: float, v: float, load: float, direction: int) -> float:
    """Dry friction level in N at a position in m and a speed in m/s, under a driving force in N.

    ``direction`` is that of sliding, or of the force on a mass at rest.
    """
    level = p[s.DRY_COULOMB]
    if p[s.DRY_VELOCITY] != 0.0:
        level += (p[s.DRY_BREAKAWAY] - level) * np.exp(-((v / p[s.DRY_VELOCITY]) ** 2))
    level *= 1.0 + p[s.DRY_DIRECTION] * direction
    if p[s.DRY_SLOPE] != 0.0:
        width = p[s.DRY_WIDTH]
        level *= max(1.0 + p[s.DRY_SLOPE] * (x if width == 0.0 else width * np.tanh(x / width)), 0.0)
    return level + p[s.DRY_LOAD] * abs(load)


@kernel
def resting_level(p: Array, state: Array, command: float, t: float, force: float) -> float:
    """Dry friction level in N that holds a mass at rest against a force in N."""
    x = state[s.POSITION]
    load = motor_force(p, x, 0.0, reaching(p, state, command), t)
    return dry_level(p, x, 0.0, load, 1 if force > 0.0 else -1)
