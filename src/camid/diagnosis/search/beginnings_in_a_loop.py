"""What a search may begin with where a plant that integrates is driven in a loop which is not declared.

Without what is missing such a plant runs away from the recording, whatever its coefficients, and a screening beside it
says nothing; with one of two effects alone it does, too. The plant's equation holds at the recorded positions with
both.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np

from camid.diagnosis.search.decision import Decision
from camid.diagnosis.search.hypothesis import Hypothesis, in_order, prior_penalty
from camid.diagnosis.search.hypothesis_fit import ALL_STEPS, implausible
from camid.diagnosis.search.hypothesis_search import RUN_AWAY, is_far_off
from camid.diagnosis.search.models_around import with_plant
from camid.diagnosis.search.screening import candidates
from camid.diagnosis.search.settled_laws import finer_in_place
from camid.diagnosis.search.sharpened_starts import sharpened
from camid.effects.actuator import GainAsymmetry, InputBias, RateLimit, Saturation
from camid.effects.arm_gravity import ANGLES, ArmGravity
from camid.effects.base import Effect
from camid.effects.dead_zone import DeadZone
from camid.effects.disturbance import StepDisturbance
from camid.effects.drift import ParameterDrift
from camid.effects.pursued_forces import PlantBesideLaws, plants_beside_laws
from camid.effects.sensor import Delay
from camid.effects.situation import Situation
from camid.fitting.fit import Fitted, fit
from camid.fitting.growing_horizon import fitted_as_far_as_it_follows, rows_followed
from camid.fitting.initial_motion import recorded_start
from camid.fitting.multiple_shooting import may_be_cut, on_shortest_parts, shot_several_times
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.constants import BIAS
from camid.fitting.problem import Problem
from camid.fitting.recorded_zero import recorded_zero
from camid.side_by_side import side_by_side

# Forces that are looked for together, and what they leave, at most: of the equation's rest, and of the mismatch. What
# one leaves alone for others not to be looked for beside it yet, unless they leave so much less than that.
TOGETHER, MOST_LEFT, MOST_LEFT_OF_ALL, ENOUGH_ALONE, MUCH_LESS = 2, 0.5, 0.1, 0.05, 0.5
# Pairs of effects that are followed to the end, and single ones beside them that leave hardly more than the best one.
MOST_FOLLOWED, MOST_ALONE, NEARLY_AS_GOOD = 2, 3, 1.25
# Where a step may set in, as shares of a recording: that of a simulation which runs away is found at other times.
ONSETS = np.linspace(0.02, 0.98, 49)
# Quantiles of the command's sizes that a curve of it may have its edge at, and the highest edge in the largest size.
LEVELS, HIGHEST = np.linspace(0.05, 0.95, 19), 0.9
# Angles from where an arm hangs at the sensor's zero: half a turn further its torque has the other sign.
PHASES = np.arange(4) * 0.25 * np.pi
# Ratios of the gains for negative and positive commands.
RATIOS = np.geomspace(0.5, 2.0, 18)
# Delays in periods.
PERIODS = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 13.0, 17.0, 22.0, 30.0)
# Rates between that which takes a whole recording for the command's spread and that of the command's largest step.
RATES = np.linspace(0.1, 0.95, 35)


@dataclass(frozen=True)
class Beginning:
    """What a search may begin with.

    Attributes
    ----------
    decision : Decision, optional
        With effects that stand already, or explain nearly all of the mismatch together.
    models : tuple of Model
        With one effect, for fits to start from.
    runs_away : bool
        Whether the plant's equation shows what is missing, and no simulation with it follows the recordings.
    """

    decision: Decision | None = None
    models: tuple[Model, ...] = ()
    runs_away: bool = False


def first_beginning(problem: Problem, base: Fitted, pulled: Problem | None = None, *, held: bool = False) -> Beginning:
    """What a search begins with: what the plant's equation shows where the base is far off the recordings.

    One that an observer has ``held`` beside them is never far off, and its coefficients are bent all the same. With
    that observer the problem is ``pulled``.
    """
    if held:
        return beginning_in_a_loop(problem, base, problem)
    return beginning_in_a_loop(problem, base, pulled) if is_far_off(problem, base) else Beginning()


def beginning_in_a_loop(problem: Problem, base: Fitted, pulled: Problem | None = None) -> Beginning:
    """The forces that explain most of the recorded motion, beside the plant which it shows with them.

    Parameters
    ----------
    problem : Problem
    base : Fitted
        Without an effect.
    pulled : Problem, optional
        The same with an observer, which sharpens what the equation shows.

    Returns
    -------
    Beginning
        With neither where the plant does not integrate, or no forces explain most.
    """
    try:
        known = _not_run_away(problem, recorded_zero(problem, base.model))
        found = _forces(problem, base, known)
        if not found:
            return Beginning()
        alone = [each for each in found if len(each.laws) < TOGETHER]
        least = min((each.left for each in alone), default=1.0)
        most = least if least > ENOUGH_ALONE else 0.0 if pulled is None else MUCH_LESS * least
        pairs = [each for each in found if len(each.laws) >= TOGETHER and each.left < most]
        starts = [start for each in pairs for start in _starts(problem, known, each)]
        starts = _likeliest(problem, starts) if pulled is None else sharpened(problem, pulled, starts)[:MOST_FOLLOWED]
        # With the noise of a loop in it the equation prefers two laws to one, and one of the command to the right one.
        near = [each for each in alone if each.left <= NEARLY_AS_GOOD * least and least <= MOST_LEFT] if pairs else []
        starts += [start for each in near[:MOST_ALONE] for start in _starts(problem, known, each)[:1]]
        fitted = [each for each in side_by_side(partial(_fitted, problem), starts) if each is not None]
        if fitted:
            best = finer_in_place(problem, in_order(fitted)[0].fitted, len(base.model.effects), last=True)
            decision = _decision(problem, base, best)
            # What ends in another well says less of the rest than a simulation that an observer holds.
            if decision is not None and (pulled is None or _follows(problem, best.model)):
                return Beginning(decision)
        single = _starts(problem, known, alone[0])[:1] if alone and least <= MOST_LEFT else []
        models = tuple(_as_far_as_it_follows(problem, start) for start in single)
        runs_away = found[0].left <= ENOUGH_ALONE and not any(_follows(problem, model) for model in models)
        return Beginning(None, models, runs_away)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return Beginning()


def beginning_with(problem: Problem, base: Fitted, shown: Model) -> Beginning | None:
    """The effects that a part of the recordings has shown, fitted to all; None where they leave much.

    Parameters
    ----------
    problem : Problem
    base : Fitted
        Without an effect.
    shown : Model
        With the effects, from where the fit starts.
    """
    found = _fitted(problem, shown) if len(shown.effects) > len(base.model.effects) else None
    decision = None if found is None else _decision(problem, base, found.fitted)
    return None if decision is None else Beginning(decision)


def _follows(problem: Problem, model: Model) -> bool:
    """Whether a model follows the recordings to their end."""
    return rows_followed(problem, model) >= min(map(len, problem.times))


def _not_run_away(problem: Problem, model: Model) -> Model:
    """A model whose free coefficients are those of the simulation where a fit has driven them to where no rig's are."""
    given = problem.structure.coefficients()
    known = problem.structure.free & (given != 0.0)
    ratio = np.divide(model.coefficients, given, out=np.ones_like(given), where=known)
    lost = (ratio < 1.0 / RUN_AWAY) | (ratio > RUN_AWAY)
    return replace(model, coefficients=np.where(lost, given, model.coefficients))


def _forces(problem: Problem, base: Fitted, known: Model) -> list[PlantBesideLaws]:
    """What the plant's equation shows, the likeliest first; nothing where it integrates not, or they explain little."""
    if problem.structure.plant(known.coefficients).denominator[-1] != 0.0:
        return []
    situation = problem.situations(known).plant
    guessed = list(candidates(problem, base))
    kinds = {type(each) for each in guessed}
    period = situation.acquisition.period
    delays = [Delay(delay=periods * period) for periods in PERIODS if Delay in kinds]
    found = plants_beside_laws(situation, _shapes(guessed, situation), TOGETHER, _curves(kinds, situation), delays)
    return found if found and found[0].left <= MOST_LEFT else []


def _starts(problem: Problem, known: Model, found: PlantBesideLaws) -> list[Model]:
    """Models with forces beside the plant that they hold with; none where no coefficients make that plant.

    The constant that the equation shows acts where the forces do: what bends the command may have one on either side.
    """
    free = {constant.name for constant in problem.kind.free_constants()}
    model = replace(known, effects=(*known.effects, *found.laws))
    starts = [with_plant(problem, model, found.plant, dict.fromkeys({BIAS.name} & free, found.bias))]
    if BIAS.name in free and problem.kind.unseen_beside(InputBias, model) is None:
        behind = model.plus(InputBias(bias=found.bias))
        starts.append(with_plant(problem, behind, found.plant, {BIAS.name: 0.0}))
    return [start for start in starts if start is not None]


def _likeliest(problem: Problem, starts: Sequence[Model]) -> list[Model]:
    """Those of some models that are likeliest on short parts of the recordings."""
    if not may_be_cut(problem) or len(starts) < 2:
        return list(starts)
    return [fitted.model for fitted in on_shortest_parts(problem, starts)[:MOST_FOLLOWED]]


def _as_far_as_it_follows(problem: Problem, start: Model) -> Model:
    """A model fitted as far as it follows the recordings, and to parts of them before where that is not to the end."""
    start = recorded_start(problem, replace(start, initial=()))
    followed = fitted_as_far_as_it_follows(problem, start)
    if not may_be_cut(problem) or _follows(problem, followed):
        return followed
    return fitted_as_far_as_it_follows(problem, shot_several_times(problem, start))


def _fitted(problem: Problem, start: Model) -> Hypothesis | None:
    """Forces as a hypothesis; None where they may not be."""
    try:
        fitted = fit(problem, _as_far_as_it_follows(problem, start), steps=ALL_STEPS)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return None
    if implausible(problem, fitted.model):
        return None
    return Hypothesis("", fitted, sum(prior_penalty(problem, law) for law in fitted.model.effects))


def _decision(problem: Problem, base: Fitted, fitted: Fitted) -> Decision | None:
    """That for the effects of a fitted model; None where they may not be, or leave much."""
    if fitted.cost > MOST_LEFT_OF_ALL * base.cost or implausible(problem, fitted.model):
        return None
    laws = fitted.model.effects[len(base.model.effects) :]
    in_place = [[Hypothesis(law.identifier, fitted, prior_penalty(problem, law))] for law in laws]
    return Decision(base, fitted, in_place, [base] * len(in_place))


def _curves(kinds: Set[type[Effect]], situation: Situation) -> list[Effect]:
    """What may arrive of the command: curves with edges anywhere in it or of any asymmetry, and what any rate lets."""
    sizes = np.unique(np.quantile(np.abs(situation.signal), LEVELS))
    # Of a command that is at its limit most of the time an edge there leaves all, or nothing.
    sizes = sizes[(sizes > 0.0) & (sizes < HIGHEST * situation.largest("signal"))]
    curves: list[Effect] = [Saturation(limit=float(size)) for size in sizes]
    curves += [DeadZone(half_width=float(size)) for size in sizes]
    curves += [GainAsymmetry(ratio=float(ratio)) for ratio in RATIOS]
    slowest = float(np.std(situation.signal)) / situation.duration
    fastest = float(np.max(np.abs(np.diff(situation.signal)), initial=0.0)) / situation.acquisition.period
    if slowest > 0.0:
        curves += [RateLimit(rate=float(slowest * (fastest / slowest) ** share)) for share in RATES]
    return [curve for curve in curves if type(curve) in kinds]


def _shapes(guessed: Sequence[Effect], situation: Situation) -> list[Effect]:
    """Of first guesses the forces, those that the motion shows too, and steps at any time."""
    shapes = [
        each
        for each in guessed
        if (each.force is not None or each.friction_level is not None) and not isinstance(each, ParameterDrift)
    ]
    kinds = {type(each) for each in shapes}
    guesses = [kind.with_plant(situation, {}) for kind in sorted(kinds, key=lambda kind: kind.__name__)]
    shapes += [guess[0] for guess in guesses if guess is not None]
    if ArmGravity in kinds:
        largest = situation.largest("recorded")
        # An angle in radians has one of them, whatever the arm; other readings have any.
        for amplitude, phase in product((1.0, *(largest / angle for angle in ANGLES)), PHASES):
            shapes.append(ArmGravity(amplitude=amplitude, torque=1.0, phase=float(phase)))
    if StepDisturbance in kinds:
        shapes += [StepDisturbance(size=1.0, time=float(t)) for t in np.quantile(situation.time, ONSETS)]
    return shapes
