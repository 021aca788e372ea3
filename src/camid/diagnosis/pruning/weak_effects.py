"""Effects that explain nothing any more beside the others, because something refined after them does it instead."""

from __future__ import annotations

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
