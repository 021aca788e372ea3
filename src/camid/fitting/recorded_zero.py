"""The sensor's zero, from the first recorded positions, where the plant is said to begin at its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camid.fitting.initial_motion import first_motion
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.constants import OFFSET
from camid.fitting.problem import Problem


def recorded_zero(problem: Problem, model: Model) -> Model:
    """The model with the sensor's zero that the first recorded positions show, where the plant is said to begin there.

    An offset that was estimated without a force which bends the motion much is one of the whole record, and a plant
    that begins there with it is not where the rig was.
    """
    constants = {constant.name for constant in problem.kind.free_constants()}
    if OFFSET.name not in constants or any(e.estimate_initial_state for e in problem.experiments):
        return model
    positions = problem.kind.recorded_positions(problem)
    first = [first_motion(problem, i, problem.kind.at_plant(p, model))[0] for i, p in enumerate(positions)]
    return replace(
        model, constants={**model.constants, OFFSET.name: model.constants[OFFSET.name] + float(np.mean(first))}
    )
