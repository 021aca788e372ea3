"""What a simulated motion is answered by, as compiled code takes it: a controller, or an observer's pull."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.compiled import kernel
from camid.engine.forces import Forces, call

Array = NDArray[np.float64]


class Feedback(NamedTuple):
    """What acts on the plant's input and is held for a period.

    A controller takes position and velocity at the sample: u_k = clip(k_v (k_p (r_k − y) − ẏ)). An observer compares
    frames: u_k = k_p e_k + k_v (e_k − e_(k-1)) / T with e_k = r_k − ŵ_k, for those ŵ_k that the sensor reads of the
    motion. ``steps`` is the number of integration steps per period, 0 without either; ``control``, shape (N,), is
    filled with what a controller did, or with the errors that an observer saw. ``exposure``, negative for a controller,
    and ``latency`` of the frames are in seconds.
    """

    steps: int
    reference: Array
    position_gain: float
    velocity_gain: float
    limit: float
    control: Array
    exposure: float
    latency: float


@kernel(inline="always")
def samples_at(feedback: Feedback, node: int) -> bool:
    """Whether the controller takes a sample at a node of the grid."""
    return feedback.steps > 0 and node % feedback.steps == 0 and node // feedback.steps < len(feedback.reference)


@kernel(inline="always")
def _controlled(feedback: Feedback, node: int, position: float, speed: float) -> float:
    """What the controller puts out at a node at which it takes a sample, and keeps."""
    sample = node // feedback.steps
    wanted = feedback.velocity_gain * (feedback.position_gain * (feedback.reference[sample] - position) - speed)
    held = min(max(wanted, -feedback.limit), feedback.limit)
    feedback.control[sample] = held
    return held


@kernel(error_model="numpy", inline="always")
def _between(values: Array, slopes: Array, at: float, step: float) -> float:
    """Cubic through two nodes and the slopes there, at a place between them counted in steps."""
    node = max(int(np.ceil(at)) - 1, 0)
    share = at - node
    rest = 1.0 - share
    bent = share * rest * step * (rest * slopes[node] - share * slopes[node + 1])
    weight = share * share * (3.0 - 2.0 * share)
    return float(values[node] + weight * (values[node + 1] - values[node]) + bent)


@kernel(error_model="numpy")
def _pulled(feedback: Feedback, node: int, step: float, measured: Array, rate: Array, integral: Array) -> float:
    """What an observer pulls with at a node at which it takes a sample, and keeps; nothing where no frame is compared.

    The motion, its rate and its integral are those at the nodes so far.
    """
    sample = node // feedback.steps
    end = node - feedback.latency / step
    first = end - feedback.exposure / step
    if node == 0 or first < 0.0:
        feedback.control[sample] = np.nan
        return 0.0
    if feedback.exposure > 0.0:
        shown = _between(integral, measured, end, step) - _between(integral, measured, first, step)
        shown /= feedback.exposure
    else:
        shown = _between(measured, rate, end, step)
    error = feedback.reference[sample] - shown
    before = feedback.control[sample - 1]
    if np.isnan(error):  # the next change is that since the last frame, or the motion would keep the noise of that one
        feedback.control[sample] = before
        return 0.0
    feedback.control[sample] = error
    change = 0.0 if np.isnan(before) else (error - before) / (feedback.steps * step)
    return feedback.position_gain * error + feedback.velocity_gain * change


@kernel(error_model="numpy", inline="always")
def _actuated(forces: Forces, step: float, command: float, memory: Array) -> tuple[float, float]:
    """What the actuators make of a command over a step, in seconds: at its start and at its end."""
    functions = forces.functions
    before = after = command
    for i in range(functions.shape[1]):
        if functions[4, i] != 0:
            before = memory[i]
            after = call(functions[4, i], step, 0.0, 0.0, after, before, forces.data + i * forces.stride)
            memory[i] = after
    return (before if forces.ramps else after), after


@kernel(error_model="numpy", inline="always")
def answered(
    feedback: Feedback, node: int, step: float, speed: float, measured: Array, rate: Array, integral: Array
) -> float:
    """What a controller or an observer makes of the motion at a node at which it takes a sample, and keeps."""
    if feedback.exposure < 0.0:
        return float(_controlled(feedback, node, measured[node], speed))
    return float(_pulled(feedback, node, step, measured, rate, integral))


@kernel(error_model="numpy", inline="always")
def passed_on(feedback: Feedback, forces: Forces, step: float, held: float, memory: Array) -> tuple[float, float]:
    """What arrives at the plant of it at the start and at the end of a step: an observer acts behind the actuators."""
    if feedback.steps == 0:
        return 0.0, 0.0
    if feedback.exposure < 0.0:
        return _actuated(forces, step, held, memory)
    return held, held
