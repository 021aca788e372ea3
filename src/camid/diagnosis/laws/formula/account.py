"""Formulas and words for the learned laws of a decision."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.evidence import simulated_error
from camid.diagnosis.in_declared_units import formula_shown, learned_shown
from camid.diagnosis.laws.formula.candidates import Candidate
from camid.diagnosis.laws.formula.choice import LARGEST_ERROR, Choice, chosen, exponent_of
from camid.diagnosis.laws.formula.groups import Group, groups_of, values_of
from camid.diagnosis.laws.formula.in_place import in_place
from camid.diagnosis.laws.formula.text import formula_of, unit_text
from camid.diagnosis.laws.formula.words import described, held_by_coefficients, loop_area, missing_from
from camid.diagnosis.learned_part import Curve, Formula, LearnedPart, Quantity
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.verdict import learned_parts
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
    judging: Sequence[NDArray[np.bool_]],
    known: int,
    watch: Watch,
    units: DeclaredUnits = IN_U_AND_Y,
) -> tuple[Decision, list[LearnedPart]]:
    """The learned laws in words, and with a formula in the place of a curve where a short one says as much.

    Parameters
    ----------
    problem : Problem
    decision : Decision
    judging : sequence of ndarray of bool
        Rows of each recording that are not fitted.
    known : int
        How many of the model's effects the nominal simulation holds already.
    watch : Watch
    units : DeclaredUnits
        Of the words; formulas are in SI units.

    Returns
    -------
    Decision
        With the likeliest formula in the place of all that it stands for, and so on with what is left.
    list of LearnedPart
        One for each of its laws.
    """
    watch.take_stock()
    if not decision.laws or watch.no_time_for("a formula for a law without a name"):
        return decision, learned_parts(decision)
    watch.say("looking for a formula")
    said: dict[str, LearnedPart] = {}
    choices = _choices(problem, decision, judging, known, said, watch)
    while offered := [choice for choice in choices if choice.candidates]:
        reference = offered[0].candidates[0]
        best = min(offered, key=lambda choice: choice.candidates[0].fit.criterion_beyond(reference.fit))
        variables, candidate = best.group.variables, best.candidates[0]
        part = _part_of(decision, best.group)
        words = _with_formula(problem, decision, best, part, units)
        found = in_place(problem, decision, best.group, candidate, known, _formulas(said))
        if _errs_no_more(problem, found, decision, judging):
            decision = found
            curve = Curve(part.knots, part.values, part.standard_deviations)
            words = replace(words, curve=curve, description=f"{words.description}; {_held(words)}")
        said[variables] = words
        choices = _choices(problem, decision, judging, known, said, watch)
    for choice in choices:
        said[choice.group.variables] = _with_formula(problem, decision, choice, _part_of(decision, choice.group), units)
    return decision, _in_words(decision, said)


def _choices(
    problem: Problem,
    decision: Decision,
    judging: Sequence[NDArray[np.bool_]],
    known: int,
    said: Mapping[str, LearnedPart],
    watch: Watch,
) -> list[Choice]:
    """The formulas for laws over variables for which there is none yet."""
    found: list[Choice] = []
    for group in groups_of(problem, decision, known, tuple(said)):
        watch.take_stock()
        if (found or said) and watch.no_time_for("formulas for further laws"):
            break
        with suppress(ValueError, ArithmeticError, np.linalg.LinAlgError):
            found.append(chosen(problem, decision, group, judging, watch))
    return found


def _part_of(decision: Decision, group: Group) -> LearnedPart:
    """The last law of a group as it was learned."""
    return learned_parts(decision)[group.index - len(decision.fitted.model.effects)]


def _in_words(decision: Decision, said: Mapping[str, LearnedPart]) -> list[LearnedPart]:
    """The laws of a decision with what was found of them, the last one over each variable."""
    result: list[LearnedPart] = []
    for part in reversed(learned_parts(decision)):
        words = said.get(part.variables)
        if words is None:
            result.append(part)
        elif any(part.variables == other.variables for other in result):
            result.append(replace(part, description="described with the other law over the same variable"))
        else:
            found = {name: getattr(words, name) for name in ("formula", "rivals", "description", "curve")}
            result.append(replace(part, **found))
    return result[::-1]


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
        words += [] if formula is None else held_by_coefficients(formula_shown(formula, part, units), part, units)
    if formula is not None and formula.replaces:
        words.append(f"the formula stands for {' and '.join(formula.replaces)}, too, which only resembled it")
    if len(formulas) > 1:
        alike = "; or ".join(each.expression for each in formulas)
        words.append(f"this recording cannot tell apart {alike}")
    elif formula is None and choice.best is not None:
        nearest = formula_shown(_formula(problem, decision, choice, choice.best), part, units)
        missing = missing_from(nearest, learned_shown(part, units), choice.explained)
        words.append(f"no short formula: {choice.reason}; {missing}")
    elif formula is None:
        words.append(f"no short formula: {choice.reason}")
    return replace(part, formula=formula, rivals=formulas if len(formulas) > 1 else [], description="; ".join(words))


def _held(part: LearnedPart) -> str:
    """What the improved simulation holds of the formulas that say as much as a curve."""
    name = "the formula" if part.formula is not None else "the likeliest of them"
    return (
        f"the improved simulation holds {name} in the place of {' and '.join(['the curve', *part.drawn[0].replaces])}"
    )


def _errs_no_more(problem: Problem, found: Decision, before: Decision, judging: Sequence[NDArray[np.bool_]]) -> bool:
    """Whether a decision errs about as little as another on rows that were not fitted."""
    errors = [simulated_error(problem, each.improved.model, judging) for each in (found, before)]
    return errors[0] <= LARGEST_ERROR * errors[1]


def _formulas(said: Mapping[str, LearnedPart]) -> tuple[str, ...]:
    """What the laws that are formulas already depend on."""
    return tuple(variables for variables, part in said.items() if part.curve is not None)


def _formula(problem: Problem, decision: Decision, choice: Choice, candidate: Candidate) -> Formula:
    """A candidate in the units of the recording, and its values where the learned law can be compared with them."""
    group, law = choice.group, choice.law
    final, refitted = decision.improved, candidate.fit.fitted
    gone = {*group.laws, *candidate.replaced}
    kept = [i for i in range(len(final.model.effects)) if i not in gone]
    values = candidate.form.values(law.grid)
    absorbed = candidate.absorbed
    held = absorbed.part_of(candidate.form.values(absorbed.grid))
    for i in group.named:
        values = values - values_of(problem, final, i, group.variables, law.grid)
        if i in kept:
            values = values + values_of(problem, refitted, kept.index(i), group.variables, law.grid)
    for i in group.laws[:-1]:
        values = values - values_of(problem, final, i, group.variables, law.grid)
    carried = np.zeros(len(law.grid))
    for i in (*group.laws[:-1], *candidate.replaced):
        carried += values_of(problem, final, i, group.variables, law.grid)
    names = [name for name, there in (("constant", absorbed.constant), ("slope", absorbed.line)) if there]
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
