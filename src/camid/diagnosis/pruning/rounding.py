"""Effects that explain what rounding does: it errs by the same as long as a reading keeps its value, as no noise does.

Where most of what is left is rounding to a lattice, models are compared by the likelihood of readings that are rounded:
each says between which values the output lay, noise included (Gustafsson & Karlsson 2009, Automatica 45, 2794-2801).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.pruning.simplest_effects import leaving_out, without_effect
from camid.diagnosis.residual.noise_recognition import MOSTLY_ROUNDING
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.search.false_alarms import STRONG_EVIDENCE
from camid.diagnosis.search.hypothesis import Hypothesis, prior_penalty
from camid.diagnosis.search.hypothesis_fit import ALL_STEPS
from camid.diagnosis.watch import Watch
from camid.effects.base import Effect
from camid.effects.noise import Quantisation
from camid.effects.special_cases import special_case
from camid.fitting.fit import Fitted, fit
from camid.fitting.problem import Problem

Array = NDArray[np.float64]

# Noise before the rounding, as shares of the step, that is tried.
SHARES_OF_STEP = np.geomspace(0.01, 1.0, 25)
# How far the logarithm of the likelihood of a reading lies below zero, on average, up to which what is left is rounding
# and hardly any noise.
ROUNDING_ALONE = 0.2
# Names in the place of an effect that are compared anew.
MOST_RIVALS = 4


def lattice_of(problem: Problem, fitted: Fitted) -> float:
    """Step to which readings are rounded, where that is most of what a model leaves; zero where it is not.

    Parameters
    ----------
    problem : Problem
    fitted : Fitted
    """
    situation = problem.situation(fitted.model)
    if situation.controlled or problem.relative_noise is not None:
        return 0.0  # what is compared is no reading, or in other units
    found = Quantisation.recognise(situation)
    step = 0.0 if found is None else float(found.effect.values["step"])
    return step if step**2 / 12.0 > MOSTLY_ROUNDING * float(np.mean(fitted.residual**2)) else 0.0


def log_likelihood(residual: Array, step: float) -> float:
    """Of readings, shape (N,), that are rounded to a step and miss a model by a residual, with the likeliest noise."""
    from scipy.special import log_ndtr, ndtr

    def of(share: float) -> float:
        low, high = (residual - 0.5 * step) / (share * step), (residual + 0.5 * step) / (share * step)
        inside = ndtr(high) - ndtr(low)
        # Far off, both are one or both are zero.
        far = log_ndtr(-np.abs(residual) / (share * step) + 0.5 / share)
        return float(np.sum(np.where(inside > 1e-12, np.log(np.maximum(inside, 1e-300)), far)))

    return max(of(share) for share in SHARES_OF_STEP)


def is_rounding_alone(problem: Problem, fitted: Fitted) -> bool:
    """Whether nearly all that a model leaves is rounding, whatever structure that has.

    Parameters
    ----------
    problem : Problem
    fitted : Fitted
    """
    step = lattice_of(problem, fitted)
    residual = fitted.residual
    return step > 0.0 and log_likelihood(residual, step) > -ROUNDING_ALONE * len(residual)


def beyond_rounding(problem: Problem, decision: Decision, known: int, watch: Watch) -> Decision:
    """The decision without effects that explain nothing of the readings but their rounding, the weakest first.

    What is left has the likeliest name of those in its place, and weights as the rounded readings give them.

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
        step = lattice_of(problem, decision.fitted)
        if step == 0.0:
            return decision
        effects = decision.fitted.model.effects[known:]
        own = [_price(problem, e, decision.fitted, step) for e in effects]
        left = [-2.0 * log_likelihood(without.residual, step) for without in decision.without]
        evidence = [without - price for without, price in zip(left, own, strict=True)]
        weakest = int(np.argmin(evidence))
        if evidence[weakest] >= STRONG_EVIDENCE:
            break
        decision = without_effect(problem, decision, known, weakest, watch)
    for index in range(len(decision.rivals)):
        decision = _ranked(problem, decision, known, index, step, watch)
    return decision


def _price(problem: Problem, effect: Effect, fitted: Fitted, step: float) -> float:
    """Bayes's criterion of a fit with an effect, for rounded readings, but for what does not depend on the effect."""
    count = len(effect.numeric()) * float(np.log(len(fitted.residual)))
    return count + prior_penalty(problem, effect) - 2.0 * log_likelihood(fitted.residual, step)


def _ranked(problem: Problem, decision: Decision, known: int, index: int, step: float, watch: Watch) -> Decision:
    """The decision with the likeliest of an effect's names for rounded readings, each fitted beside the others."""
    place, model = known + index, decision.fitted.model
    own = model.effects[place]
    likely = [e for h in decision.rivals[index][:MOST_RIVALS] if (e := h.effect) is not None]
    special = special_case(own)
    others = {e.identifier: e for e in (*likely, *([] if special is None else [special]))}
    taken = {e.identifier for e in model.effects}
    tried = [e for e in others.values() if e.identifier not in taken]
    fits = [decision.fitted, *(fit(problem, model.replaced(place, e), steps=ALL_STEPS) for e in tried)]
    found = [(_price(problem, f.model.effects[place], f, step), f) for f in fits]
    found = sorted((pair for pair in found if np.isfinite(pair[1].cost)), key=lambda pair: pair[0])
    (least, best), rivals = found[0], []
    for price, fitted in found:
        # A penalty that makes up for what the white noise of the other criterion says otherwise.
        penalty = price - least - fitted.criterion_beyond(best)
        rivals.append(Hypothesis(fitted.model.effects[place].identifier, fitted, penalty))
    without = decision.without
    if best is not decision.fitted:
        without = leaving_out(problem, decision.base, best, known, watch)
    ranked = [*decision.rivals[:index], rivals, *decision.rivals[index + 1 :]]
    return replace(decision, fitted=best, rivals=ranked, without=without)
