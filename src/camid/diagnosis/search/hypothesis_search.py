"""The likeliest effects of a screening, fitted as hypotheses beside a base model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

import numpy as np

from camid.diagnosis.search.hypotheses_over_time import raced
from camid.diagnosis.search.hypothesis import Hypothesis, in_order
from camid.diagnosis.search.hypothesis_fit import ALL_STEPS, FIRST_STEPS, fitted_hypothesis, is_linear
from camid.diagnosis.search.models_around import models_around, models_with_plants
from camid.diagnosis.search.related_laws import finer_laws, plainer_law, possible_relatives, special_case_in_place
from camid.diagnosis.search.screening import ScreenedEffect, alike, screen, trials
from camid.diagnosis.watch import NAMES, Watch
from camid.effects.base import Effect
from camid.fitting.fit import Fitted, evaluate
from camid.fitting.multiple_shooting import may_be_cut, shot_several_times
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.side_by_side import side_by_side

Start = TypeVar("Start")

# Error, as a share of the output's spread, from which fits start from the nominal coefficients, too.
NOMINAL_START_ERROR = 0.1
MOST_FROM_NOMINAL = 7
# Sum of squares of the best start from other coefficients over the least one from the refitted ones, below which these
# were bent; and effects that are then started again.
BENT_COST, MOST_BESIDE_BETTER = 0.5, 4
# Factor of a coefficient beyond which it has run away from the nominal one, which is known within a factor of three.
RUN_AWAY = 30.0
# Shapes of the best effect that are fitted, too, where it is a resonance, which costs next to nothing, and the share of
# its best one's screened gain that they need.
MOST_FURTHER_SHAPES, NEARLY = 6, 0.1
# Evaluations of a first fit that begins with a small effect.
STEPS_FROM_SMALL = 16
# Candidates that chance explains with this probability are not fitted.
MOST_CHANCE = 0.1
# Hypotheses whose criterion exceeds the best by more than this are not fitted thoroughly, unless their first fits,
# which end where they may, explain this share of what the best one explains.
LARGEST_CRITERION_GAP, MUCH_EXPLAINED = 50.0, 0.5
MOST_THOROUGH = 6
# Candidates that are fitted whatever is done, and the share of the likeliest one's gain from which a candidate should
# explain much.
IN_ANY_CASE, SHOULD_EXPLAIN = 2, 0.5
# Of the hypotheses that are fitted thoroughly, those that are fitted to parts of the recordings, too, and the error, as
# a share of the output's spread, from which the whole may have caught them.
MOST_SHOT, CAUGHT_ERROR = 2, 0.03
# Share of the work after which laws of the likeliest effect alone get more detail.
DETAIL_OF_OTHERS = 0.5


@dataclass(frozen=True)
class SearchEffort:
    """How many candidates of a screening are fitted.

    Attributes
    ----------
    effects : int
        Different effects that are fitted.
    least_share : float
        Candidates whose screened gain is below this share of the best are not fitted.
    gap_share : float
        Hypotheses whose criterion exceeds the best by less than this share of the best one's gain are fitted
        thoroughly, too.
    """

    effects: int
    least_share: float = 0.01
    gap_share: float = 0.0


# A first fit of a few steps may stop far from where a thorough one ends.
FIRST_EFFECT = SearchEffort(12, gap_share=0.3)
# Several recordings say so much more than a first fit reaches that its criterion hardly ranks.
GAP_SHARE_SEVERAL = 0.5
# Where phases add up the screening is a poor guide; beside a first effect the motion is followed, and it is one again.
FIRST_EFFECT_OVER_TIME = SearchEffort(12, least_share=0.0, gap_share=0.6)
BESIDE_OTHERS = SearchEffort(7)
RIVALS = SearchEffort(5, gap_share=0.3)


def first_effort(problem: Problem) -> SearchEffort:
    """The effort in a search for a first effect."""
    effort = FIRST_EFFECT_OVER_TIME if problem.kind.phases_add_up else FIRST_EFFECT
    return effort if len(problem.fitted_runs) < 2 else replace(effort, gap_share=GAP_SHARE_SEVERAL)


def hypotheses(
    problem: Problem,
    base: Fitted,
    screened: Sequence[ScreenedEffect],
    nominal: Model | None = None,
    *,
    effort: SearchEffort,
    watch: Watch,
    incumbent: Hypothesis | None = None,
    others: Sequence[Model] = (),
) -> list[Hypothesis]:
    """The likeliest candidates, fitted together with the coefficients and everything in the base, the best first.

    With ``nominal`` effects without parameters start from it, too: they may have bent the refitted model beyond repair.
    ``others`` are models with an effect that fits start from in addition.
    What is far behind an ``incumbent`` after a first fit is not fitted thoroughly.
    """
    starts = _shortlist(problem, screened, effort)
    elsewhere = list(others)
    if nominal is not None and not watch.no_time_for("starts from other coefficients"):
        elsewhere += _starts_elsewhere(problem, nominal, screened)

    from_model = partial(_fitted_from, problem, watch, "other starts of", FIRST_STEPS)
    of_plants = models_with_plants(problem, base, (c.effect.identifier for c in screened))
    first = _in_batches(from_model, of_plants, watch)
    first += _in_batches(partial(_fitted_first, problem, watch, base, starts), starts, watch)
    first += _in_batches(from_model, elsewhere, watch)
    if nominal is not None and not nominal.effects and all(_is_lost(problem, h.fitted) for h in first):
        first += _in_batches(from_model, raced(problem, nominal), watch)
    first += _in_batches(from_model, _beside_better_coefficients(problem, base, starts, elsewhere, first), watch)
    first += _simpler(problem, base, first)
    in_other_minima = partial(_fitted_from, problem, watch, "other shapes of", ALL_STEPS)
    # What bears the same name gets no more steps than the other names, or these would fall behind for that alone.
    first += _in_batches(from_model, _relatives(problem, base, first, same_name=True), watch)
    related = _relatives(problem, base, first)
    first += _in_batches(in_other_minima, [*related, *_screened_of(base.model, related, screened, first)], watch)
    ranked = best_of_each(first)
    further = _further_shapes(base.model, screened, starts, ranked[0]) if ranked else []
    ranked = best_of_each([*ranked, *_in_batches(in_other_minima, further, watch)])
    near = _near_the_best(ranked, base, effort, incumbent)
    watch.take_stock(NAMES)
    thorough = side_by_side(partial(_fitted_thoroughly, problem, watch, near), near)
    found = in_order([*thorough, *(h for h in ranked if not any(h is chosen for chosen in near))])
    watch.take_stock(NAMES)
    if watch.no_time_for("finer laws"):
        return found
    # What shows beside the likeliest matters more than detail in the law of what comes second.
    finer = finer_laws(problem, found[: 1 if watch.has_done(DETAIL_OF_OTHERS) else len(near)])
    finer += _in_batches(in_other_minima, _relatives(problem, base, finer), watch)
    ranked = best_of_each([*found, *finer])
    if not ranked:
        return ranked
    if finer:  # its special case was fitted from elsewhere, and with less detail
        special = special_case_in_place(problem, ranked[0].fitted, len(base.model.effects), steps=ALL_STEPS)
        ranked = best_of_each([*ranked, *([special] if special else [])])
    plainer = plainer_law(problem, ranked[0].fitted, len(base.model.effects))
    if plainer is None or plainer.beyond(ranked[0]) >= 0.0:
        return ranked
    watch.take_stock(NAMES)
    if watch.no_time_for("finer laws"):
        return best_of_each([*ranked, plainer])
    # Where more detail has come to nothing, that of another kind was begun from there, and may not have been found.
    return best_of_each([*ranked, plainer, *finer_laws(problem, [plainer])])


def _in_batches(
    fitted: Callable[[Start], Hypothesis | None], starts: Sequence[Start], watch: Watch
) -> list[Hypothesis]:
    """The hypotheses that fits from some starts end in, a few at a time."""
    return [h for some in watch.batches(starts) for h in side_by_side(fitted, some) if h is not None]


def _fitted_from(problem: Problem, watch: Watch, part: str, steps: int, model: Model) -> Hypothesis | None:
    """A fit from a model with an effect, where there is time for that part of the search."""
    identifier = model.effects[-1].identifier
    if watch.no_time_for(f"{part} {identifier}"):
        return None
    return fitted_hypothesis(problem, identifier, model, steps)


def _fitted_thoroughly(
    problem: Problem, watch: Watch, near: Sequence[Hypothesis], hypothesis: Hypothesis
) -> Hypothesis:
    """A hypothesis fitted on; of those near the best the first one whatever is done, as it is what may be found."""
    if watch.no_time_for("more thorough fits", needed=hypothesis is near[0]):
        return hypothesis
    found = fitted_hypothesis(problem, hypothesis.identifier, hypothesis.fitted.model, ALL_STEPS)
    best = found if found is not None and found.beyond(hypothesis) < 0.0 else hypothesis
    if not any(hypothesis is each for each in near[:MOST_SHOT]) or not _may_be_caught(problem, best.fitted):
        return best
    shot = shot_several_times(problem, best.fitted.model)
    found = fitted_hypothesis(problem, hypothesis.identifier, shot, ALL_STEPS)
    return found if found is not None and found.beyond(best) < 0.0 else best


def _may_be_caught(problem: Problem, fitted: Fitted) -> bool:
    """Whether a fit may have ended in one of many minima: of a motion that nothing holds where it is recorded."""
    if problem.structure.denominator[-1] != 0.0 or not may_be_cut(problem) or is_linear(problem, fitted.model):
        return False
    return _leaves_much(problem, fitted)


def _leaves_much(problem: Problem, fitted: Fitted) -> bool:
    """Whether a model leaves more than small corrections to it would."""
    return fitted.cost > CAUGHT_ERROR**2 * float(np.var(problem.recorded)) * len(fitted.residual)


def _fitted_first(
    problem: Problem, watch: Watch, base: Fitted, starts: Sequence[ScreenedEffect], candidate: ScreenedEffect
) -> Hypothesis | None:
    """A few steps of a fit from an effect beside a base, where there is time for it.

    There is for the likeliest, as they were screened. Where they lead nowhere, the size that the screening suggests is
    too large for coefficients that were bent without the effect: it is begun small, and with derivatives of its own;
    as an effect that should explain much is where the fit explains hardly anything.
    """
    if watch.no_time_for(candidate.effect.identifier, needed=any(candidate is each for each in starts[:IN_ANY_CASE])):
        return None
    effect = candidate.start
    found = fitted_hypothesis(problem, effect.identifier, base.model.plus(effect), FIRST_STEPS, base)
    nowhere = found is None or found.fitted.cost >= base.cost
    if not nowhere and found is not None and candidate.gain >= SHOULD_EXPLAIN * starts[0].gain:
        nowhere = found.beyond(Hypothesis("", base)) >= 0.0
    if nowhere and effect.numeric():
        small = base.model.plus(candidate.effect)
        again = fitted_hypothesis(problem, effect.identifier, small, STEPS_FROM_SMALL)
        found = again if found is None or (again is not None and again.beyond(found) < 0.0) else found
    return found if found is not None and found.fitted.cost < base.cost else None


def is_far_off(problem: Problem, fitted: Fitted) -> bool:
    """Whether a model is so far from the recordings that its coefficients may be bent beyond repair."""
    return fitted.cost >= NOMINAL_START_ERROR**2 * float(np.var(problem.recorded)) * len(fitted.residual)


def has_run_away(fitted: Fitted, nominal: Model) -> bool:
    """Whether a coefficient has left the nominal one by a factor that no rig's does, as a pole does that imitates."""
    found, given = np.abs(fitted.model.coefficients), np.abs(nominal.coefficients)
    known = given > 0.0
    return bool(np.any(found[known] > RUN_AWAY * given[known]))


def _is_lost(problem: Problem, fitted: Fitted) -> bool:
    """Whether what a model leaves is far off and more than white noise, and its hypotheses were not raced already."""
    return not problem.kind.phases_add_up and is_far_off(problem, fitted) and len(fitted.noise.whitening) > 1


def _starts_elsewhere(problem: Problem, nominal: Model, screened: Sequence[ScreenedEffect]) -> list[Model]:
    """Models with an effect that fits should start from where the refitted coefficients may be bent beyond repair."""
    found = [nominal.plus(effect) for effect in _from_nominal(problem, nominal, screened)]
    for candidate in screened:
        if candidate.effect.bends_coefficients:
            found += models_around(problem, nominal.plus(candidate.effect))
    if problem.kind.phases_add_up:
        found += raced(problem, nominal)
    return found


def _beside_better_coefficients(
    problem: Problem,
    base: Fitted,
    screened: Sequence[ScreenedEffect],
    elsewhere: Sequence[Model],
    fitted: Sequence[Hypothesis],
) -> list[Model]:
    """Models with effects that were started beside bent coefficients alone, beside those of the best hypothesis.

    Where a start from other coefficients ends far below all that were begun at the refitted ones, these were bent, and
    what was begun there says nothing.
    """
    tried = {model.effects[-1].identifier for model in elsewhere}
    ranked = best_of_each(fitted)
    bent = [h for h in ranked if h.identifier not in tried]
    if not (ranked and bent and ranked[0].identifier in tried):
        return []
    best = ranked[0].fitted
    if best.cost > BENT_COST * min(h.fitted.cost for h in bent):
        return []
    found: dict[str, Model] = {}
    for candidate in screened:
        effect = candidate.start
        if effect.identifier not in tried and len(found) < MOST_BESIDE_BETTER:
            beside = best.model.without(len(base.model.effects))
            found.setdefault(effect.identifier, beside.plus(effect))
    return list(found.values())


def best_of_each(fitted: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The best hypothesis of each effect, the best first."""
    best: dict[str, Hypothesis] = {}
    for hypothesis in fitted:
        known = best.get(hypothesis.identifier)
        if known is None or hypothesis.beyond(known) < 0.0:
            best[hypothesis.identifier] = hypothesis
    return in_order(list(best.values()))


def _further_shapes(
    base: Model, screened: Sequence[ScreenedEffect], tried: Sequence[ScreenedEffect], best: Hypothesis
) -> list[Model]:
    """Models with other shapes of the likeliest effect, if it is a resonance, which has many minima.

    The coefficients are those without it, and those that a fit found beside it.
    """
    identifier, beside = best.identifier, best.fitted.model.without(len(base.effects))
    # A special case may lead that was not screened itself.
    shapes = [c for c in screened if c.effect.identifier == identifier]
    if not shapes or not shapes[0].effect.linear_dynamics or len(shapes[0].effect.vector) < 2:
        return []
    known = [c.start for c in tried if c.effect.identifier == identifier]
    further: list[Effect] = []
    for candidate in shapes:
        new = not any(alike(candidate.effect, k) for k in [*known, *further])
        if candidate.gain >= NEARLY * shapes[0].gain and new:
            further.append(candidate.effect)
    return [model.plus(effect) for effect in further[:MOST_FURTHER_SHAPES] for model in (base, beside)]


def _near_the_best(
    ranked: list[Hypothesis], base: Fitted, effort: SearchEffort, incumbent: Hypothesis | None
) -> list[Hypothesis]:
    """Those that deserve a thorough fit."""
    if not ranked:
        return []
    best = ranked[0] if incumbent is None else in_order([ranked[0], incumbent])[0]
    largest_gap = max(LARGEST_CRITERION_GAP, effort.gap_share * base.criterion_beyond(best.fitted))
    enough = base.cost - MUCH_EXPLAINED * (base.cost - best.fitted.cost)
    return [h for h in ranked[:MOST_THOROUGH] if h.beyond(best) <= largest_gap or h.fitted.cost <= enough]


def _from_nominal(problem: Problem, nominal: Model, screened: Sequence[ScreenedEffect]) -> list[Effect]:
    """Effects that a fit should start with from the nominal coefficients, which they may have bent beyond repair.

    Those without parameters, and those that the residual of the nominal model supports.
    """
    effects = [c.effect for c in screened if not c.effect.parameters]
    present = {e.identifier for e in effects}
    for candidate in screen(problem, evaluate(problem, nominal)):
        if candidate.effect.identifier not in present and len(effects) < MOST_FROM_NOMINAL:
            present.add(candidate.effect.identifier)
            effects.append(candidate.start)
    return effects


def _simpler(problem: Problem, base: Fitted, fitted: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Special cases of what was fitted, from where that fit ended."""
    found: dict[str, Hypothesis] = {}
    for hypothesis in sorted(fitted, key=lambda h: h.fitted.cost):
        # What explains less than nothing has wandered off, and its special case would only follow.
        if hypothesis.beyond(Hypothesis("", base)) < 0.0:
            special = special_case_in_place(problem, hypothesis.fitted, len(base.model.effects), set(found))
            if special is not None:
                found[special.identifier] = special
    return list(found.values())


def _relatives(problem: Problem, base: Fitted, fitted: Sequence[Hypothesis], *, same_name: bool = False) -> list[Model]:
    """Models in which effects that do nearly the same take the place of those that explain something.

    Those of another name, and the same law elsewhere; or other laws of the same name where much is left with it.
    """
    models = []
    for hypothesis in best_of_each(fitted):
        if hypothesis.beyond(Hypothesis("", base)) < 0.0:
            model = hypothesis.fitted.model
            name, law = hypothesis.identifier, type(hypothesis.effect)
            relatives = possible_relatives(problem, model, len(model.effects) - 1)
            relatives = [r for r in relatives if (r.identifier == name and type(r) is not law) == same_name]
            if not same_name or _leaves_much(problem, hypothesis.fitted):
                models += [model.replaced(len(model.effects) - 1, relative) for relative in relatives]
    return models


def _screened_of(
    base: Model, related: Sequence[Model], screened: Sequence[ScreenedEffect], fitted: Sequence[Hypothesis]
) -> list[Model]:
    """Related effects of which nothing was fitted, beside the base as the screening suggests them.

    The coefficients beside what they are related to may be none for them.
    """
    missing = {m.effects[-1].identifier for m in related} - {h.identifier for h in fitted}
    likeliest: dict[str, Model] = {}
    for candidate in screened:
        if candidate.effect.identifier in missing:
            likeliest.setdefault(candidate.effect.identifier, base.plus(candidate.start))
    return list(likeliest.values())


def _shortlist(problem: Problem, screened: Sequence[ScreenedEffect], effort: SearchEffort) -> list[ScreenedEffect]:
    """The likeliest shape of each branch of the likeliest effects, of those that may be more than chance."""
    from scipy.special import chdtrc

    if not screened:
        return []
    least = effort.least_share * screened[0].gain
    count = len({c.effect.identifier for c in screened})
    shapes: dict[str, list[ScreenedEffect]] = {}
    for candidate in screened:
        chance = float(chdtrc(1, candidate.gain)) * trials(type(candidate.effect), problem) * count
        if candidate.gain >= least and chance < MOST_CHANCE:
            known = shapes.setdefault(candidate.effect.identifier, [])
            # No fit leads from one branch to another, so that each has its start.
            new = candidate.effect.branch not in {k.effect.branch for k in known}
            if new and not any(alike(candidate.start, k.start) for k in known):
                known.append(candidate)
    return [c for known in list(shapes.values())[: effort.effects] for c in known]
