"""The motion at the first sample, from the first recorded positions: where the recording says it, no fit has to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.companion_form import companion, time_scale
from camid.engine.mechanics import companion_block
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.identification.structure import Structure

Array = NDArray[np.float64]
# Motion at the first sample: a cubic through this much of the recording, in time constants of the plant, and its rows.
SMOOTHED = 0.5
FEWEST_SMOOTHED, MOST_SMOOTHED = 6, 60


def recorded_start(problem: Problem, model: Model) -> Model:
    """The model with initial states that the first recorded positions show."""
    initial: list[Array | None] = []
    positions = problem.kind.recorded_positions(problem)
    for index, experiment in enumerate(problem.experiments):
        if not experiment.estimate_initial_state:
            initial.append(None)
            continue
        position, velocity = first_motion(problem, index, problem.kind.at_plant(positions[index], model))
        initial.append(_smallest_state(problem, model, position, velocity))
    return replace(model, initial=tuple(initial))


def with_positions_moved(problem: Problem, model: Model, distance: float) -> Model:
    """The model with initial states whose positions, as the plant counts them, are larger by a distance."""
    moved = _smallest_state(problem, model, distance, 0.0)
    # What effects remember follows the state of the plant.
    padded = [None if s is None else np.concatenate([moved, np.zeros(len(s) - len(moved))]) for s in model.initial]
    states = zip(model.initial, padded, strict=True)
    return replace(model, initial=tuple(None if s is None or m is None else s + m for s, m in states))


def first_motion(problem: Problem, index: int, recorded: Array) -> tuple[float, float]:
    """Position and velocity (per second) where the simulation of a recording starts, by a cubic through its first rows.

    ``recorded`` are its positions as the plant counts them, shape (N,).
    """
    experiment = problem.experiments[index]
    acquisition = experiment.acquisition
    denominator = np.concatenate([[1.0], problem.structure.denominator[1:]])
    constant = time_scale(tuple(denominator))
    rows = int(np.clip(SMOOTHED * constant / acquisition.period, FEWEST_SMOOTHED, MOST_SMOOTHED))
    used = np.flatnonzero(experiment.used)[:rows]
    if len(used) == 0 or (used[0] > rows and np.any(experiment.signal)):
        # A cubic says nothing so far from its rows, and those that are not fitted show the motion, too, as those of a
        # recording that judges only; before a decay the body was held.
        used = np.arange(min(rows, len(recorded)))
    delay = acquisition.window()[0] if problem.kind.state_before_record(experiment) else 0
    exposure = 0.0 if acquisition.sensor == "instant" else float(acquisition.exposure or 0.0)
    # A mean over an exposure is the position in its middle, up to the second order.
    seen = (used + delay) * acquisition.period - acquisition.latency - 0.5 * exposure
    polynomial = np.polynomial.Polynomial.fit(seen, recorded[used], min(3, len(used) - 1))
    return float(polynomial(0.0)), float(polynomial.deriv()(0.0))


def _smallest_state(problem: Problem, model: Model, position: float, velocity: float) -> Array:
    """The smallest companion state with this position and velocity."""
    plant = problem.structure.plant(model.coefficients)
    unit = time_scale(plant.monic.denominator)
    matrix, row, _ = companion_block(plant, unit)
    table = np.vstack([row, row @ matrix / unit])
    wanted = np.array([position, velocity])
    return np.asarray(np.linalg.lstsq(table, wanted, rcond=None)[0], dtype=np.float64)


def companion_state(structure: Structure, coefficients: Array, polynomial: Array) -> Array:
    """Companion state of a plant whose free motion is C/A, as the engine takes it.

    Parameters
    ----------
    structure : Structure
    coefficients : ndarray, shape (m + 1 + n,)
        SI units.
    polynomial : ndarray, shape (n,)
        C in units of the plant's time scale, highest power first, see :func:`camid.chain.exact.sample`.
    """
    plant = structure.plant(coefficients)
    unit = time_scale(plant.monic.denominator)
    order, degree = structure.order, structure.degree
    denominator = np.asarray(plant.monic.denominator) * unit ** np.arange(order + 1)
    numerator = np.asarray(coefficients[: degree + 1]) * unit ** (order - degree + np.arange(degree + 1.0))
    matrix = companion(denominator)
    row = np.zeros(order)
    row[max(order - degree - 1, 0) :] = numerator[-order:]
    observed, wanted = np.zeros((order, order)), np.zeros(order)
    free = np.asarray(polynomial, dtype=float)
    state = np.eye(order)[0]
    for k in range(order):
        observed[k] = row
        wanted[k] = free @ state
        row = row @ matrix
        state = matrix @ state
    return np.asarray(np.linalg.lstsq(observed, wanted, rcond=None)[0], dtype=np.float64)
