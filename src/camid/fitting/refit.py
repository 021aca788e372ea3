"""The nominal structure with its coefficients and initial states re-estimated, before any effect is looked for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.fitting.fit import Fitted, evaluate
from camid.fitting.growing_horizon import fit_growing
from camid.fitting.initial_motion import recorded_start
from camid.fitting.problem import Model, Problem, companion_state
from camid.identification.estimate import estimate
from camid.identification.predictor import Predictor

Array = NDArray[np.float64]


def refit(problem: Problem, nominal: Model) -> Fitted:
    """The nominal structure with its coefficients re-estimated, without effects; the exact path of identification."""
    structure = problem.structure
    if not problem.is_linear(nominal):
        return fit_growing(problem, replace(nominal, effects=()))
    if not np.any(structure.free):
        return evaluate(problem, nominal)
    result = estimate(structure, problem.experiments, nominal=structure.plant(nominal.coefficients))
    coefficients = np.array([*result.plant.numerator, *result.plant.denominator[1:]])
    if len(coefficients) != len(structure.free):  # a leading coefficient of the numerator that came out as zero
        coefficients = nominal.coefficients
    return evaluate(problem, at_best_start(problem, Model(coefficients)))


def at_best_start(problem: Problem, model: Model) -> Model:
    """The model with the initial states that fit its linear part best."""
    if not any(e.estimate_initial_state for e in problem.experiments):
        return replace(model, initial=tuple(None for _ in problem.experiments))
    if not problem.is_linear(model):
        return recorded_start(problem, model)
    structure = problem.structure
    denominator = np.concatenate([[1.0], model.coefficients[structure.degree + 1 :]])
    predictor = Predictor.around(structure, problem.experiments, denominator)
    polynomials = predictor.split(predictor.with_fitted_initial_states(model.coefficients))[2]
    initial = tuple(None if p is None else companion_state(structure, model.coefficients, p) for p in polynomials)
    found = replace(model, initial=initial)
    if not model.effects:
        return found
    # Effects may have bent the motion so far from the linear one that its best state is none; the recording shows it.
    return min((found, recorded_start(problem, model)), key=lambda start: _misfit(problem, start))


def _misfit(problem: Problem, model: Model) -> float:
    """Sum of squared residuals; infinite where the simulation fails."""
    try:
        residual = problem.output - problem.fitted(problem.simulate(model))
    except (ValueError, ArithmeticError):
        return np.inf
    return float(np.nan_to_num(residual @ residual, nan=np.inf, posinf=np.inf))
