"""Which formula, if any, says as much as a learned law: fitted through the whole chain, compared as names are.

A law that no name carries may lie in part in a named effect of the same variable that only resembles it. A formula is
therefore tried beside the named effects, for the learned law alone, and in their place, for all of the law.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.effect_selection import Decision
from camid.diagnosis.evidence import simulated_error
from camid.diagnosis.formula.dictionary import EXPONENT_BOUNDS, FIXED_POWERS, POWERS, Range
from camid.diagnosis.formula.search import FittedForm, fitted_forms, length_of
from camid.effects.learned import LearnedEffect
from camid.fitting.fit import Fitted
from camid.fitting.formula_fit import FormulaFit, fit_formula
from camid.fitting.linearised_law import LawTable, LinearisedLaw, fine_grid, projected
from camid.fitting.problem import Problem
from camid.fitting.smoothness import smooth_curve
from camid.fitting.static_laws import static_values

Array = NDArray[np.float64]

# Formulas that are fitted through the chain, and by how much their criterion may exceed the best one's to first order.
MOST_FITTED = 3
GAP = 60.0
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
# Error on rows that were not fitted, over that of the learned law, that a formula may have.
LARGEST_ERROR = 1.05
# Prior precision of a slope beside that of a curve.
LEAST_ROUGHNESS = 1e-6


@dataclass(frozen=True)
class Group:
    """The learned laws over one variable, and what stands in for a part of the same law.

    Attributes
    ----------
    variables : str
    index : int
        Of the last such law among the effects of the improved model.
    laws, named : tuple of int
        The laws, and effects found that are static laws of the same variable.
    """

    variables: str
    index: int
    laws: tuple[int, ...]
    named: tuple[int, ...]


@dataclass(frozen=True)
class Candidate:
    """A formula fitted through the chain.

    Attributes
    ----------
    form : FittedForm
    fit : FormulaFit
    replaced : tuple of int
        Effects found in whose place it stands, beside the learned laws.
    """

    form: FittedForm
    fit: FormulaFit
    replaced: tuple[int, ...]


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


def groups_of(problem: Problem, decision: Decision, known: int) -> list[Group]:
    """The learned laws of a decision by what they depend on."""
    model = decision.improved.model
    plant = problem.structure.plant(model.coefficients)
    count = len(decision.fitted.model.effects)
    learned: dict[str, list[int]] = {}
    for i, effect in enumerate(model.effects):
        if i >= count and isinstance(effect, LearnedEffect):
            learned.setdefault(str(effect.values["variables"]), []).append(i)
    groups = []
    for variables, indices in learned.items():
        law = model.effects[indices[-1]]
        assert isinstance(law, LearnedEffect)
        period = problem.acquisition.period
        named = [
            i
            for i in range(known, count)
            if static_values(model.effects[i], variables, law.knots, plant, period) is not None
        ]
        groups.append(Group(variables, indices[-1], tuple(indices), tuple(named)))
    return groups


def chosen(problem: Problem, decision: Decision, group: Group, judging: Sequence[NDArray[np.bool_]]) -> Choice:
    """The formulas that say as much as the learned laws of a group.

    Parameters
    ----------
    problem : Problem
    decision : Decision
    group : Group
    judging : sequence of ndarray of bool
        Rows of each recording that are not fitted.

    Raises
    ------
    ValueError
        If the chain diverges.
    """
    others = _other_laws(decision, group)
    laws: dict[tuple[int, ...], LinearisedLaw] = {}
    candidates: list[Candidate] = []
    # Where a formula carries all of a law, no named effect is needed beside another one.
    for named in sorted({(), group.named}, key=len, reverse=True):
        entries = _about_curve(problem, decision, group, named, others)
        laws[named] = entries[0][-1]
        found = _fitted_through_the_chain(problem, decision.improved, group, entries)
        holds = bool(found) and _holds(problem, decision, group, found[0])
        for _ in range(MOST_ROUNDS):
            # About a formula that is nearer to the truth than the curve, other forms may look likelier.
            if not found or not _is_nearer(decision, found[0]) or (holds and _is_near(decision, found[0])):
                break
            again = _about_formula(problem, decision, group, found[0], others)
            tried = {c.form.form.name for c in found}
            new = [entry for entry in again if entry[1].form.name not in tried]
            if not new or new[0][0] > again[0][0] + GAP:
                break
            before = found[0]
            found = _in_order([*found, *_fitted_through_the_chain(problem, decision.improved, group, new)])
            if found[0] is before:
                break
            holds = _holds(problem, decision, group, found[0])
        candidates += found
        if holds:
            break
    return _judged(problem, decision, group, laws[group.named], _in_order(candidates), judging)


# A form with its criterion to first order, the effects that it stands for, and what it was compared with.
Entry = tuple[float, FittedForm, tuple[int, ...], LinearisedLaw]


def _about_curve(
    problem: Problem, decision: Decision, group: Group, named: tuple[int, ...], others: Array | None
) -> list[Entry]:
    """All forms in the place of the learned laws and named effects, to first order about the curve."""
    final = decision.improved
    law = final.model.effects[group.index]
    assert isinstance(law, LearnedEffect)
    table = LawTable.of(problem, final, group.index, fine_grid(law.knots))
    values = np.zeros(len(table.grid))
    for i in (*group.laws, *named):
        values += values_of(problem, final, i, group.variables, table.grid)
    return _scored(final, table.about(values, named, others), named)


def _about_formula(
    problem: Problem, decision: Decision, group: Group, candidate: Candidate, others: Array | None
) -> list[Entry]:
    """All forms in the place of a formula, to first order about it."""
    fitted = candidate.fit.fitted
    law = decision.improved.model.effects[group.index]
    assert isinstance(law, LearnedEffect)
    table = LawTable.of(problem, fitted, len(fitted.model.effects) - 1, fine_grid(law.knots))
    return _scored(fitted, table.about(table.values, (), others), candidate.replaced)


def _scored(fitted: Fitted, linear: LinearisedLaw, named: tuple[int, ...]) -> list[Entry]:
    """All forms with Bayes's criterion to first order, the best first."""
    noise = fitted.cost / max(len(fitted.residual), 1)
    count = float(np.log(linear.rows))
    found = [(each.left / noise + each.form.count * count, each, named, linear) for each in fitted_forms(linear)]
    return sorted(found, key=lambda entry: entry[0])


def _fitted_through_the_chain(
    problem: Problem, final: Fitted, group: Group, entries: Sequence[Entry]
) -> list[Candidate]:
    """The likeliest forms, fitted to the recording; by Bayes's criterion, the best first."""
    candidates: list[Candidate] = []
    for score, form, named, linear in entries[:MOST_FITTED]:
        if score > entries[0][0] + GAP and len(candidates) > 1:
            break
        candidate = _through_the_chain(problem, final, group, form, named, linear)
        if candidate is not None:
            candidates.append(candidate)
    return _in_order(candidates)


def values_of(problem: Problem, fitted: Fitted, index: int, variables: str, at: Array) -> Array:
    """Force, or bend, of an effect of a group at some points, shape (N,)."""
    plant = problem.structure.plant(fitted.model.coefficients)
    found = static_values(fitted.model.effects[index], variables, at, plant, problem.acquisition.period)
    assert found is not None
    return found


def _other_laws(decision: Decision, group: Group) -> Array | None:
    """Derivatives by the learned laws over other variables."""
    first = len(decision.fitted.model.effects)
    start, kept = 0, []
    for i, law in enumerate(decision.laws):
        whole = law.fitted.nuisance
        if whole is None:
            continue
        if first + i not in group.laws:
            kept.append(whole[:, start:])
        start = whole.shape[1]
    return np.hstack(kept) if kept else None


def _through_the_chain(
    problem: Problem, final: Fitted, group: Group, form: FittedForm, named: tuple[int, ...], linear: LinearisedLaw
) -> Candidate | None:
    """A formula fitted to the recording with everything else; None where the chain diverges."""
    law = final.model.effects[group.index]
    assert isinstance(law, LearnedEffect)
    gone = {*group.laws, *named}
    beside = replace(final.model, effects=tuple(e for i, e in enumerate(final.model.effects) if i not in gone))
    length = length_of(linear.grid)
    visited = Range(float(linear.grid[0]) / length, float(linear.grid[-1]) / length)
    try:
        fit = fit_formula(
            problem,
            beside,
            law,
            linear.absorbed,
            lambda at, vector: form.with_vector(vector).values(at),
            form.vector,
            form.bounds(visited),
        )
    except (ValueError, ArithmeticError):
        return None
    return Candidate(form.with_vector(fit.vector), fit, named)


def _in_order(candidates: list[Candidate]) -> list[Candidate]:
    """By Bayes's criterion, the best first."""
    if not candidates:
        return []
    reference = min(candidates, key=lambda c: c.fit.fitted.cost)
    return sorted(candidates, key=lambda c: c.fit.criterion_beyond(reference.fit))


def _judged(
    problem: Problem,
    decision: Decision,
    group: Group,
    law: LinearisedLaw,
    candidates: list[Candidate],
    judging: Sequence[NDArray[np.bool_]],
) -> Choice:
    """Those that explain as much as the learned laws, and why there is no formula otherwise."""
    if not candidates:
        return Choice(group, law, [], None, 0.0, "no form of the dictionary can be simulated")
    best = candidates[0]
    final = decision.improved
    before = decision.fitted.cost
    gained = max(before - final.cost, 1e-300)
    explained = min(max((before - best.fit.fitted.cost) / gained, 0.0), 1.0)
    if not _holds(problem, decision, group, best):
        return Choice(group, law, [], best, explained, "the curve says more than any form of the dictionary")
    errors = [simulated_error(problem, model, judging) for model in (best.fit.fitted.model, final.model)]
    if errors[0] > LARGEST_ERROR * errors[1]:
        return Choice(group, law, [], best, explained, "its error on rows that were not fitted is larger")
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
        found = _through_the_chain(problem, decision.improved, choice.group, start, best.replaced, choice.law)
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


def _holds(problem: Problem, decision: Decision, group: Group, candidate: Candidate) -> bool:
    """Whether a curve beside a formula finds nothing that it lacks."""
    return _evidence_left(problem, decision, group, candidate) < MOST_EVIDENCE_LEFT


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
    others = _other_laws(decision, group)
    columns, residual = (projected(rows, beside, others) for rows in (table.columns @ directions, table.residual))
    smooth = smooth_curve(columns, residual, roughness, len(table.residual) - beside.shape[1])
    change = columns @ smooth.values
    return (smooth.log_evidence - smooth.without) / fitted.inflation(change[: len(fitted.residual)])
