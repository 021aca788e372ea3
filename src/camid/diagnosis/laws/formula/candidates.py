"""Candidate formulas: compared to first order about a curve or another formula, and fitted through the whole chain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.laws.formula.bends import Range
from camid.diagnosis.laws.formula.groups import Group, values_of
from camid.diagnosis.laws.formula.search import FittedForm, fitted_forms, length_of
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.watch import Watch
from camid.effects.base import Effect
from camid.effects.learned import LearnedEffect
from camid.fitting.fit import Fitted
from camid.fitting.formula_fit import FormulaFit, TooMuchWorkError, fit_formula
from camid.fitting.linearised_law import Absorbed, LawTable, LinearisedLaw, fine_grid
from camid.fitting.problem import Problem
from camid.side_by_side import side_by_side

Array = NDArray[np.float64]

# Formulas that are fitted through the chain, and by how much the criterion of those beyond the first ones may exceed
# that of the best one to first order.
FEWEST_FITTED, MOST_FITTED = 2, 3
GAP = 60.0
# What is left out where the fit of a formula would take more than is left of the work.
LONG_FITS = "formulas that take long to simulate"
# Share of what a bend may be within which it lies on its bound.
ON_BOUND = 1e-4


@dataclass(frozen=True)
class Candidate:
    """A formula fitted through the chain.

    Attributes
    ----------
    form : FittedForm
    fit : FormulaFit
    replaced : tuple of int
        Effects found in whose place it stands, beside the learned laws.
    at_bound : bool
        Whether a threshold, scale or exponent went as far as it may, so that the form is another.
    absorbed : Absorbed
        What the coefficients held of it in the fit.
    constant : Effect, optional
        A constant force or offset that was fitted beside it, as it was before the fit.
    """

    form: FittedForm
    fit: FormulaFit
    replaced: tuple[int, ...]
    at_bound: bool
    absorbed: Absorbed
    constant: Effect | None = None


# A form with its criterion to first order, the effects that it stands for, and what it was compared with.
Entry = tuple[float, FittedForm, tuple[int, ...], LinearisedLaw]


def table_of(problem: Problem, decision: Decision, group: Group) -> LawTable:
    """Derivatives by the learned law of a group about its curve, for all that is asked to first order about it.

    Raises
    ------
    ValueError
        If the simulation diverges.
    """
    law = decision.improved.model.effects[group.index]
    assert isinstance(law, LearnedEffect)
    return LawTable.of(problem, decision.improved, group.index, fine_grid(law.knots))


def linear(
    problem: Problem,
    decision: Decision,
    group: Group,
    table: LawTable,
    replaced: tuple[int, ...],
    others: Array | None,
) -> LinearisedLaw:
    """What the recording says of the learned laws and other effects together, to first order about the curve."""
    values = np.zeros(len(table.grid))
    for i in (*group.laws, *replaced):
        values += values_of(problem, decision.improved, i, group.variables, table.grid)
    return table.about(values, replaced, others)


def about_curve(
    problem: Problem,
    decision: Decision,
    group: Group,
    table: LawTable,
    replaced: tuple[int, ...],
    others: Array | None,
) -> list[Entry]:
    """All forms in the place of the learned laws and other effects, to first order about the curve."""
    return _scored(decision.improved, linear(problem, decision, group, table, replaced, others), replaced)


def about_formula(
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


def fitted_through_the_chain(
    problem: Problem,
    final: Fitted,
    group: Group,
    entries: Sequence[Entry],
    watch: Watch,
    constant: Effect | None = None,
) -> list[Candidate]:
    """The likeliest forms, fitted to the recording; by Bayes's criterion, the best first.

    ``constant`` is an effect that stands beside them, too. What is left of the work is shared out among them.
    """
    likely = [e for i, e in enumerate(entries[:MOST_FITTED]) if i < FEWEST_FITTED or e[0] <= entries[0][0] + GAP]
    share = watch.allowance(len(likely))
    fitted = side_by_side(partial(_fitted, problem, final, group, constant, watch, share), likely)
    return in_order([candidate for candidate in fitted if candidate is not None])


def _fitted(
    problem: Problem,
    final: Fitted,
    group: Group,
    constant: Effect | None,
    watch: Watch,
    share: float,
    entry: Entry,
) -> Candidate | None:
    _, form, named, linear = entry
    try:
        return through_the_chain(problem, final, group, form, named, linear, constant, share)
    except TooMuchWorkError:
        watch.leave_out(LONG_FITS)
        return None


def through_the_chain(
    problem: Problem,
    final: Fitted,
    group: Group,
    form: FittedForm,
    named: tuple[int, ...],
    linear: LinearisedLaw,
    constant: Effect | None = None,
    most_work: float = np.inf,
) -> Candidate | None:
    """A formula fitted to the recording with everything else; None where the chain diverges.

    Raises
    ------
    TooMuchWorkError
        If the fit would take more work than ``most_work``, in seconds.
    """
    law = final.model.effects[group.index]
    assert isinstance(law, LearnedEffect)
    gone = {*group.laws, *named}
    beside = replace(final.model, effects=tuple(e for i, e in enumerate(final.model.effects) if i not in gone))
    if constant is not None:
        beside = beside.plus(constant)
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
            final.residual,
            most_work,
        )
    except (ValueError, ArithmeticError):
        return None
    low, high = form.bounds(visited)
    away = np.minimum(fit.vector - low, high - fit.vector)[len(form.amplitudes) :]
    at_bound = bool(np.any(away < ON_BOUND * (high - low)[len(form.amplitudes) :]))
    return Candidate(form.with_vector(fit.vector), fit, named, at_bound, linear.absorbed, constant)


def in_order(candidates: list[Candidate]) -> list[Candidate]:
    """By Bayes's criterion, the best first."""
    if not candidates:
        return []
    reference = min(candidates, key=lambda c: c.fit.fitted.cost)
    return sorted(candidates, key=lambda c: c.fit.criterion_beyond(reference.fit))
