"""Latencies from the best of which one that is unknown is fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.constants import LATENCY
from camid.fitting.problem import Problem

# In periods.
LATENCIES = np.arange(0.0, 3.01, 0.25)


def with_latencies(problem: Problem, model: Model) -> list[Model]:
    """The model with latencies of a grid, where that is free and nothing is known of it yet."""
    if model.constants.get(LATENCY.name) != 0.0:
        return [model]
    latencies = problem.acquisition.period * LATENCIES
    return [replace(model, constants={**model.constants, LATENCY.name: float(one)}, initial=()) for one in latencies]
