"""The search for effects begun with other first ones, where what it ended in leaves structure.

A search that adds one effect at a time keeps the first one, and what resembles two laws together wins that place from
either: in a recording without an input a second mode beats in the place of gravity and drag. Tests of what could
replace it come too late, beside effects that were found for its sake. So the search is begun again with the likeliest
of the others (a beam of a few, as in Miller 2002, Subset Selection in Regression, section 3.10).

Where far more is left than laws leave that are not exact, two effects may hide each other, so that neither explains
much alone: friction beside a saturation, in a loop. Then the search begins with those beside which a second effect
would leave least.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from camid.diagnosis.search.beginnings_in_a_loop import Beginning
from camid.diagnosis.search.decision import Decision, Searches
from camid.diagnosis.search.forward_selection import LAW_ERROR, with_added_effects
from camid.diagnosis.search.hypothesis import Hypothesis, prior_penalty
from camid.diagnosis.search.screening import ScreenedEffect, screen
from camid.diagnosis.watch import NAMES, Watch
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem

# What a search begins with, and what was screened beside it already.
ScreenedDecision = tuple[Decision, list[ScreenedEffect] | None]

# By how much the criterion of what takes the place of something has to be lower.
SWAP_MARGIN = 2.0
# Other first effects, and the share of the mismatch that one has to explain.
MOST_BEGINNINGS, LEAST_EXPLAINED = 2, 0.3
# Beginnings of which is looked at what another effect would leave, and the share of the work that may be done by then.
MOST_LOOKED_AT, LOOKED_AT = 8, 0.45
# Error, as a share of the output's spread, from which a motion without an input may be out of phase.
OUT_OF_PHASE = 0.005


def with_other_beginnings(
    problem: Problem,
    decision: Decision,
    searches: Searches,
    watch: Watch,
    leaves_structure: Callable[[Decision], bool],
    nominal: Model | None = None,
) -> Decision:
    """The likeliest of a decision and those that searches from other first effects end in.

    Parameters
    ----------
    problem : Problem
    decision : Decision
    searches : Searches
        What was found beside the decision's base.
    watch : Watch
    leaves_structure : callable
        Whether a decision's effects leave more than noise.
    nominal : Model, optional
        Where phases add up and structure is left all the same, what is added to the first effects is followed from
        these coefficients, too.

    Returns
    -------
    Decision
        The same where it leaves noise, or where a law of it seems inexact, which is learned; but not without an input,
        where other effects may seem so, nor where more is left than inexact laws leave.
    """
    over_time = problem.kind.phases_add_up
    if not decision.rivals or (decision.interrupted and not over_time and not _leaves_much(decision)):
        return decision
    several = over_time and len(decision.rivals) > 1
    if not (several or leaves_structure(decision)):
        return decision
    much = not over_time and _leaves_much(decision)
    for start, beginnings in _passes(problem, decision, searches, watch, nominal if over_time else None, much=much):
        if start is not None and not _is_out_of_phase(problem, decision):
            break
        for beginning, screened in beginnings:
            watch.take_stock(NAMES)
            names = " and ".join(
                e.identifier for e in beginning.fitted.model.effects[len(decision.base.model.effects) :]
            )
            if watch.no_time_for(f"a search that begins with {names}"):
                return decision
            other = with_added_effects(problem, decision.base, searches, watch, screened, start, Beginning(beginning))
            if len(other.rivals) < 2 or not _is_likelier(problem, other, decision):  # alone they were ranked already
                continue
            if not leaves_structure(other):
                return other
            if _is_likelier(problem, _first_two(other), _first_two(decision)):
                decision = other
            if much and not _leaves_much(decision):
                return decision
        if not leaves_structure(decision):
            break
    return decision


def _passes(
    problem: Problem, decision: Decision, searches: Searches, watch: Watch, nominal: Model | None, *, much: bool
) -> list[tuple[Model | None, list[ScreenedDecision]]]:
    """What searches begin with, and from which coefficients what they add is followed, too."""
    first = searches.beside(decision.base) or []

    def begun(hypothesis: Hypothesis) -> ScreenedDecision:
        found = Decision(decision.base, hypothesis.fitted, [first], [decision.base])
        # Two effects that hide each other leave more of a mismatch than laws do that are not exact.
        return replace(found, interrupted=much or _leaves_much(found)), None

    others = [begun(hypothesis) for hypothesis in _other_beginnings(decision, first)]
    if much:
        own = [decision] if decision.interrupted else []
        return [(None, _promising(problem, [*own, *(other for other, _ in others)], watch))]
    passes: list[tuple[Model | None, list[ScreenedDecision]]] = [(None, others[:MOST_BEGINNINGS])]
    if nominal is not None:
        passes.append((nominal, [*map(begun, decision.rivals[0][:1]), *others[:MOST_BEGINNINGS]]))
    return passes


def _leaves_much(decision: Decision) -> bool:
    """Whether more of the mismatch is left than laws leave that are not exact, both without the noise."""
    fitted = decision.fitted
    # What the past of a residual does not tell is noise, or too little to matter.
    innovations = fitted.problem.whitened(fitted.residual, fitted.noise.whitening)
    noise = min(float(innovations @ innovations), fitted.cost)
    return fitted.cost - noise > LAW_ERROR * (decision.base.cost - noise)


def _is_out_of_phase(problem: Problem, decision: Decision) -> bool:
    """Whether so much is left that the motion is not followed."""
    count = len(decision.fitted.residual)
    return decision.fitted.cost >= OUT_OF_PHASE**2 * float(np.var(problem.recorded)) * count


def _is_likelier(problem: Problem, decision: Decision, than: Decision) -> bool:
    """Whether all effects of a decision together are likelier than those of another one, by as much as a swap asks."""
    return _whole(problem, than).beyond(_whole(problem, decision)) > SWAP_MARGIN


def _first_two(decision: Decision) -> Decision:
    """A decision before its third effect: where structure is left, further ones correct laws that are not exact."""
    return decision if len(decision.rivals) < 3 else replace(decision, fitted=decision.rivals[1][0].fitted)


def _whole(problem: Problem, decision: Decision) -> Hypothesis:
    """All effects of a decision as one hypothesis."""
    added = decision.fitted.model.effects[len(decision.base.model.effects) :]
    return Hypothesis("", decision.fitted, sum(prior_penalty(problem, effect) for effect in added))


def _other_beginnings(decision: Decision, first: list[Hypothesis]) -> list[Hypothesis]:
    """The hypotheses beside the base that explain much of the mismatch and are not in the decision, in order."""
    present = {effect.identifier for effect in decision.fitted.model.effects}
    most = (1.0 - LEAST_EXPLAINED) * decision.base.cost
    return [h for h in first if h.identifier not in present and h.fitted.cost <= most]


def _promising(problem: Problem, others: list[Decision], watch: Watch) -> list[ScreenedDecision]:
    """The beginnings beside which another effect would leave least, to first order."""
    looked_at: list[tuple[float, ScreenedDecision]] = []
    for other in others[:MOST_LOOKED_AT]:
        if len(looked_at) >= MOST_BEGINNINGS and watch.has_done(LOOKED_AT):
            break
        screened = screen(problem, other.fitted)
        gain = screened[0].gain / len(other.fitted.residual) if screened else 0.0
        looked_at.append((other.fitted.cost / (1.0 + gain), (other, screened)))
    return [beginning for _, beginning in sorted(looked_at, key=lambda each: each[0])[:MOST_BEGINNINGS]]
