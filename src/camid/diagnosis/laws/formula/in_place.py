"""A formula in the place of a learned curve, and of the effects that only resembled a part of the law.

A formula that is offered is at least as likely as all that it stands for (:mod:`camid.diagnosis.laws.formula.choice`),
and errs no more on rows that were not fitted. Names that only resembled the law err on another recording, where the law
itself does not: the improved simulation holds the formula alone, as values between which straight lines are as good.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.laws.formula.candidates import Candidate
from camid.diagnosis.laws.formula.groups import Group
from camid.diagnosis.laws.learned_laws import relearned
from camid.diagnosis.pruning.simplest_effects import leaving_out
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.search.hypothesis_fit import ALL_STEPS
from camid.effects.learned import LearnedCurve, LearnedEffect
from camid.effects.plant_force import motion_sign
from camid.fitting.fit import Fitted, evaluate, fit
from camid.fitting.learned_law import LearnedLaw
from camid.fitting.linearised_law import bend_of, on_points
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem

Array = NDArray[np.float64]

# Share of a law's height by which straight lines between its values may miss it.
MISSED = 3e-4
# The same beyond what the recording visited, how far a formula goes there, as a share of that, on how many points, and
# how many times as large as in the recording it may become.
MISSED_BEYOND, BEYOND, POINTS_BEYOND, LARGEST = 3e-3, 0.5, 61, 8.0
# Step of the differences by a formula's numbers, as a share of them.
DIFFERENCE = 1e-5
# Standard deviation of the prior of a formula's numbers, in what the noise determines one of them alone to.
VAGUE = 1e3


def in_place(
    problem: Problem, decision: Decision, group: Group, candidate: Candidate, known: int, done: Sequence[str] = ()
) -> Decision:
    """The decision with a formula for its curve and all that the formula stands for.

    Parameters
    ----------
    problem : Problem
    decision : Decision
    group : Group
        Whose law the formula is.
    candidate : Candidate
        The formula.
    known : int
        How many of the model's effects the nominal simulation holds already.
    done : sequence of str
        What the laws that are formulas already depend on.

    Returns
    -------
    Decision
        The formula is the first of its laws behind earlier ones; curves that it does not stand for are learned again
        beside it.
    """
    count = len(decision.fitted.model.effects)
    kept = [i for i in range(known, count) if i not in candidate.replaced]
    named = decision
    if len(kept) < count - known:
        named = _without(problem, decision, known, kept)
    before = candidate.fit.fitted.model
    law = _law(problem, candidate, before)
    gone = (*group.laws, *candidate.replaced)
    staying = [each for i, each in enumerate(decision.laws, count) if i not in gone]
    formulas = [each for each in staying if each.law.values["variables"] in done]
    curves = [each for each in staying if each.law.values["variables"] not in done]
    effects = (*before.effects[: known + len(kept)], *(each.law for each in formulas), law)
    model = replace(before, effects=effects)
    fitted = fit(problem, model, steps=ALL_STEPS) if curves else evaluate(candidate.fit.fitted.problem, model)
    fitted = replace(fitted, nuisance=np.hstack([*_earlier(formulas), _nuisance(candidate)]))
    new = LearnedLaw(fitted, _deviations(candidate, law), *_log_evidence(named.fitted, candidate))
    return replace(named, laws=(*formulas, new, *relearned(problem, fitted, curves, named)))


def _earlier(formulas: Sequence[LearnedLaw]) -> list[Array]:
    """Derivatives by earlier formulas, which the last of them holds."""
    last = formulas[-1].fitted.nuisance if formulas else None
    return [] if last is None else [last]


def _without(problem: Problem, decision: Decision, known: int, kept: list[int]) -> Decision:
    """The decision with some of its effects alone, without laws."""
    if not kept:
        return Decision(decision.base, decision.base)
    model = decision.fitted.model
    effects = (*model.effects[:known], *(model.effects[i] for i in kept))
    fitted = fit(problem, replace(model, effects=effects), steps=ALL_STEPS)
    return replace(
        decision,
        fitted=fitted,
        rivals=[decision.rivals[i - known] for i in kept],
        without=leaving_out(problem, decision.base, fitted, known),
        laws=(),
        certain=decision.certain & {effect.identifier for effect in effects},
    )


def _law(problem: Problem, candidate: Candidate, model: Model) -> LearnedEffect:
    """The formula as a law on as few points as carry it, with the constant that was fitted beside it."""
    law = model.effects[-1]
    assert isinstance(law, LearnedEffect)
    knots, bends = _carried(candidate, law)
    if candidate.constant is not None:
        constant = next(e for e in model.effects if e.identifier == candidate.constant.identifier)
        value = float(constant.vector[0])
        if isinstance(law, LearnedCurve):
            # What is bent is the signal with its constant.
            knots, bends = knots - value, bends + value
        else:
            bends = bends - motion_sign(problem.structure.plant(model.coefficients)) * value
    return on_points(law, knots, bends)


def _carried(candidate: Candidate, law: LearnedEffect) -> tuple[Array, Array]:
    """Points that carry a formula, and by how much it bends there: where the recording was, and half as far beyond.

    The names that it stands for do not end there, either. It stays what it is where it would become far larger.
    """
    height = float(np.ptp(bend_of(law, law.knots)))
    beyond = BEYOND * float(np.ptp(law.knots)) * np.linspace(0.0, 1.0, POINTS_BEYOND)
    parts = []
    for points, missed in (
        ((law.knots[0] - beyond)[::-1], MISSED_BEYOND),
        (law.knots, MISSED),
        (law.knots[-1] + beyond, MISSED_BEYOND),
    ):
        bends = _bends(candidate, points, candidate.form.vector)
        few = enough_points(points, np.nan_to_num(bends), missed * height)
        parts.append((points[few], bends[few]))
    knots, bends = (np.concatenate([parts[0][i][:-1], parts[1][i], parts[2][i][1:]]) for i in (0, 1))
    small = np.abs(bends) <= LARGEST * float(np.max(np.abs(parts[1][1])))
    first, last = len(parts[0][0]) - 1, len(knots) - len(parts[2][0])
    while first > 0 and small[first - 1]:
        first -= 1
    while last < len(knots) - 1 and small[last + 1]:
        last += 1
    return knots[first : last + 1], bends[first : last + 1]


def _bends(candidate: Candidate, points: Array, vector: Array) -> Array:
    """A formula with some numbers, without what the coefficients hold of it."""
    absorbed, form = candidate.absorbed, candidate.form.with_vector(vector)
    held = absorbed.part_of(form.values(absorbed.grid))
    with np.errstate(all="ignore"):
        return np.asarray(form.values(points) - absorbed.functions(points) @ held)


def enough_points(at: Array, heights: Array, tolerance: float) -> Array:
    """Indices of points between which straight lines miss no other one by more than a tolerance.

    The curve is divided where it is missed most, again and again (Ramer 1972; Douglas & Peucker 1973).

    Parameters
    ----------
    at, heights : ndarray, shape (N,)
    tolerance : float

    Returns
    -------
    ndarray of int, shape (n,)
    """
    kept, spans = {0, len(at) - 1}, [(0, len(at) - 1)]
    while spans:
        low, high = spans.pop()
        inner = np.arange(low + 1, high)
        if not len(inner):
            continue
        missed = np.abs(heights[inner] - np.interp(at[inner], at[[low, high]], heights[[low, high]]))
        worst = int(inner[np.argmax(missed)])
        if missed.max() > tolerance:
            kept.add(worst)
            spans += [(low, worst), (worst, high)]
    return np.array(sorted(kept))


def _deviations(candidate: Candidate, law: LearnedEffect) -> Array:
    """Standard deviations of the formula at the points of a law, from those of its numbers that are determined."""
    vector = candidate.form.vector
    steps = DIFFERENCE * np.maximum(np.abs(vector), 1e-3 * float(np.max(np.abs(vector))))
    here = _bends(candidate, law.knots, vector)
    moved = (_bends(candidate, law.knots, vector + s * way) for s, way in zip(steps, np.eye(len(steps)), strict=True))
    table = np.column_stack([(each - here) / s for each, s in zip(moved, steps, strict=True)])
    covariance = np.where(np.isfinite(candidate.fit.covariance), candidate.fit.covariance, 0.0)
    return np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", table, covariance, table), 0.0))


def _nuisance(candidate: Candidate) -> Array:
    """Derivatives by the formula's numbers, measured so that the prior of each says next to nothing."""
    table = candidate.fit.derivatives
    return np.asarray(VAGUE * table / np.maximum(np.linalg.norm(table, axis=0), 1e-300))


def _log_evidence(before: Fitted, candidate: Candidate) -> tuple[float, float]:
    """Logarithms of the evidence with a formula and without, by Bayes's criterion, but for what both share."""
    fitted = candidate.fit.fitted
    freedom = len(before.residual) - len(before.packing.names)
    with_it, without = (-0.5 * freedom * float(np.log(max(each.cost, 1e-300))) for each in (fitted, before))
    return with_it - 0.5 * candidate.form.form.count * float(np.log(len(fitted.residual))), without
