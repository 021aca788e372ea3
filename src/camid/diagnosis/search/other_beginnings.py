"""The search for effects begun with other first ones, where what it ended in leaves structure.

A search that adds one effect at a time keeps the first one, and what resembles two laws together wins that place from
either: in a recording without an input a second mode beats in the place of gravity and drag. Tests of what could
replace it come too late, beside effects that were found for its sake. So the search is begun again with the likeliest
of the others (a beam of a few, as in Miller 2002, Subset Selection in Regression, section 3.10).
"""

from __future__ import annotations

from collections.abc import Callable

from camid.diagnosis.search.effect_selection import SWAP_MARGIN, Decision, Searches, select_effects
from camid.diagnosis.search.hypothesis import Hypothesis
from camid.diagnosis.watch import NAMES, Watch
from camid.fitting.problem import Problem

# Other first effects, and the share of the mismatch that one has to explain.
MOST_BEGINNINGS, LEAST_EXPLAINED = 2, 0.5


def with_other_beginnings(
    problem: Problem,
    decision: Decision,
    searches: Searches,
    watch: Watch,
    leaves_structure: Callable[[Decision], bool],
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

    Returns
    -------
    Decision
        The same where it leaves noise, or where a law of it seems inexact, which is learned.
    """
    if decision.interrupted or not decision.rivals:
        return decision
    if not (_may_be_imitated(problem, decision) or leaves_structure(decision)):
        return decision
    first = searches.beside(decision.base) or []
    for beginning in _other_beginnings(decision, first):
        watch.take_stock(NAMES)
        if watch.no_time_for(f"a search that begins with {beginning.identifier}"):
            break
        begun = Decision(decision.base, beginning.fitted, [first], [decision.base])
        other = select_effects(problem, decision.base, watch=watch, searches=searches, begun=begun)
        if decision.fitted.criterion_beyond(other.fitted) > SWAP_MARGIN:
            decision = other
            if not leaves_structure(decision):
                break
    return decision


def _may_be_imitated(problem: Problem, decision: Decision) -> bool:
    """Whether some effects together may do what others do: without an input no phase is set right again."""
    return problem.kind.phases_add_up and len(decision.rivals) > 1


def _other_beginnings(decision: Decision, first: list[Hypothesis]) -> list[Hypothesis]:
    """The likeliest hypotheses beside the base that explain much of the mismatch and are not in the decision."""
    present = {effect.identifier for effect in decision.fitted.model.effects}
    most = (1.0 - LEAST_EXPLAINED) * decision.base.cost
    others = [h for h in first if h.identifier not in present and h.fitted.cost <= most]
    return others[:MOST_BEGINNINGS]
