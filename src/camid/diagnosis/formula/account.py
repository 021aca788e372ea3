"""Formulas and words for the learned laws of a decision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.effect_selection import Decision
from camid.diagnosis.formula.candidates import Candidate
from camid.diagnosis.formula.choice import Choice, chosen, exponent_of
from camid.diagnosis.formula.groups import groups_of, values_of
from camid.diagnosis.formula.text import formula_of, unit_text
from camid.diagnosis.formula.words import described, loop_area, missing_from
from camid.diagnosis.in_declared_units import formula_shown, learned_shown
from camid.diagnosis.learned_part import Formula, LearnedPart, Quantity
from camid.diagnosis.watch import Watch
from camid.effects.base import Effect
from camid.fitting.problem import Problem
from camid.number_text import SPACE, plain, with_deviation
from camid.simulation.declared_units import IN_U_AND_Y, DeclaredUnits

Array = NDArray[np.float64]

# Share of the range below which the sensor's zero is that of the positions.
NEAR_ZERO = 2e-3


def with_formulas(
    problem: Problem,
    decision: Decision,
    parts: Sequence[LearnedPart],
    judging: Sequence[NDArray[np.bool_]],
    known: int,
    watch: Watch,
    units: DeclaredUnits = IN_U_AND_Y,
) -> list[LearnedPart]:
    """The learned laws with their formulas, where short ones say as much, and in words.

    Parameters
    ----------
    problem : Problem
    decision : Decision
    parts : sequence of LearnedPart
        One for each of its laws.
    judging : sequence of ndarray of bool
        Rows of each recording that are not fitted.
    known : int
        How many of the model's effects the nominal simulation holds already.
    watch : Watch
    units : DeclaredUnits
        Of the words; formulas are in SI units.
    """
    result = list(parts)
    if not parts or watch.no_time_for("a formula for a law without a name"):
        return result
    watch.say("looking for a formula")
    first = len(decision.fitted.model.effects)
    carried: set[int] = set()
    for group in groups_of(problem, decision, known):
        if group.index in carried:
            continue
        try:
            choice = chosen(problem, decision, group, judging)
        except (ValueError, ArithmeticError, np.linalg.LinAlgError):
            continue
        said = _with_formula(problem, decision, choice, result[group.index - first], units)
        result[group.index - first] = said
        for index in group.laws[:-1]:
            part = result[index - first]
            result[index - first] = replace(part, description="described with the other law over the same variable")
        if said.formula is not None and choice.best is not None:
            carried |= {i for i in choice.best.replaced if i >= first}
            for index in carried:
                needless = f"not needed beside the formula for the {said.name[0].lower()}{said.name[1:]}"
                result[index - first] = replace(result[index - first], formula=None, rivals=[], description=needless)
    return result


def with_words(effects: Sequence[Effect], parts: Sequence[LearnedPart]) -> list[Effect]:
    """The effects of a model, the learned laws behind them with formula and description, as a simulation says them."""
    result = list(effects)
    for i, part in enumerate(parts, len(result) - len(parts)):
        law = result[i]
        text = "" if part.formula is None else part.formula.text
        result[i] = type(law)(**{**law.values, "formula": text, "description": part.description})
    return result


def _with_formula(
    problem: Problem, decision: Decision, choice: Choice, part: LearnedPart, units: DeclaredUnits
) -> LearnedPart:
    """A law with what was found of it."""
    formulas = [_formula(problem, decision, choice, c) for c in choice.candidates]
    formula = formulas[0] if len(formulas) == 1 else None
    power = None
    if formula is not None and choice.best is not None:
        found = exponent_of(problem, decision, choice)
        power = None if found is None else Quantity(*found, "")
    words = described(
        choice.law, part.variables, None if formula is None else formula_shown(formula, part, units), power
    )
    words += _loop(problem, decision, part, units)
    if formulas and choice.best is not None:
        words += _origin(choice.best, part, units) + _constant(choice.best, units)
    if formula is not None and formula.replaces:
        words.append(f"the formula stands for {' and '.join(formula.replaces)}, too, which only resembled it")
    if len(formulas) > 1:
        alike = "; or ".join(each.expression for each in formulas)
        words.append(f"this recording cannot tell apart {alike}")
    elif formula is None and choice.best is not None:
        nearest = formula_shown(_formula(problem, decision, choice, choice.best), part, units)
        missing = missing_from(nearest, learned_shown(part, units), choice.explained)
        words.append(f"no short formula: {choice.reason}; {missing}")
    return replace(part, formula=formula, rivals=formulas if len(formulas) > 1 else [], description="; ".join(words))


def _formula(problem: Problem, decision: Decision, choice: Choice, candidate: Candidate) -> Formula:
    """A candidate in the units of the recording, and its values where the learned law can be compared with them."""
    group, law = choice.group, choice.law
    final, refitted = decision.improved, candidate.fit.fitted
    gone = {*group.laws, *candidate.replaced}
    kept = [i for i in range(len(final.model.effects)) if i not in gone]
    values = candidate.form.values(law.grid)
    held = law.absorbed.part_of(values)
    for i in group.named:
        values = values - values_of(problem, final, i, group.variables, law.grid)
        if i in kept:
            values = values + values_of(problem, refitted, kept.index(i), group.variables, law.grid)
    for i in group.laws[:-1]:
        values = values - values_of(problem, final, i, group.variables, law.grid)
    carried = np.zeros(len(law.grid))
    for i in (*group.laws[:-1], *candidate.replaced):
        carried += values_of(problem, final, i, group.variables, law.grid)
    names = [name for name, there in (("constant", law.absorbed.constant), ("slope", law.absorbed.line)) if there]
    formula = formula_of(candidate.form, candidate.fit.covariance, group.variables)
    return replace(
        formula,
        replaces=[final.model.effects[i].identifier for i in candidate.replaced],
        held={name: float(value) for name, value in zip(names, held, strict=True)},
        points=law.grid.tolist(),
        values=law.absorbed.without(values).tolist(),
        carried=law.absorbed.without(carried).tolist(),
    )


def _constant(candidate: Candidate, units: DeclaredUnits) -> list[str]:
    """The constant beside a formula that is zero at zero, where one was fitted."""
    if candidate.constant is None:
        return []
    fitted, name = candidate.fit.fitted, candidate.constant.numeric()[0]
    index = next(i for i, e in enumerate(fitted.model.effects) if e.identifier == candidate.constant.identifier)
    value, variance = fitted.model.effects[index].vector[0], fitted.covariance
    place = fitted.packing.names.index(f"{index} {name.name}")
    spread = float(np.sqrt(max(variance[place, place], 0.0)))
    shown = units.declared(float(value), spread, name.unit)
    text = with_deviation(shown["value"], shown["std"], shown["unit"]).replace(SPACE, " ")
    return [f"counted from its value at zero, it stands beside a constant of {text}"]


def _origin(candidate: Candidate, part: LearnedPart, units: DeclaredUnits) -> list[str]:
    """Where the positions of a formula are counted from, where the sensor's zero is elsewhere."""
    model = candidate.fit.fitted.model
    constants = [e.values["offset"] for e in model.effects if e.is_constant and e.place == "sensor"]
    offset = float(model.constants.get("offset", 0.0)) + sum(constants)
    if part.knot_unit != "y" or abs(offset) < NEAR_ZERO * (part.knots[-1] - part.knots[0]):
        return []
    rest = plain(units.shown(offset, "y"), 3, units.text("y"))
    return [f"y is counted from the rest, which the sensor reads as {rest}".replace(SPACE, " ")]


def _loop(problem: Problem, decision: Decision, part: LearnedPart, units: DeclaredUnits) -> list[str]:
    """The area of the loop over a sinusoidal motion of the recording's size, in words."""
    motions = problem.motion(decision.improved.model)
    position, velocity = (problem.fitted([m[i] for m in motions]) for i in (0, 1))
    size, speed = float(np.std(position)), float(np.std(velocity))
    if not size > 0.0 or not speed > 0.0:
        return []
    law = {
        "knots": np.array(part.knots),
        "values": np.array(part.values),
        "deviations": np.array(part.standard_deviations),
    }
    amplitude, frequency = np.sqrt(2.0) * size, speed / size
    found = loop_area(law, part.variables, amplitude, frequency)
    if found is None:
        return []
    work = unit_text({"u": 1, "y": 1}, {}, 0.0)
    lost = units.declared(*found, work)
    area = with_deviation(lost["value"], lost["std"], lost["unit"])
    motion = f"{plain(units.shown(amplitude, 'y'), 3, units.text('y'))} at {plain(frequency, 3, 'rad/s')}"
    text = f"a motion of {motion} loses {area} a period to it, beyond the plant's own damping"
    return [text.replace(SPACE, " ")]
