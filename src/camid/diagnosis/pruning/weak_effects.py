"""Effects that explain nothing any more beside the others, because something refined after them does it instead."""

from __future__ import annotations

from math import log

from camid.diagnosis.pruning.simplest_effects import without_effect
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.search.false_alarms import STRONG_EVIDENCE
from camid.diagnosis.search.hypothesis import Hypothesis, prior_penalty
from camid.diagnosis.search.hypothesis_fit import ALL_STEPS
from camid.diagnosis.watch import Watch
from camid.fitting.fit import Fitted, fit
from camid.fitting.problem import Problem


def without_weak(problem: Problem, decision: Decision, known: int, watch: Watch) -> Decision:
    """The decision without effects whose evidence beside the others is not strong, the weakest first.

    Parameters
    ----------
    problem : Problem
    decision : Decision
        In the metric of least squares.
    known : int
        How many of the model's effects the nominal simulation holds already.
    watch : Watch
    """
    while decision.rivals:
        effects = decision.fitted.model.effects[known:]
        own = [Hypothesis(e.identifier, decision.fitted, prior_penalty(problem, e)) for e in effects]
        evidence = [-h.beyond(Hypothesis("", left)) for h, left in zip(own, decision.without, strict=True)]
        weakest = min(range(len(evidence)), key=lambda i: evidence[i])
        if evidence[weakest] >= STRONG_EVIDENCE:
            break
        decision = without_effect(problem, decision, known, weakest, watch)
    return decision


def faded(problem: Problem, fitted: Fitted, known: int) -> set[int]:
    """Which effects of a model that was fitted to the end have no strong evidence any more.

    The search compares fits that end as soon as they can be ranked. Only an effect whose size, in standard deviations,
    would be none by itself (Wald's test) is left out to see what the others make of it.

    Parameters
    ----------
    problem : Problem
    fitted : Fitted
        One in another metric than that of least squares was put to the test in its own.
    known : int
        How many of the model's effects the nominal simulation holds already.
    """
    found: set[int] = set()
    if fitted.weighted:
        return found
    names, covariance = fitted.packing.names, fitted.covariance
    enough = STRONG_EVIDENCE + log(len(fitted.residual))
    for index, effect in enumerate(fitted.model.effects[known:], known):
        name = f"{index} {effect.strength}"
        if name not in names:
            continue
        place = names.index(name)
        if effect.values[str(effect.strength)] ** 2 >= enough * covariance[place, place]:
            continue
        without = fit(problem, fitted.model.without(index), steps=ALL_STEPS)
        own = Hypothesis(effect.identifier, fitted, prior_penalty(problem, effect))
        if own.beyond(Hypothesis("", without)) > -STRONG_EVIDENCE:
            found.add(index)
    return found
