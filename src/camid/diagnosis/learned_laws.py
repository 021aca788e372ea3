"""Laws without a name, where those of the catalogue leave structure; and the effects that show only beside them.

A law of the catalogue that is not exact leaves structure that hides weaker effects, and that a likelihood would rather
give to any of them than leave. A learned law takes it up: a curve over position, velocity, input or reading, whichever
has most evidence. What is left beside it is searched again, with all that the curve could do projected out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from camid.diagnosis.effect_selection import FALSE_ALARM_BESIDE_OTHERS, Decision, chance, p_value
from camid.diagnosis.hypothesis import Hypothesis
from camid.diagnosis.hypothesis_search import ALL_STEPS, BESIDE_OTHERS, hypotheses
from camid.diagnosis.mismatch_location import places
from camid.diagnosis.residual_structure import STRUCTURE_P_VALUE
from camid.diagnosis.screening import screen
from camid.diagnosis.simplest_effects import LEAST_EXPLAINED, leaving_out
from camid.diagnosis.watch import Watch
from camid.effects.learned import LearnedEffect
from camid.fitting.fit import Fitted, fit
from camid.fitting.learned_law import LearnedLaw, blank_laws, learn
from camid.fitting.problem import Problem

# Natural logarithm of the evidence for a law against none from which it is learned: a thousand and more to one, beyond
# the choice among four.
LEAST_EVIDENCE = 10.0
MOST_LAWS = 2
# Laws that are fitted, of those that first order says are likeliest, and how much less evidence they may have there.
MOST_FITTED = 2
GAP = 0.5
# Effects that are looked for beside the learned laws.
MOST_BESIDE = 2


def with_learned_laws(problem: Problem, decision: Decision, known: int, watch: Watch) -> Decision:
    """The decision with learned laws, and with effects of the catalogue that show beside them.

    Parameters
    ----------
    problem : Problem
    decision : Decision
        Which leaves structure.
    known : int
        How many of the model's effects the nominal simulation holds already.
    watch : Watch
    """
    laws: tuple[LearnedLaw, ...] = ()
    for _ in range(MOST_LAWS + MOST_BESIDE):
        if watch.no_time_for("a law without a name"):
            break
        if laws:
            left = [t.share for t in places(problem, laws[-1].fitted) if t.p_value < STRUCTURE_P_VALUE]
            if not left:
                break
            found = _with_effect_beside(problem, decision, laws, max(left), known, watch)
            if found is not None:
                decision, laws = found
                continue
        watch.say("learning a law without a name")
        law = _likeliest(problem, laws[-1].fitted if laws else decision.fitted) if len(laws) < MOST_LAWS else None
        if law is None:
            break
        laws = (*laws, law)
    return replace(decision, laws=laws)


def _likeliest(problem: Problem, fitted: Fitted) -> LearnedLaw | None:
    """The law of most evidence beside a model; None where none has enough."""
    first = {name: _learned(problem, fitted, law, 0) for name, law in blank_laws(problem, fitted).items()}
    judged = {name: law for name, law in first.items() if law is not None}
    if not judged:
        return None
    gains = {name: law.log_evidence - law.without for name, law in judged.items()}
    without = next(iter(judged.values())).without
    ordered = sorted(gains, key=lambda name: -gains[name])
    likely = [name for name in ordered[:MOST_FITTED] if gains[name] >= (1.0 - GAP) * gains[ordered[0]]]
    if gains[ordered[0]] < LEAST_EVIDENCE:
        return None
    found = [_learned(problem, fitted, judged[name].law) for name in likely]
    best = max((law for law in found if law is not None), key=lambda law: law.log_evidence, default=None)
    if best is None:
        return None
    # Where the noise has a colour, or more than this law is missing, a direction in which it varies more says less.
    inflation = best.fitted.inflation(fitted.residual - best.fitted.residual)
    return best if (best.log_evidence - without) / inflation >= LEAST_EVIDENCE else None


def _learned(problem: Problem, fitted: Fitted, law: LearnedEffect, rounds: int | None = None) -> LearnedLaw | None:
    try:
        return learn(problem, fitted, law) if rounds is None else learn(problem, fitted, law, rounds)
    except (ValueError, ArithmeticError):
        return None


def _with_effect_beside(
    problem: Problem,
    decision: Decision,
    laws: tuple[LearnedLaw, ...],
    structured: float,
    known: int,
    watch: Watch,
) -> tuple[Decision, tuple[LearnedLaw, ...]] | None:
    """The decision with an effect that explains most of what learned laws leave, and the laws beside it, if any hold.

    ``structured`` is the share of what they leave that is no noise.
    """
    watch.say("looking for an effect beside a law without a name")
    ranked = _called_for(problem, laws[-1].fitted, watch)
    if not ranked:
        return None
    effect = ranked[0].fitted.model.effects[-1]
    fitted = fit(problem, decision.fitted.model.plus(effect), steps=ALL_STEPS)
    again = _relearned(problem, fitted, laws)
    before, after = laws[-1].fitted.cost, (again[-1].fitted if again else fitted).cost
    if before - after < LEAST_EXPLAINED * structured * before:
        return None
    decision = replace(
        decision,
        fitted=fitted,
        rivals=[*decision.rivals, ranked],
        without=leaving_out(problem, decision.base, fitted, known),
        certain=decision.certain | {effect.identifier},
    )
    return decision, again


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


def _relearned(problem: Problem, fitted: Fitted, laws: Sequence[LearnedLaw]) -> tuple[LearnedLaw, ...]:
    """The same laws learned again, one after the other, beside another model; those that still have evidence."""
    found: tuple[LearnedLaw, ...] = ()
    for law in laws:
        again = _learned(problem, found[-1].fitted if found else fitted, law.law.blank())
        if again is not None and again.log_evidence - again.without >= LEAST_EVIDENCE:
            found = (*found, again)
    return found
