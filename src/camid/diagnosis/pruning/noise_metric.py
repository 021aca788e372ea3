"""Decisions in the metric of coloured noise, and back in that of least squares."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.search.decision import Decision
from camid.diagnosis.search.false_alarms import FALSE_ALARM, STRONG_EVIDENCE, chance
from camid.diagnosis.search.forward_selection import MOST_EFFECTS
from camid.diagnosis.search.hypothesis import prior_penalty
from camid.diagnosis.search.hypothesis_fit import ALL_STEPS
from camid.fitting.fit import Fitted, fit
from camid.fitting.problem import Problem

Array = NDArray[np.float64]


def in_noise_metric(problem: Problem, decision: Decision, known: int) -> Decision:
    """The decision's model refitted in the metric of its noise, if that is coloured, and without what it refutes.

    Parameters
    ----------
    problem : Problem
    decision : Decision
    known : int
        How many effects the simulation declares already.
    """
    for _ in range(MOST_EFFECTS + 1):
        final = decision.fitted
        whitening = final.noise.whitening
        if len(whitening) == 1:
            return decision
        again = fit(problem, final.model, steps=15, whitening=whitening)
        cost = _whitened_cost(problem, again, whitening)
        refuted = None
        for i, effect in enumerate(again.model.effects[known:]):
            without = fit(problem, again.model.without(known + i), steps=15, whitening=whitening)
            ratio = len(again.residual) * float(np.log(_whitened_cost(problem, without, whitening) / cost))
            freedom = len(effect.numeric()) * float(np.log(len(again.residual)))
            weak = ratio - freedom - prior_penalty(problem, effect) < STRONG_EVIDENCE
            if weak or chance(problem, effect.identifier, ratio) >= FALSE_ALARM:
                refuted = i, without
        if refuted is None:
            return replace(decision, fitted=again)
        index, fitted = refuted
        decision = replace(
            decision,
            fitted=fitted,
            rivals=decision.rivals[:index] + decision.rivals[index + 1 :],
            without=[
                fit(problem, fitted.model.without(known + i), steps=15, whitening=whitening)
                for i in range(len(decision.without) - 1)
            ],
        )
        if not decision.rivals:
            return replace(decision, fitted=decision.base)
    return decision


def in_least_squares(problem: Problem, decision: Decision) -> Decision:
    """The decision with the estimate of least squares.

    What the laws leave is not noise, and its spectrum no reason to trust some frequencies more than others: a filter
    that whitens it would give the weight to those at which the model is wrong by little because little happens there.
    """
    if not decision.fitted.weighted:
        return decision
    return replace(decision, fitted=fit(problem, decision.fitted.model, steps=ALL_STEPS))


def _whitened_cost(problem: Problem, fitted: Fitted, whitening: Array) -> float:
    innovations = problem.whitened(fitted.residual, whitening)
    return max(float(innovations @ innovations), 1e-300)
