"""Laws without a name, where those of the catalogue leave structure; and the effects that show only beside them.

A law of the catalogue that is not exact leaves structure that hides weaker effects, and that a likelihood would rather
give to any of them than leave. A learned law takes it up: a curve over position, velocity, input or reading, whichever
has most evidence. What is left beside it is searched again, with all that the curve could do projected out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.evidence import simulated_error
from camid.diagnosis.pruning.simplest_effects import LEAST_EXPLAINED, leaving_out
from camid.diagnosis.residual.mismatch_location import places
from camid.diagnosis.residual.residual_structure import STRUCTURE_P_VALUE
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.search.false_alarms import FALSE_ALARM_BESIDE_OTHERS, chance, p_value
from camid.diagnosis.search.hypothesis import Hypothesis
from camid.diagnosis.search.hypothesis_fit import ALL_STEPS
from camid.diagnosis.search.hypothesis_search import BESIDE_OTHERS, hypotheses
from camid.diagnosis.search.inexact_laws import LEAST_EVIDENCE
from camid.diagnosis.search.screening import screen
from camid.diagnosis.watch import LAWS, NAMES, OVERTIME, Watch
from camid.effects.learned import LearnedEffect
from camid.fitting.fit import Fitted, fit
from camid.fitting.learned_law import LearnedLaw, judged_to_first_order, learn
from camid.fitting.possible_laws import blank_laws
from camid.fitting.problem import Problem
from camid.side_by_side import side_by_side

# Laws that are fitted, of those that first order says are likeliest, and how much less evidence they may have there.
MOST_FITTED = 2
GAP = 0.1
# Share of the best one's evidence from which another law, on few knots, may be the better one on more.
TIE = 0.7
# How often the knots may be doubled, and the gain of log evidence that each time has to bring.
MOST_REFINED = 2
LEAST_GAIN = 1.0
# Share of the refitted sum of squares that named effects may leave for the coefficients to keep their values.
LEAST_LEFT = 0.1
# Effects that are looked for beside the learned laws.
MOST_BESIDE = 2


def with_learned_laws(
    problem: Problem, decision: Decision, judging: Sequence[NDArray[np.bool_]], known: int, watch: Watch
) -> Decision:
    """The decision with learned laws, and with effects of the catalogue beside them where only noise is left then.

    A curve that follows the fitted rows and errs more on others than the model without it is no law.

    Parameters
    ----------
    problem : Problem
    decision : Decision
        Which leaves structure.
    judging : sequence of ndarray of bool
        Rows of each recording that are not fitted.
    known : int
        How many of the model's effects the nominal simulation holds already.
    watch : Watch
    """

    def holds(found: Decision, before: Decision) -> bool:
        return _errs_less(problem, found, before, judging)

    begun = watch.done
    first = _with_another_law(problem, decision, holds, watch)
    if first is decision:
        return decision
    work = watch.done - begun
    left = structure_left(problem, first)
    if left == 0.0:
        return first
    # Where no name completes the account, it would only stand for a part of what no curve carries.
    complete = first
    for _ in range(MOST_BESIDE):
        found = _with_effect_beside(problem, complete, left, known, watch)
        if found is None:
            break
        complete, left = found, structure_left(problem, found)
        if left == 0.0 and holds(complete, first):
            return complete
    return _with_another_law(problem, first, holds, watch, work)


def with_laws_alone(problem: Problem, base: Fitted, judging: Sequence[NDArray[np.bool_]], watch: Watch) -> Decision:
    """Laws without a name alone beside the coefficients, up to two; none where they err more on rows not fitted."""

    def holds(found: Decision, before: Decision) -> bool:
        return _errs_less(problem, found, before, judging)

    begun = watch.done
    first = _with_another_law(problem, Decision(base, base), holds, watch)
    if not first.laws or structure_left(problem, first) == 0.0:
        return first
    return _with_another_law(problem, first, holds, watch, watch.done - begun)


def _errs_less(problem: Problem, found: Decision, before: Decision, judging: Sequence[NDArray[np.bool_]]) -> bool:
    """Whether a decision errs less than another on rows that were not fitted."""
    errors = [simulated_error(problem, d.improved.model, judging) for d in (found, before)]
    return errors[0] < errors[1]


def structure_left(problem: Problem, decision: Decision) -> float:
    """Share of what a decision leaves that a fault at some place explains; zero where that may be chance."""
    left = places(problem, decision.improved)
    return max((test.share for test in left if test.p_value < STRUCTURE_P_VALUE), default=0.0)


def _with_another_law(
    problem: Problem,
    decision: Decision,
    holds: Callable[[Decision, Decision], bool],
    watch: Watch,
    ahead: float = 0.0,
) -> Decision:
    """The decision with the likeliest law beside it; the same where none has enough evidence, or it does not hold.

    ``ahead`` is the work that it may take: that of the law before it.
    """
    watch.take_stock(LAWS, ahead)
    # A first law is most of what a simulation lacks whose names are not exact.
    part = "another law without a name" if decision.laws else "a law without a name"
    if watch.no_time_for(part, needed=not decision.laws):
        return decision
    watch.say("learning a law without a name")
    coefficients = _coefficients_hold(decision)
    begun = watch.done
    laws = _likeliest(problem, decision.improved, coefficients)
    work = watch.done - begun
    found = [_refined(problem, decision, law, holds, watch, work) for law in laws]
    for law in sorted(found, key=lambda each: -each.gain_on(decision.improved)):
        best = replace(decision, laws=(*decision.laws, law))
        if holds(best, decision):
            return best
    return decision


def _refined(
    problem: Problem,
    decision: Decision,
    law: LearnedLaw,
    holds: Callable[[Decision, Decision], bool],
    watch: Watch,
    work: float,
) -> LearnedLaw:
    """A law on as many knots as it has evidence for and holds with; ``work`` is what one of them may take."""
    before, coefficients = decision.improved, _coefficients_hold(decision)

    def with_it(law: LearnedLaw) -> Decision:
        return replace(decision, laws=(*decision.laws, law))

    held = law
    for _ in range(MOST_REFINED):
        # What is narrower than the knots are apart shows as structure, or gives what is left a colour: the tests have
        # no finer curves. A law that is half learned says little, whatever was done before.
        watch.take_stock(OVERTIME, work)
        white = len(law.fitted.noise.whitening) == 1
        if (white and structure_left(problem, with_it(law)) == 0.0) or watch.no_time_for("a law on more knots"):
            break
        finer = _on_more_knots(problem, before, law, coefficients)
        if finer is None or finer.gain_on(before) < law.gain_on(before) + LEAST_GAIN:
            break
        law = finer
        # On the way to enough of them more knots may err more.
        held = law if holds(with_it(law), with_it(held)) else held
    return held


def _coefficients_hold(decision: Decision) -> bool:
    """Whether named effects explain so much that the coefficients beside them are not bent by what they leave."""
    return bool(decision.rivals) and decision.fitted.cost <= LEAST_LEFT * decision.base.cost


def _likeliest(problem: Problem, fitted: Fitted, coefficients: bool) -> list[LearnedLaw]:
    """The laws of most evidence beside a model, the best first, and what may be as good on more knots."""
    blank = blank_laws(problem, fitted)
    gains = judged_to_first_order(problem, fitted, blank, coefficients=coefficients)
    ordered = sorted(gains, key=lambda name: -gains[name])
    if not ordered or gains[ordered[0]] < LEAST_EVIDENCE:
        return []
    likely = [name for name in ordered[:MOST_FITTED] if gains[name] >= (1.0 - GAP) * gains[ordered[0]]]
    learned = partial(_learned, problem, fitted, coefficients=coefficients)
    found = [law for law in side_by_side(learned, [blank[name] for name in likely]) if law is not None]
    found.sort(key=lambda law: -law.gain_on(fitted))
    best = found[0].gain_on(fitted) if found else 0.0
    white = bool(found) and len(found[0].fitted.noise.whitening) == 1
    return (
        [] if best < LEAST_EVIDENCE else [law for law in found if law.gain_on(fitted) >= (1.0 if white else TIE) * best]
    )


def _on_more_knots(problem: Problem, before: Fitted, coarser: LearnedLaw, coefficients: bool) -> LearnedLaw | None:
    """The law on twice as many knots: begun from the coarser one, and from none, as either may end too early."""
    learned = partial(_learned, problem, before, coarser.law.refined(), coefficients)
    found = [law for law in side_by_side(learned, [coarser, None]) if law is not None]
    return max(found, key=lambda law: law.gain_on(before), default=None)


def _learned(
    problem: Problem, fitted: Fitted, law: LearnedEffect, coefficients: bool, coarser: LearnedLaw | None = None
) -> LearnedLaw | None:
    try:
        return learn(problem, fitted, law, coefficients=coefficients, coarser=coarser)
    except (ValueError, ArithmeticError):
        return None


def _with_effect_beside(
    problem: Problem, decision: Decision, structured: float, known: int, watch: Watch
) -> Decision | None:
    """The decision with an effect that explains most of what learned laws leave, and the laws beside it, if any hold.

    ``structured`` is the share of what they leave that is no noise.
    """
    watch.take_stock(NAMES)
    if watch.no_time_for("an effect beside a law without a name"):
        return None
    watch.say("looking for an effect beside a law without a name")
    ranked = _called_for(problem, decision.improved, watch)
    if not ranked:
        return None
    effect = ranked[0].fitted.model.effects[-1]
    fitted = fit(problem, decision.fitted.model.plus(effect), steps=ALL_STEPS)
    laws = relearned(problem, fitted, decision.laws, decision)
    before, after = decision.improved.cost, (laws[-1].fitted if laws else fitted).cost
    if before - after < LEAST_EXPLAINED * structured * before:
        return None
    return replace(
        decision,
        fitted=fitted,
        rivals=[*decision.rivals, ranked],
        without=leaving_out(problem, decision.base, fitted, known, watch),
        laws=laws,
        certain=decision.certain | {effect.identifier},
    )


def _called_for(problem: Problem, fitted: Fitted, watch: Watch) -> list[Hypothesis]:
    """Effects beside learned laws, the likeliest first; none where chance, or another curve, explains as much."""
    screened = [
        c for c in screen(problem, fitted) if chance(problem, c.effect.identifier, c.gain) < FALSE_ALARM_BESIDE_OTHERS
    ]
    found = hypotheses(problem, fitted, screened, effort=BESIDE_OTHERS, watch=watch)
    found = [h for h in found if h.beyond(Hypothesis("", fitted)) < 0.0]
    if not found or p_value(problem, fitted, found[0].fitted, found[0].identifier) >= FALSE_ALARM_BESIDE_OTHERS:
        return []
    return found


def relearned(
    problem: Problem, fitted: Fitted, laws: Sequence[LearnedLaw], decision: Decision
) -> tuple[LearnedLaw, ...]:
    """The same laws learned again, one after the other, beside another model; those that still have evidence."""
    coefficients = _coefficients_hold(decision)
    found: tuple[LearnedLaw, ...] = ()
    for law in laws:
        again = _learned(problem, found[-1].fitted if found else fitted, law.law.blank(), coefficients)
        if again is not None and again.log_evidence - again.without >= LEAST_EVIDENCE:
            found = (*found, again)
    return found
