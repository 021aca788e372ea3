"""Which formula, if any, says as much as a learned law: fitted through the whole chain, compared as names are.

A law that no name carries may lie in part in a named effect of the same variable that only resembles it. A formula is
therefore tried beside the named effects, for the learned law alone, and in their place, for all of the law.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.evidence import simulated_error
from camid.diagnosis.laws.formula.bends import EXPONENT_BOUNDS
from camid.diagnosis.laws.formula.candidates import (
    GAP,
    LONG_FITS,
    Candidate,
    about_curve,
    about_formula,
    fitted_through_the_chain,
    in_order,
    linear,
    table_of,
    through_the_chain,
)
from camid.diagnosis.laws.formula.dictionary import FIXED_POWERS, POWERS
from camid.diagnosis.laws.formula.groups import Group, other_laws
from camid.diagnosis.laws.learned_laws import LEAST_EVIDENCE
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.watch import Watch
from camid.effects import known_effects
from camid.effects.base import Effect
from camid.effects.learned import FORCES, LearnedEffect
from camid.fitting.linearised_law import LawTable, LinearisedLaw, projected
from camid.fitting.problem import Problem
from camid.fitting.smoothness import smooth_curve

Array = NDArray[np.float64]

# How often the forms are compared again about the best formula.
MOST_ROUNDS = 2
# Share of the curve's sum of squares from which a formula is near to it.
NEAR = 0.8
# The same up to which it is worth to compare the forms about it.
NEARER = 1.2
# Bayes's criterion by which a formula has to lead every other one.
LEAST_MARGIN = 6.0
# Natural logarithm of the evidence for a curve beside a formula that is still chance.
MOST_EVIDENCE_LEFT = 5.0
# Twice the log likelihood that each number of what a formula stands for may be worth (Akaike 1974).
MORE_PER_NUMBER = 2.0
# Error on rows that were not fitted, over that of the learned law, that a formula may have.
LARGEST_ERROR = 1.05
# Prior precision of a slope beside that of a curve.
LEAST_ROUGHNESS = 1e-6


@dataclass(frozen=True)
class Choice:
    """What the search says of a group.

    Attributes
    ----------
    group : Group
    law : LinearisedLaw
        What the recording says of all of the law.
    candidates : list of Candidate
        Those that hold, the best first; a formula is offered if there is one alone.
    best : Candidate, optional
        The best of the dictionary, whether it holds or not.
    explained : float
        Share of what the learned laws explain that it explains.
    reason : str
        Why there is none; empty where there is one.
    """

    group: Group
    law: LinearisedLaw
    candidates: list[Candidate]
    best: Candidate | None
    explained: float
    reason: str


def chosen(
    problem: Problem, decision: Decision, group: Group, judging: Sequence[NDArray[np.bool_]], watch: Watch
) -> Choice:
    """The formulas that say as much as the learned laws of a group.

    Parameters
    ----------
    problem : Problem
    decision : Decision
    group : Group
    judging : sequence of ndarray of bool
        Rows of each recording that are not fitted.
    watch : Watch

    Raises
    ------
    ValueError
        If the chain diverges.
    """
    table = table_of(problem, decision, group)
    candidates: list[Candidate] = []
    # Where a formula carries all of a law, no other effect is needed beside another one.
    for replaced in sorted({(), group.named, group.others}, key=len, reverse=True):
        found = _searched(problem, decision, group, table, replaced, watch)
        candidates += found
        if found and _holds(problem, decision, group, found[0]):
            break
    else:
        candidates += _with_constant(problem, decision, group, table, in_order(candidates), watch)
    return _judged(problem, decision, group, table, in_order(candidates), judging, watch)


def _with_constant(
    problem: Problem, decision: Decision, group: Group, table: LawTable, candidates: Sequence[Candidate], watch: Watch
) -> list[Candidate]:
    """The likeliest formulas beside a constant, where none is free: a law need not be zero at zero."""
    if not candidates or FORCES.get(group.variables, (None, None))[1] is not None:
        return []
    constants = problem.kind.offset_free or problem.kind.bias_free
    if constants or any(effect.is_constant for effect in candidates[0].fit.fitted.model.effects):
        return []
    place = "sensor" if group.variables == "reading" else "actuator"
    kind = next(effect for effect in known_effects().values() if effect.is_constant and effect.place == place)
    constant = kind(**{parameter.name: 0.0 for parameter in kind.numeric()})
    best = candidates[0]
    law = linear(problem, decision, group, table, best.replaced, None)
    again = through_the_chain(problem, decision.improved, group, best.form, best.replaced, law, constant)
    if again is None:
        return []
    others = other_laws(decision, group, best.replaced)
    entries = [
        e for e in about_formula(problem, decision, group, again, others) if e[1].form.name != again.form.form.name
    ]
    return in_order([again, *fitted_through_the_chain(problem, decision.improved, group, entries, watch, constant)])


def _searched(
    problem: Problem, decision: Decision, group: Group, table: LawTable, replaced: tuple[int, ...], watch: Watch
) -> list[Candidate]:
    """The likeliest formulas in the place of the learned laws and other effects, the best first."""
    others = other_laws(decision, group, replaced)
    entries = about_curve(problem, decision, group, table, replaced, others)
    found = fitted_through_the_chain(problem, decision.improved, group, entries, watch)
    # The curve says little of a law that stands for effects that depend on something else.
    alone = bool(set(replaced) - set(group.named))
    for done in range(MOST_ROUNDS):
        # About a formula that is nearer to the truth than the curve, other forms may look likelier.
        if not found or not (alone or _is_nearer(decision, found[0])):
            break
        settled = done > 0 or not alone
        if settled and _is_near(decision, found[0]) and _holds(problem, decision, group, found[0]):
            break
        again = about_formula(problem, decision, group, found[0], others)
        tried = {c.form.form.name for c in found}
        new = [entry for entry in again if entry[1].form.name not in tried]
        if not new or new[0][0] > again[0][0] + GAP:
            break
        before = found[0]
        found = in_order([*found, *fitted_through_the_chain(problem, decision.improved, group, new, watch)])
        if found[0] is before:
            break
    return found


def _judged(
    problem: Problem,
    decision: Decision,
    group: Group,
    table: LawTable,
    candidates: list[Candidate],
    judging: Sequence[NDArray[np.bool_]],
    watch: Watch,
) -> Choice:
    """Those that explain as much as the learned laws, and why there is no formula otherwise."""
    law = linear(problem, decision, group, table, group.named, other_laws(decision, group))
    if not candidates:
        how = " as fast as the effort allows" if LONG_FITS in watch.left_out else ""
        return Choice(group, law, [], None, 0.0, f"no form of the dictionary can be simulated{how}")
    best = candidates[0]
    final = decision.improved
    before = decision.fitted.cost
    gained = max(before - final.cost, 1e-300)
    explained = min(max((before - best.fit.fitted.cost) / gained, 0.0), 1.0)
    if not _is_worth_it(decision, best):
        return Choice(group, law, [], best, explained, "what the curve explains is not worth a formula's numbers")
    if not _holds(problem, decision, group, best):
        return Choice(group, law, [], best, explained, "the curve says more than any form of the dictionary")
    errors = [simulated_error(problem, model, judging) for model in (best.fit.fitted.model, final.model)]
    if errors[0] > LARGEST_ERROR * errors[1]:
        return Choice(group, law, [], best, explained, "its error on rows that were not fitted is larger")
    if not _is_near(decision, best):
        # What is said of the law is said of it about the formula.
        law = about_formula(problem, decision, group, best, other_laws(decision, group, best.replaced))[0][-1]
    equal = [c for c in candidates if c is best or _is_rival(c, best)]
    equal = [c for c in equal if not any(other.form.form.name in c.form.form.contains for other in equal)]
    return Choice(group, law, equal, best, explained, "" if len(equal) == 1 else "several forms say as much")


def exponent_of(problem: Problem, decision: Decision, choice: Choice) -> tuple[float, float] | None:
    """The power with which a law grows and its standard deviation; None where the best formula is no power."""
    best = choice.best
    if best is None or best.form.form.family not in ("odd power", "even power"):
        return None
    if not best.form.form.bends:
        free = next(form for form in POWERS if form.family == best.form.form.family and form.bends)
        power = next(p for p in FIXED_POWERS if best.form.form.name in FIXED_POWERS[p])
        start = replace(best.form, form=free, bends=np.array([max(power, EXPONENT_BOUNDS[0])]))
        found = through_the_chain(
            problem, decision.improved, choice.group, start, best.replaced, choice.law, best.constant
        )
        if found is None:
            return None
        best = found
    deviation = float(np.sqrt(max(best.fit.covariance[-1, -1], 0.0)))
    value = float(best.form.bends[0])
    near_bound = min(abs(value - bound) for bound in EXPONENT_BOUNDS) < deviation
    return None if near_bound or not np.isfinite(deviation) else (value, deviation)


def _is_nearer(decision: Decision, candidate: Candidate) -> bool:
    """Whether a formula is about as near to the recording as the curve, or nearer."""
    return candidate.fit.fitted.cost < NEARER * decision.improved.cost


def _is_near(decision: Decision, candidate: Candidate) -> bool:
    """Whether the curve about which the forms were compared was about as good as a formula."""
    return candidate.fit.fitted.cost > NEAR * decision.improved.cost


def _is_worth_it(decision: Decision, candidate: Candidate) -> bool:
    """Whether a formula has the evidence that a law without a name has to have, against what has names."""
    before, fitted = decision.fitted, candidate.fit.fitted
    count = len(before.model.effects)
    replaced = sum(len(before.model.effects[i].numeric()) for i in candidate.replaced if i < count)
    ratio = len(fitted.residual) * float(np.log(max(before.cost, 1e-300) / max(fitted.cost, 1e-300)))
    gained = ratio / fitted.inflation(before.residual - fitted.residual)
    return gained - (candidate.form.form.count - replaced) * float(np.log(len(fitted.residual))) > 2.0 * LEAST_EVIDENCE


def _holds(problem: Problem, decision: Decision, group: Group, candidate: Candidate) -> bool:
    """Whether a formula leaves no more than what it stands for, and a curve beside it finds nothing that it lacks."""
    if candidate.at_bound:
        return False
    final, fitted = decision.improved, candidate.fit.fitted
    gone = (*group.laws, *candidate.replaced)
    numbers = sum(len(_numbers(final.model.effects[i])) for i in gone)
    ratio = len(fitted.residual) * float(np.log(max(fitted.cost, 1e-300) / max(final.cost, 1e-300)))
    more = ratio / final.inflation(final.residual - fitted.residual)
    if more > MORE_PER_NUMBER * numbers + MOST_EVIDENCE_LEFT:
        return False
    return _evidence_left(problem, decision, group, candidate) < MOST_EVIDENCE_LEFT


def _numbers(effect: Effect) -> Array:
    """The numbers of an effect, or the values of a learned law at its knots."""
    return effect.heights if isinstance(effect, LearnedEffect) else effect.vector


def _is_rival(candidate: Candidate, best: Candidate) -> bool:
    """Whether a formula says about as much as the best one and is another law."""
    other, form = candidate.form.form, best.form.form
    if other.family == form.family or form.name in other.contains:
        return False
    return candidate.fit.criterion_beyond(best.fit) < LEAST_MARGIN


def _evidence_left(problem: Problem, decision: Decision, group: Group, candidate: Candidate) -> float:
    """Natural logarithm of the evidence for a smooth curve beside a formula, less where the residual has a colour."""
    fitted, law = candidate.fit.fitted, decision.improved.model.effects[group.index]
    assert isinstance(law, LearnedEffect)
    knots = np.linspace(law.knots[0], law.knots[-1], min(len(law.knots), 33))
    table = LawTable.of(problem, fitted, len(fitted.model.effects) - 1, knots)
    beside = np.hstack([table.table, candidate.fit.derivatives])
    reduced = table.absorbed.without(np.eye(len(knots)))
    sizes, ways = np.linalg.eigh(reduced @ reduced.T)
    directions = ways[:, sizes > 1e-9 * sizes[-1]]
    second = np.diff(np.eye(len(knots)), 2, axis=0) @ directions
    roughness = second.T @ second
    roughness += LEAST_ROUGHNESS * float(np.trace(roughness)) / len(roughness) * np.eye(len(roughness))
    others = other_laws(decision, group, candidate.replaced)
    columns, residual = (projected(rows, beside, others) for rows in (table.columns @ directions, table.residual))
    smooth = smooth_curve(columns, residual, roughness, len(table.residual) - beside.shape[1])
    change = columns @ smooth.values
    return (smooth.log_evidence - smooth.without) / fitted.inflation(change[: len(fitted.residual)])
