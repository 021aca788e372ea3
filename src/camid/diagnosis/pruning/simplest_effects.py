"""The fewest and simplest effects, where what is left of the residual says that the laws are not exact anyway.

A likelihood takes every law as exact. With ten thousand samples of a real rig it then calls for a further effect, and a
further parameter, whatever small part of the true law they imitate. Where structure is left, an effect beside
others has to explain most of what the others leave, and a general law has to explain more than its special case by a
margin that justifies a name; else the name would be that of a correction. What they leave is learned as a law without
a name (:mod:`camid.diagnosis.laws.learned_laws`): modelled, and not named.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from camid.diagnosis.residual.mismatch_location import PlaceTest, places_needed, regressors
from camid.diagnosis.residual.residual_structure import STRUCTURE_P_VALUE
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.search.false_alarms import FALSE_ALARM_BESIDE_OTHERS, chance
from camid.diagnosis.search.forward_selection import LAW_ERROR
from camid.diagnosis.search.hypothesis import Hypothesis
from camid.diagnosis.search.hypothesis_fit import ALL_STEPS
from camid.diagnosis.search.screening import Metric
from camid.diagnosis.watch import NAMES, Watch
from camid.fitting.fit import Fitted, fit
from camid.fitting.problem import Problem
from camid.side_by_side import side_by_side

SENSOR = "sensor"
# Share of what the other effects leave, noise subtracted, that one beside them has to explain; and from which it is no
# correction of theirs, which would leave some, however little that is of the mismatch.
LEAST_EXPLAINED, NEARLY_ALL = 0.5, 0.98
# Share of what a general law explains from which its special case takes its place, unless the general one explains this
# share of what that leaves, too: a correction explains some of it.
SPECIAL_CASE_SHARE = 0.9


def simplest(
    problem: Problem, decision: Decision, known: int, left: Sequence[PlaceTest], watch: Watch | None = None
) -> Decision:
    """The decision without effects that only correct others, and with special cases where they say as much.

    Parameters
    ----------
    problem : Problem
    decision : Decision
    known : int
        How many of the model's effects the nominal simulation holds already.
    left : sequence of PlaceTest
        Of what the decision leaves.
    watch : Watch, optional
    """
    noise = (1.0 - min(max((t.share for t in left), default=0.0), 1.0)) * decision.fitted.cost
    inexact: list[str] | None = None
    if watch and decision.rivals:
        watch.say("testing whether fewer and simpler effects say as much")
    certain = set(decision.certain)
    while len(decision.rivals) > 1:
        effects = decision.fitted.model.effects[known:]
        gains = {
            i: decision.without[i].cost - decision.fitted.cost
            for i, effect in enumerate(effects)
            if effect.identifier not in certain
        }
        if not gains:
            break
        weakest = min(gains, key=lambda i: gains[i])
        mismatch = max(decision.base.cost - noise, 1e-300)
        explained = _explained(decision.without[weakest], decision.fitted, noise)
        if explained >= LEAST_EXPLAINED and (gains[weakest] >= LAW_ERROR * mismatch or explained >= NEARLY_ALL):
            break
        if inexact is None:
            inexact = places_needed(problem, decision.fitted, left, STRUCTURE_P_VALUE)
        if _shows_elsewhere(problem, decision, known + weakest, decision.without[weakest], inexact):
            certain.add(effects[weakest].identifier)
            continue
        decision = without_effect(problem, decision, known, weakest, watch)
    decision = replace(decision, certain=frozenset(certain))
    for index in range(len(decision.rivals)):
        decision = _special(problem, decision, known, index, noise, watch)
    return decision


def _shows_elsewhere(problem: Problem, decision: Decision, index: int, without: Fitted, inexact: Sequence[str]) -> bool:
    """Whether an effect corrects none of the laws that are not exact.

    It sits at another place than what they leave, and explains what is left without it where everything that a fault at
    their places could do is allowed for: a discrepancy without a law (Brynjarsdottir & O'Hagan 2014, Inverse Problems
    30, 114007), linear in the functions that locate it.
    """
    effect = decision.fitted.model.effects[index]
    if effect.place == SENSOR and effect.of_one_recording:
        # What a reading does by the clock corrects no law of the motion, but one of the reading alone.
        others = {other.place for i, other in enumerate(decision.fitted.model.effects) if i != index}
        inexact = [place for place in inexact if place in others]
    if not inexact or effect.place in inexact:
        return False
    motions = problem.motion(without.model)
    tables = [regressors(problem, without, motions, place) for place in inexact]
    table = np.hstack(tables)
    # The colour of the noise is that of what is left with all of it: what the effect and those places do is none.
    left = Metric.of(problem, decision.fitted, np.ones(1), beside=table)
    whitening = problem.noise(left.residual, left.basis.shape[1]).whitening
    view = Metric.of(problem, without, whitening, beside=table)
    residual = view.residual
    change, _ = view.left(problem, without.residual - decision.fitted.residual)
    size = float(change @ change)
    gain = float(change @ residual) ** 2 / size if size > 0.0 else 0.0
    noise = max(float(residual @ residual) - gain, 1e-300) / max(len(residual) - view.basis.shape[1], 1)
    return chance(problem, effect.identifier, gain / noise) < FALSE_ALARM_BESIDE_OTHERS


def _explained(without: Fitted, fitted: Fitted, noise: float) -> float:
    """Share of what a model without an effect leaves, noise subtracted, that the effect explains."""
    return (without.cost - fitted.cost) / max(without.cost - noise, 1e-300)


def without_effect(
    problem: Problem, decision: Decision, known: int, index: int, watch: Watch | None = None
) -> Decision:
    """The decision without one of its effects, the others fitted again."""
    rivals = decision.rivals[:index] + decision.rivals[index + 1 :]
    fitted = decision.without[index]
    without = leaving_out(problem, decision.base, fitted, known, watch)
    return replace(decision, fitted=fitted, rivals=rivals, without=without)


def _special(
    problem: Problem, decision: Decision, known: int, index: int, noise: float, watch: Watch | None
) -> Decision:
    """The decision with the special case of an effect in its place, if that explains nearly as much."""
    model = decision.fitted.model
    general = model.effects[known + index]
    special = general.simplified()
    if special is None or any(e.identifier == special.identifier for e in model.effects):
        return decision
    if problem.kind.unseen_beside(type(special), decision.without[index].model) is not None:
        return decision
    fitted = fit(problem, model.replaced(known + index, special), steps=ALL_STEPS)
    without = decision.without[index]
    if without.cost <= fitted.cost:
        return decision
    mismatch = max(without.cost - noise, 1e-300)
    if without.cost - fitted.cost < SPECIAL_CASE_SHARE * min(without.cost - decision.fitted.cost, mismatch):
        return decision
    if _explained(fitted, decision.fitted, noise) >= SPECIAL_CASE_SHARE:
        return decision
    others = [h for h in decision.rivals[index] if h.identifier not in {special.identifier}]
    ranked = [Hypothesis(special.identifier, fitted), *others]
    rivals = [*decision.rivals[:index], ranked, *decision.rivals[index + 1 :]]
    return replace(
        decision, fitted=fitted, rivals=rivals, without=leaving_out(problem, decision.base, fitted, known, watch)
    )


def leaving_out(problem: Problem, base: Fitted, fitted: Fitted, known: int, watch: Watch | None = None) -> list[Fitted]:
    """The model without each of its effects, fitted: from its own coefficients and, if there is time, the base's."""
    count = len(fitted.model.effects) - known
    if count == 1:
        return [base]
    starts = [fitted.model.without(known + i) for i in range(count)]
    if watch is not None:
        watch.take_stock(NAMES)
    if watch is None or not watch.no_time_for("models without an effect from other coefficients"):
        starts += [replace(m, coefficients=base.model.coefficients, initial=base.model.initial) for m in starts]
    found = side_by_side(partial(fit, problem, steps=ALL_STEPS), starts)
    return [min(found[i::count], key=lambda f: f.cost) for i in range(count)]
