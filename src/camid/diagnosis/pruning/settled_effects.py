"""The laws of the effects found, settled beside each other: what one lacks may show only when what hid it is found.

An effect that a finished fit has stretched to values that are not possible has become something else.
"""

from __future__ import annotations

from dataclasses import replace

from camid.diagnosis.pruning.simplest_effects import leaving_out, without_effect
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.search.false_alarms import STRONG_EVIDENCE
from camid.diagnosis.search.hypothesis import Hypothesis, in_order, prior_penalty
from camid.diagnosis.search.hypothesis_fit import implausible
from camid.diagnosis.search.settled_laws import plausible_in_place, settled_laws, under_their_names
from camid.diagnosis.watch import Watch
from camid.fitting.problem import Problem


def with_settled_laws(problem: Problem, decision: Decision, known: int, *, detailed: bool) -> Decision:
    """The decision with each law in the detail, and under the name, that the other effects call for.

    Parameters
    ----------
    problem : Problem
    decision : Decision
        In the metric of least squares.
    known : int
        How many of the model's effects the nominal simulation holds already.
    detailed : bool
        Whether they leave structure, which more detail may explain; otherwise names with fewer numbers are looked for
        alone.
    """
    fitted = (settled_laws if detailed else under_their_names)(problem, decision.fitted, known)
    if fitted is decision.fitted:
        return decision
    pairs = list(zip(decision.fitted.model.effects[known:], fitted.model.effects[known:], strict=True))
    alone = sum(before.identifier != effect.identifier for before, effect in pairs) == 1
    rivals = []
    for (before, effect), ranked in zip(pairs, decision.rivals, strict=True):
        if effect.identifier == before.identifier:
            rivals.append(ranked)
            continue
        own = Hypothesis(effect.identifier, fitted, prior_penalty(problem, effect))
        # What it was found as is a rival, where all else is the same.
        general = Hypothesis(before.identifier, decision.fitted, prior_penalty(problem, before))
        others = [h for h in ranked if h.identifier not in {before.identifier, effect.identifier}]
        rivals.append(in_order([own, *([general] if alone else []), *others]))
    return replace(decision, fitted=fitted, rivals=rivals)


def without_wandered(problem: Problem, decision: Decision, known: int, index: int, watch: Watch) -> Decision:
    """The decision with what an effect has become in its place, if that has strong evidence; else without it.

    Parameters
    ----------
    problem : Problem
    decision : Decision
    known : int
        How many of the model's effects the nominal simulation holds already.
    index : int
        Which of the effects found it is.
    watch : Watch
    """
    found = plausible_in_place(problem, decision.fitted, known + index)
    if found is None or found.beyond(Hypothesis("", decision.without[index])) > -STRONG_EVIDENCE:
        return without_effect(problem, decision, known, index, watch)
    fitted = settled_laws(problem, found.fitted, known)
    if implausible(problem, fitted.model):
        fitted = found.fitted
    own = Hypothesis(found.identifier, fitted, prior_penalty(problem, fitted.model.effects[known + index]))
    gone = {found.identifier, decision.fitted.model.effects[known + index].identifier}
    ranked = [own, *(h for h in decision.rivals[index] if h.identifier not in gone)]
    rivals = [*decision.rivals[:index], ranked, *decision.rivals[index + 1 :]]
    without = leaving_out(problem, decision.base, fitted, known, watch)
    return replace(decision, fitted=fitted, rivals=rivals, without=without)
