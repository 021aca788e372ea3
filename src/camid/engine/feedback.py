"""A controller in the loop, as compiled code takes it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.compiled import kernel
from camid.engine.forces import Forces, call

Array = NDArray[np.float64]


class Feedback(NamedTuple):
    """A controller u_k = clip(k_v (k_p (r_k − y) − ẏ)) that acts on the plant's input and is held for a period.

    ``steps`` is the number of integration steps per period, 0 without a controller; ``control``, shape (N,), is filled
    with what the controller did.
    """

    steps: int
    reference: Array
    position_gain: float
    velocity_gain: float
    limit: float
    control: Array


@kernel(inline="always")
def samples_at(feedback: Feedback, node: int) -> bool:
    """Whether the controller takes a sample at a node of the grid."""
    return feedback.steps > 0 and node % feedback.steps == 0 and node // feedback.steps < len(feedback.reference)


@kernel(inline="always")
def controlled(feedback: Feedback, node: int, position: float, speed: float) -> float:
    """What the controller puts out at a node at which it takes a sample, and keeps."""
    sample = node // feedback.steps
    wanted = feedback.velocity_gain * (feedback.position_gain * (feedback.reference[sample] - position) - speed)
    held = min(max(wanted, -feedback.limit), feedback.limit)
    feedback.control[sample] = held
    return held


@kernel(error_model="numpy", inline="always")
def actuated(forces: Forces, step: float, command: float, memory: Array) -> tuple[float, float]:
    """What the actuators make of a command over a step, in seconds: at its start and at its end."""
    functions = forces.functions
    before = after = command
    for i in range(functions.shape[1]):
        if functions[4, i] != 0:
            before = memory[i]
            after = call(functions[4, i], step, 0.0, 0.0, after, before, forces.data + i * forces.stride)
            memory[i] = after
    return (before if forces.ramps else after), after
