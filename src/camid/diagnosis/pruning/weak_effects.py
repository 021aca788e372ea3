"""Effects that explain nothing any more beside the others, because something refined after them does it instead."""

from __future__ import annotations

from dataclasses import replace
from math import log

from camid.diagnosis.pruning.simplest_effects import without_effect
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.search.false_alarms import STRONG_EVIDENCE
from camid.diagnosis.search.hypothesis import Hypothesis, prior_penalty
from camid.diagnosis.watch import Watch
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


def without_faded(problem: Problem, decision: Decision, known: int, watch: Watch) -> Decision:
    """The decision without an effect that has no strong evidence any more, now that its model is fitted to the end.

    The search compares fits that end as soon as they can be ranked. Only an effect whose size, in standard deviations,
    would be none by itself (Wald's test) is left out to see what the others make of it.

    Parameters
    ----------
    problem : Problem
    decision : Decision
        One in another metric than that of least squares was put to the test in its own, and stays.
    known : int
        How many of the model's effects the nominal simulation holds already.
    watch : Watch

    Returns
    -------
    Decision
        The same where all effects hold; the others have to be put to the test again where one does not.
    """
    fitted = decision.fitted
    if fitted.weighted or watch.no_time_for("effects that the last fit has left without evidence", needed=True):
        return decision
    enough = STRONG_EVIDENCE + log(len(fitted.residual))
    for place, effect in enumerate(fitted.model.effects[known:]):
        name = f"{known + place} {effect.strength}"
        if name not in fitted.packing.names:
            continue
        number = fitted.packing.names.index(name)
        if effect.values[str(effect.strength)] ** 2 >= enough * fitted.covariance[number, number]:
            continue
        # What it did may be what the initial states do, which a fit from here need not find.
        again = problem.kind.refit(problem, fitted.model.without(known + place))
        without = min((again, decision.without[place]), key=lambda each: each.cost)
        own = Hypothesis(effect.identifier, fitted, prior_penalty(problem, effect))
        if own.beyond(Hypothesis("", without)) > -STRONG_EVIDENCE:
            left = [*decision.without[:place], without, *decision.without[place + 1 :]]
            return without_effect(problem, replace(decision, without=left), known, place, watch)
    return decision
