"""What rows that were not fitted say of the effects found: one that they speak against is not named.

The rows neither fit nor choose: no effect and no value is taken because of them. They judge by the ratio of the
predictive densities with an effect and without it, each fitted to the other rows (cross-validated predictive density;
Vehtari & Ojanen 2012, Statistics Surveys 6, 142–228).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.pruning.simplest_effects import without_effect
from camid.diagnosis.residual.residual_structure import FAILED_ERROR_RATIO
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.watch import Watch
from camid.fitting.fit import Fitted
from camid.fitting.problem import Problem

# Logarithm of the ratio of predictive densities against an effect from which it is not named: 150 to one.
REFUTED = 5.0


def borne_out(
    problem: Problem, decision: Decision, judging: Sequence[NDArray[np.bool_]], known: int, watch: Watch
) -> Decision:
    """The decision without effects that rows which were not fitted speak against, the one that they do most first.

    Parameters
    ----------
    problem : Problem
    decision : Decision
    judging : sequence of ndarray of bool
        Rows of each recording that are not fitted.
    known : int
        How many of the model's effects the nominal simulation holds already.
    watch : Watch
    """
    # That costs next to nothing, and what it refuses would be a wrong name.
    part = "holding the effects against rows that were not fitted"
    while decision.rivals and not watch.no_time_for(part, needed=True):
        fitted = decision.fitted
        evidence = [held_out_evidence(problem, fitted, without, judging) for without in decision.without]
        worst = int(np.argmin(evidence))
        # What inexact laws leave is no noise, and no density predicts it: there an effect has to fail altogether.
        coloured = len(fitted.noise.whitening) > 1
        if evidence[worst] >= -REFUTED or (coloured and not _fails(problem, decision, known, worst, judging)):
            break
        decision = without_effect(problem, decision, known, worst, watch)
    return decision


def _fails(problem: Problem, decision: Decision, known: int, index: int, judging: Sequence[NDArray[np.bool_]]) -> bool:
    """Whether squared errors on rows that were not fitted are some times larger with an effect than without it.

    What goes on with time, as a drift does, has nothing to it but that it goes on in these rows, too.
    """
    errors, others = (problem.errors(each.model, judging) for each in (decision.fitted, decision.without[index]))
    goes_on = decision.fitted.model.effects[known + index].of_one_recording
    return not float(errors @ errors) <= (1.0 if goes_on else FAILED_ERROR_RATIO) * float(others @ others)


def held_out_evidence(problem: Problem, fitted: Fitted, without: Fitted, judging: Sequence[NDArray[np.bool_]]) -> float:
    """Logarithm of the ratio of the densities that a model with an effect and one without predict for other rows.

    The noise is what the model with the effect leaves on the fitted rows; where that has a colour, a direction of the
    output in which it varies more says less, as in :meth:`camid.fitting.fit.Fitted.criterion_beyond`.
    """
    errors, others = (problem.errors(each.model, judging) for each in (fitted, without))
    if not np.all(np.isfinite(errors)):
        return -np.inf
    if not np.all(np.isfinite(others)):
        return np.inf
    variance = fitted.cost / max(len(fitted.residual) - len(fitted.packing.names), 1)
    ratio = float(others @ others - errors @ errors) / (2.0 * max(variance, 1e-300))
    return ratio / fitted.inflation(others - errors)
