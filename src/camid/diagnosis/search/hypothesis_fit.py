"""A hypothesis, fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from camid.diagnosis.search.hypothesis import Hypothesis, prior_penalty
from camid.effects.base import Effect
from camid.engine.input import grid_input
from camid.fitting.fit import Fitted, fit
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.observed import ObservedPlant
from camid.fitting.problem import Problem
from camid.fitting.recorded_extent import extent_of

# Evaluations for a first and for a thorough fit.
FIRST_STEPS = 8
ALL_STEPS = 30
# How often derivatives are computed anew in a fit: updates of them mislead along the valleys in which numbers make up
# for each other. Without an input a fit seldom follows the motion anyway, and more of them are begun instead.
REFRESHES, REFRESHES_OVER_TIME = 10, 3
# Fall of the sum of squares in a step, as a share, that ends a fit: in thousands of rows no evidence.
TOLERANCE = 1e-6
# Share of the input's spread that actuators pass on at least, and steps in a period between which it is looked at.
LEAST_PASSED, STEPS_IN_A_PERIOD = 0.1, 4


def fitted_hypothesis(
    problem: Problem,
    identifier: str,
    start: Model,
    steps: int,
    base: Fitted | None = None,
    index: int | None = None,
) -> Hypothesis | None:
    """The hypothesis of an effect of a model, the last one if nothing else is said, fitted from there.

    Parameters
    ----------
    problem : Problem
    identifier : str
    start : Model
    steps : int
        Evaluations at most; where all is linear always those of a thorough fit.
    base : Fitted, optional
        The model without the effect: a first fit, which takes its noise and its scales from there.
    index : int, optional
        Which of the model's effects it is.

    Returns
    -------
    Hypothesis or None
        None where the fit fails or ends at values that are not possible.
    """
    if is_linear(problem, start):
        steps, refreshes = ALL_STEPS, REFRESHES
    else:
        often = REFRESHES_OVER_TIME if problem.kind.phases_add_up else REFRESHES
        refreshes = 0 if base else often
    try:
        if any(effect.jumps_by for effect in start.effects):
            # Where the output jumps no derivative leads on: what else may change is fitted to a good value before it.
            start = fit(problem, start, steps=steps, fixed=len(start.effects), refreshes=refreshes).model
        result = fit(
            problem, start, steps=steps, base=base, refreshes=refreshes, finest=base is None, tolerance=TOLERANCE
        )
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return None
    if not np.isfinite(result.noise.deviance):
        return None
    place = len(start.effects) - 1 if index is None else index
    if place in implausible(problem, result.model):
        return None
    return Hypothesis(identifier, result, prior_penalty(problem, result.model.effects[place]))


def is_linear(problem: Problem, model: Model) -> bool:
    """Whether a plant and all effects are linear."""
    return problem.kind.nonlinear(model) is None and all(e.linear_dynamics for e in model.effects)


def _bending_actuators(model: Model) -> set[int]:
    """The effects of a model that bend what an actuator passes on."""
    return {i for i, e in enumerate(model.effects) if e.place == "actuator" and not e.linear_dynamics}


def takes_input_away(problem: Problem, effects: Sequence[Effect]) -> bool:
    """Whether actuators leave hardly anything of the input, so that an observer's pull alone makes the motion.

    A controller makes up for what is missing: without its command a simulation that does not have it is disturbed less.

    Parameters
    ----------
    problem : Problem
    effects : sequence of Effect
        In the order in which they act.
    """
    sent, passed = [], []
    for experiment in problem.experiments:
        arrived, _ = grid_input(effects, experiment.signal, experiment.acquisition, 0, STEPS_IN_A_PERIOD)
        sent.append(float(np.std(experiment.signal)))
        passed.append(float(np.std(arrived)))
    return sum(passed) < LEAST_PASSED * sum(sent)


def implausible(problem: Problem, model: Model) -> set[int]:
    """Which effects of a model have values that are not possible on the way and in the time recorded.

    Those of an actuator that leave hardly anything of the input are not where an observer makes the motion.
    """
    cut = _bending_actuators(model) if isinstance(problem.kind, ObservedPlant) else set()
    if cut and takes_input_away(problem, model.in_order()):
        return cut
    if all(type(effect).is_plausible is Effect.is_plausible for effect in model.effects):
        return set()
    extent, names = extent_of(problem), [effect.identifier for effect in model.effects]
    extents = [replace(extent, beside=frozenset(names[:i] + names[i + 1 :])) for i in range(len(names))]
    return {i for i, effect in enumerate(model.effects) if not effect.is_plausible(extents[i])}
