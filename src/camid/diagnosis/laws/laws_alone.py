"""Laws without a name in the place of all names, where what names and learned laws leave is structure.

A name that only resembles a law bends everything that is found beside it: what is searched for next, the curve that is
learned, and the coefficients. Where that ends in structure, the search is repeated without names, and the better of the
two accounts is kept.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.evidence import simulated_error
from camid.diagnosis.laws.formula.account import with_formulas
from camid.diagnosis.laws.learned_laws import structure_left, with_laws_alone
from camid.diagnosis.learned_part import LearnedPart
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.watch import Watch
from camid.fitting.problem import Problem
from camid.simulation.declared_units import IN_U_AND_Y, DeclaredUnits


def with_laws(
    problem: Problem,
    decision: Decision,
    judging: Sequence[NDArray[np.bool_]],
    known: int,
    watch: Watch,
    units: DeclaredUnits = IN_U_AND_Y,
) -> tuple[Decision, list[LearnedPart]]:
    """The decision with formulas for its laws, or laws alone where names are no better than these.

    Parameters
    ----------
    problem : Problem
    decision : Decision
        Which may leave structure.
    judging : sequence of ndarray of bool
        Rows of each recording that are not fitted.
    known : int
        How many of the model's effects the nominal simulation holds already.
    watch : Watch
    units : DeclaredUnits
        Of the words.
    """
    found = with_formulas(problem, decision, judging, known, watch, units)
    if not found[0].rivals or structure_left(problem, found[0]) == 0.0:
        return found
    watch.take_stock()
    if watch.no_time_for("laws without a name in the place of all names"):
        return found
    alone = with_laws_alone(problem, decision.base, judging, watch)
    if not alone.laws:
        return found
    other = with_formulas(problem, alone, judging, known, watch, units)
    return other if _is_better(problem, other[0], found[0], judging) else found


def _is_better(problem: Problem, alone: Decision, named: Decision, judging: Sequence[NDArray[np.bool_]]) -> bool:
    """Whether laws alone leave only noise, are at least as likely, and err no more on rows that were not fitted."""
    if structure_left(problem, alone) > 0.0 or log_evidence(alone) < log_evidence(named):
        return False
    errors = [simulated_error(problem, each.improved.model, judging) for each in (alone, named)]
    return errors[0] <= errors[1]


def log_evidence(decision: Decision) -> float:
    """Logarithm of the evidence for a decision's names and laws against none of them."""
    total = -0.5 * decision.fitted.criterion_beyond(decision.base)
    before = decision.fitted
    for law in decision.laws:
        total += law.gain_on(before)
        before = law.fitted
    return total
