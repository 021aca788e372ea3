"""The motion at the first sample, from the first recorded positions: where the recording says it, no fit has to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.exact import time_scale
from camid.fitting.problem import Model, Problem

Array = NDArray[np.float64]
# Motion at the first sample: a cubic through so much of the recording, in time constants of the plant, and its rows.
SMOOTHED = 0.5
FEWEST_SMOOTHED, MOST_SMOOTHED = 6, 60


def recorded_start(problem: Problem, model: Model) -> Model:
    """The model with initial states that the first recorded positions show."""
    initial: list[Array | None] = []
    for index, experiment in enumerate(problem.experiments):
        if not experiment.estimate_initial_state:
            initial.append(None)
            continue
        recorded = problem.positions[index] if problem.closed else experiment.output
        position, velocity = _first_motion(problem, index, problem.restored(recorded, model))
        initial.append(_companion_state(problem, model, position, velocity))
    return replace(model, initial=tuple(initial))


def _first_motion(problem: Problem, index: int, recorded: Array) -> tuple[float, float]:
    """Position and velocity (per second) where the simulation begins, from a cubic through the first recorded rows."""
    experiment = problem.experiments[index]
    acquisition = experiment.acquisition
    denominator = np.concatenate([[1.0], problem.structure.denominator[1:]])
    constant = time_scale(tuple(denominator))
    rows = int(np.clip(SMOOTHED * constant / acquisition.period, FEWEST_SMOOTHED, MOST_SMOOTHED))
    used = np.flatnonzero(experiment.used)[:rows]
    delay = acquisition.window()[0] if experiment.free_motion_before_record and not problem.closed else 0
    exposure = 0.0 if acquisition.sensor == "instant" else float(acquisition.exposure or 0.0)
    # A mean over an exposure is the position in its middle, up to the second order.
    seen = (used + delay) * acquisition.period - acquisition.latency - 0.5 * exposure
    polynomial = np.polynomial.Polynomial.fit(seen, recorded[used], min(3, len(used) - 1))
    return float(polynomial(0.0)), float(polynomial.deriv()(0.0))


def _companion_state(problem: Problem, model: Model, position: float, velocity: float) -> Array:
    """The smallest companion state with this position and velocity."""
    from camid.engine.run import companion_block

    plant = problem.structure.plant(model.coefficients)
    unit = time_scale(plant.monic.denominator)
    matrix, row, _ = companion_block(plant, unit)
    table = np.vstack([row, row @ matrix / unit])
    wanted = np.array([position, velocity])
    return np.asarray(np.linalg.lstsq(table, wanted, rcond=None)[0], dtype=np.float64)
