"""What a search may begin with where a plant that integrates is driven in a loop which is not declared.

Without what is missing such a plant runs away from the recording, whatever its coefficients, and a screening beside it
says nothing; with one of two effects alone it does, too. The plant's equation holds at the recorded positions with
both.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from camid.diagnosis.search.decision import Decision
from camid.diagnosis.search.hypothesis import Hypothesis, in_order, prior_penalty
from camid.diagnosis.search.hypothesis_fit import ALL_STEPS, implausible
from camid.diagnosis.search.models_around import model_beside, with_plant
from camid.diagnosis.search.screening import candidates
from camid.diagnosis.search.settled_laws import finer_in_place
from camid.effects.base import Effect
from camid.effects.disturbance import StepDisturbance
from camid.effects.drift import ParameterDrift
from camid.effects.recorded_equation import PlantBesideLaws, plants_beside_laws
from camid.effects.situation import Situation
from camid.fitting.fit import Fitted, fit
from camid.fitting.initial_motion import recorded_start
from camid.fitting.multiple_shooting import may_be_cut, shot_several_times
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.constants import BIAS
from camid.fitting.problem import Problem
from camid.fitting.recorded_zero import recorded_zero
from camid.side_by_side import side_by_side

# Effects that are looked for together, and what they leave, at most: of the equation's rest, and of the mismatch.
TOGETHER, MOST_LEFT, MOST_LEFT_OF_ALL = 2, 0.5, 0.1
# Where a step may set in, as shares of a recording: that of a simulation which runs away is found at other times.
ONSETS = np.linspace(0.02, 0.98, 49)


@dataclass(frozen=True)
class Beginning:
    """What a search may begin with.

    Attributes
    ----------
    decision : Decision, optional
        Two effects that explain nearly all of the mismatch together.
    models : tuple of Model
        With one effect, for fits to start from.
    """

    decision: Decision | None = None
    models: tuple[Model, ...] = ()


def beginning_in_a_loop(problem: Problem, base: Fitted) -> Beginning:
    """The forces that explain most of the recorded motion, beside the plant which it shows with them.

    Parameters
    ----------
    problem : Problem
    base : Fitted
        Without an effect.

    Returns
    -------
    Beginning
        With neither where the plant does not integrate, or no forces explain most.
    """
    try:
        known = recorded_zero(problem, base.model)
        found = _forces(problem, base, known)
        if not found:
            return Beginning()
        if len(found[0].laws) < TOGETHER:
            start = _start(problem, known, found[0])
            return Beginning(models=(start,) if start else ())
        fitted = [each for each in side_by_side(partial(_fitted, problem, known), found) if each is not None]
        if not fitted:
            return Beginning()
        best = finer_in_place(problem, in_order(fitted)[0].fitted, len(base.model.effects), last=True)
        return Beginning(_decision(problem, base, best))
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return Beginning()


def _forces(problem: Problem, base: Fitted, known: Model) -> list[PlantBesideLaws]:
    """What the plant's equation shows, the likeliest first; nothing where it integrates not, or they explain little."""
    if problem.structure.plant(known.coefficients).denominator[-1] != 0.0:
        return []
    situation = problem.situations(known).plant
    found = plants_beside_laws(situation, _shapes(problem, base, situation), TOGETHER)
    return found if found and found[0].left <= MOST_LEFT else []


def _start(problem: Problem, known: Model, found: PlantBesideLaws) -> Model | None:
    """A model with forces beside the plant that they hold with, fitted to parts of the recordings, or as it follows.

    None where no coefficients make that plant.
    """
    free = {constant.name for constant in problem.kind.free_constants()}
    model = replace(known, effects=(*known.effects, *found.laws))
    constants = dict.fromkeys({BIAS.name} & free, found.bias)
    if not may_be_cut(problem):
        return model_beside(problem, model, found.plant, constants)
    start = with_plant(problem, model, found.plant, constants)
    return None if start is None else shot_several_times(problem, recorded_start(problem, start))


def _fitted(problem: Problem, known: Model, found: PlantBesideLaws) -> Hypothesis | None:
    """Forces as a hypothesis; None where they may not be."""
    try:
        start = _start(problem, known, found)
        if start is None:
            return None
        fitted = fit(problem, start, steps=ALL_STEPS)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return None
    if implausible(problem, fitted.model):
        return None
    return Hypothesis("", fitted, sum(prior_penalty(problem, law) for law in found.laws))


def _decision(problem: Problem, base: Fitted, fitted: Fitted) -> Decision | None:
    """That for the effects of a fitted model; None where they may not be, or leave much."""
    if fitted.cost > MOST_LEFT_OF_ALL * base.cost or implausible(problem, fitted.model):
        return None
    laws = fitted.model.effects[len(base.model.effects) :]
    in_place = [[Hypothesis(law.identifier, fitted, prior_penalty(problem, law))] for law in laws]
    return Decision(base, fitted, in_place, [base] * len(in_place))


def _shapes(problem: Problem, base: Fitted, situation: Situation) -> list[Effect]:
    """First guesses of forces that the recordings can show, those that the motion shows too, and steps at any time."""
    shapes = [
        each
        for each in candidates(problem, base)
        if (each.force is not None or each.friction_level is not None) and not isinstance(each, ParameterDrift)
    ]
    kinds = {type(each) for each in shapes}
    guesses = [kind.with_plant(situation, {}) for kind in sorted(kinds, key=lambda kind: kind.__name__)]
    shapes += [guess[0] for guess in guesses if guess is not None]
    if StepDisturbance in kinds:
        shapes += [StepDisturbance(size=1.0, time=float(t)) for t in np.quantile(situation.time, ONSETS)]
    return shapes
