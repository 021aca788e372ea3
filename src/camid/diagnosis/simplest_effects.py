"""The fewest and simplest effects, where what is left of the residual says that the laws are not exact anyway.

A likelihood takes every law as exact. With ten thousand samples of a real rig it then calls for a further effect, and a
further parameter, whatever small part of the true law they imitate. Where structure is left, an effect beside
others has to explain most of what the others leave, and a general law has to explain more than its special case by a
margin that justifies a name; else the name would be that of a correction. A correction that holds on rows that were not
fitted stays in the improved simulation all the same: it is modelled, and not named.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camid.diagnosis.effect_selection import LAW_ERROR, Decision
from camid.diagnosis.hypothesis import Hypothesis
from camid.diagnosis.hypothesis_search import ALL_STEPS, BESIDE_OTHERS, hypotheses
from camid.diagnosis.screening import Signatures, screen
from camid.diagnosis.watch import Watch
from camid.fitting.fit import Fitted, fit
from camid.fitting.problem import Problem

# Share of what the other effects leave, noise subtracted, that one beside them has to explain.
LEAST_EXPLAINED = 0.5
# Share of what a general law explains from which its special case takes its place.
SPECIAL_CASE_SHARE = 0.9


def simplest(
    problem: Problem, decision: Decision, known: int, structured: float, watch: Watch | None = None
) -> Decision:
    """The decision without effects that only correct others, and with special cases where they say as much.

    Parameters
    ----------
    problem : Problem
    decision : Decision
    known : int
        How many of the model's effects the nominal simulation holds already.
    structured : float
        Share of the residual's sum of squares that is structure.
    watch : Watch, optional
    """
    noise = (1.0 - min(structured, 1.0)) * decision.fitted.cost
    if watch and decision.rivals:
        watch.say("testing whether fewer and simpler effects say as much")
    while len(decision.rivals) > 1:
        gains = [w.cost - decision.fitted.cost for w in decision.without]
        weakest = int(np.argmin(gains))
        mismatch = max(decision.base.cost - noise, 1e-300)
        explained = _explained(decision.without[weakest], decision.fitted, noise)
        if explained >= LEAST_EXPLAINED and gains[weakest] >= LAW_ERROR * mismatch:
            break
        decision = _without(problem, decision, known, weakest)
    for index in range(len(decision.rivals)):
        decision = _special(problem, decision, known, index, noise)
    return decision


def corrected(problem: Problem, fitted: Fitted, signatures: Signatures, watch: Watch) -> Fitted | None:
    """The likeliest law beside the effects of a model that leaves some out; None where nothing corrects them.

    What depends on the time (a drift, a blow) corrects nothing: another recording would not have it.

    Parameters
    ----------
    problem : Problem
    fitted : Fitted
        What :func:`simplest` made of a decision, or that with a correction.
    signatures : Signatures
        Of earlier screenings.
    watch : Watch
    """
    watch.say("looking for a correction of the laws")
    # What an earlier search found beside the same effects may be crowded by what depends on the time.
    laws = screen(problem, fitted, signatures=signatures)
    laws = [c for c in laws if not c.effect.of_one_recording]
    found = hypotheses(problem, fitted, laws, effort=BESIDE_OTHERS, watch=watch)
    # What is left is structure, of which a correction has to take the most, whatever it costs in parameters.
    best = min((h.fitted for h in found), key=lambda f: f.cost, default=fitted)
    return best if best.cost < fitted.cost else None


def _explained(without: Fitted, fitted: Fitted, noise: float) -> float:
    """Share of what a model without an effect leaves, noise subtracted, that the effect explains."""
    return (without.cost - fitted.cost) / max(without.cost - noise, 1e-300)


def _without(problem: Problem, decision: Decision, known: int, index: int) -> Decision:
    """The decision without one of its effects."""
    rivals = decision.rivals[:index] + decision.rivals[index + 1 :]
    fitted = decision.without[index]
    without = _leaving_out(problem, decision.base, fitted, known)
    return replace(decision, fitted=fitted, rivals=rivals, without=without)


def _special(problem: Problem, decision: Decision, known: int, index: int, noise: float) -> Decision:
    """The decision with the special case of an effect in its place, if that explains nearly as much."""
    model = decision.fitted.model
    general = model.effects[known + index]
    special = general.simplified()
    if special is None or any(e.identifier == special.identifier for e in model.effects):
        return decision
    effects = list(model.effects)
    effects[known + index] = special
    fitted = fit(problem, replace(model, effects=tuple(effects)), steps=ALL_STEPS)
    without = decision.without[index]
    if without.cost <= fitted.cost:
        return decision
    mismatch = max(without.cost - noise, 1e-300)
    if without.cost - fitted.cost < SPECIAL_CASE_SHARE * min(without.cost - decision.fitted.cost, mismatch):
        return decision
    others = [h for h in decision.rivals[index] if h.identifier not in {special.identifier}]
    ranked = [Hypothesis(special.identifier, fitted), *others]
    rivals = [*decision.rivals[:index], ranked, *decision.rivals[index + 1 :]]
    return replace(decision, fitted=fitted, rivals=rivals, without=_leaving_out(problem, decision.base, fitted, known))


def _leaving_out(problem: Problem, base: Fitted, fitted: Fitted, known: int) -> list[Fitted]:
    """The model without each of its effects, fitted."""
    count = len(fitted.model.effects) - known
    if count == 1:
        return [base]
    return [_left_out(problem, base, fitted, known + i) for i in range(count)]


def _left_out(problem: Problem, base: Fitted, fitted: Fitted, index: int) -> Fitted:
    """The model without one effect, fitted from its own coefficients and from those of the base."""
    own = fitted.model.without(index)
    starts = [own, replace(own, coefficients=base.model.coefficients, initial=base.model.initial)]
    return min((fit(problem, start, steps=ALL_STEPS) for start in starts), key=lambda f: f.cost)
