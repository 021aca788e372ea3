"""A diagnosis as people read it: every number in the units that the simulation declares, with the unit written.

diagnosis.json, improved.yaml and residuals.csv are in SI units; the terminal, the page and its pictures are in these.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

from camid.number_text import SPACE, plain
from camid.simulation.declared_units import DeclaredUnits

if TYPE_CHECKING:
    from camid.diagnosis.diagnosis import Coefficient, Diagnosis, Location, Signals, Undetectable
    from camid.diagnosis.effect_signals import EffectSignals
    from camid.diagnosis.finding import Finding, ParameterEstimate
    from camid.diagnosis.learned_part import Curve, Formula, LearnedPart, Quantity

    Shown = TypeVar("Shown", ParameterEstimate, Quantity)
NUMBERS_OF_COEFFICIENT = ("nominal", "refitted", "refitted_deviation", "improved", "improved_deviation")
UNITS_OF_STATE = {"input": "u", "position": "y", "velocity": "y/s"}


def in_declared_units(diagnosis: Diagnosis) -> Diagnosis:
    """The diagnosis with its numbers as people read them; units are no longer in u, y and s but as they are written.

    It keeps what it is called and how likely that is; sentences were made with these units.
    """
    units = diagnosis.improved.units
    compared = "u" if diagnosis.residual_of == "control" else "y"
    return replace(
        diagnosis,
        location=location_shown(diagnosis.location, units),
        findings=findings_shown(diagnosis.findings, units),
        undetectable=[_undetectable(u, units) for u in diagnosis.undetectable],
        coefficients=coefficients_shown(diagnosis.coefficients, units),
        signals=_signals(diagnosis.signals, units, compared),
        further_signals=[_signals(s, units, compared) for s in diagnosis.further_signals],
        effect_signals=[_effect_signals(each, units) for each in diagnosis.effect_signals],
        learned=[learned_shown(part, units) for part in diagnosis.learned],
        known_remainder=units.shown(diagnosis.known_remainder, compared),
    )


def with_declared(content: dict[str, Any], diagnosis: Diagnosis) -> dict[str, Any]:
    """The content of diagnosis.json, which is in SI units, with what people read beside the values.

    ``units`` says what u and y stand for, and ``declared`` holds value, standard deviation and unit.
    """
    shown = in_declared_units(diagnosis)
    found = [each.to_mapping() for each in shown.findings] + [each.to_mapping() for each in shown.learned_by_share]
    for stated, one in zip(content["effects"], found, strict=True):
        for group in ("parameters", "formula_parameters"):
            for name, parameter in stated.get(group, {}).items():
                parameter["declared"] = one[group][name]
    for stated, effect in zip(content["undetectable"], shown.undetectable, strict=True):
        stated["reason"] = effect.reason
        if stated["smallest_detectable"] is not None:
            stated["smallest_detectable"]["declared"] = {"value": effect.value, "unit": effect.unit}
    for stated, coefficient in zip(content["coefficients"], shown.coefficients, strict=True):
        stated["declared"] = {name: getattr(coefficient, name) for name in (*NUMBERS_OF_COEFFICIENT, "unit")}
    if (state := content["location"]["state"]) is not None and shown.location.state is not None:
        variable, low, high = shown.location.state
        state["unit"] = UNITS_OF_STATE[variable]
        state["declared"] = {"range": [low, high], "unit": diagnosis.improved.units.text(state["unit"])}
    return content | {"units": diagnosis.improved.units.to_mapping()}


def location_shown(location: Location, units: DeclaredUnits) -> Location:
    """A location with its region as people read it."""
    if location.state is None:
        return location
    variable, *limits = location.state
    low, high = sorted(units.shown(limits, UNITS_OF_STATE[variable]))
    return replace(location, state=(variable, low, high))


def findings_shown(found: Sequence[Finding], units: DeclaredUnits) -> list[Finding]:
    """Findings with their parameters as people read them."""
    return [
        replace(finding, parameters={name: _estimate(p, units) for name, p in finding.parameters.items()})
        for finding in found
    ]


def _estimate(estimate: Shown, units: DeclaredUnits) -> Shown:
    return replace(
        estimate,
        value=units.shown(estimate.value, estimate.unit),
        standard_deviation=units.shown(estimate.standard_deviation, estimate.unit),
        unit=units.text(estimate.unit),
    )


def coefficients_shown(coefficients: Sequence[Coefficient], units: DeclaredUnits) -> list[Coefficient]:
    """Coefficients as people read them; named constants stay in the units that the plant declares for them."""
    return [
        c
        if c.declared_by_plant
        else replace(
            c,
            unit=units.text(c.unit),
            **{name: units.shown(getattr(c, name), c.unit) for name in NUMBERS_OF_COEFFICIENT},
        )
        for c in coefficients
    ]


def _undetectable(effect: Undetectable, units: DeclaredUnits) -> Undetectable:
    shape = ", ".join(
        f"{name.replace('_', ' ')} {plain(units.shown(value, unit), 3, units.text(unit))}"
        for name, (value, unit) in effect.shape.items()
    )
    return replace(
        effect,
        value=units.shown(effect.value, effect.unit),
        neutral=units.shown(effect.neutral, effect.unit),
        shows_above=effect.shows_above == (units.factor(effect.unit) > 0.0),
        unit=units.text(effect.unit),
        reason=f"{effect.reason} (at {shape})".replace(SPACE, " ") if shape else effect.reason,
    )


def _signals(signals: Signals, units: DeclaredUnits, compared: str) -> Signals:
    kinds = {
        "signal": "u",
        **dict.fromkeys(("recorded", "nominal", "refitted", "improved"), compared),
        "position": "y",
        "velocity": "y/s",
        "equivalent_input": "u",
    }
    return replace(signals, **{name: units.shown(getattr(signals, name), unit) for name, unit in kinds.items()})


def _effect_signals(shown: EffectSignals, units: DeclaredUnits) -> EffectSignals:
    kinds = {"position": "y", "velocity": "y/s", "rate": "y/s", **dict.fromkeys(("data", "law", "seen"), shown.unit)}
    return replace(shown, **{name: units.shown(getattr(shown, name), unit) for name, unit in kinds.items()})


def learned_shown(part: LearnedPart, units: DeclaredUnits) -> LearnedPart:
    """A law without a name as people read it."""
    return replace(
        part,
        knots=units.shown(part.knots, part.knot_unit),
        values=units.shown(part.values, part.unit),
        standard_deviations=units.shown(part.standard_deviations, part.unit),
        knot_unit=units.text(part.knot_unit),
        unit=units.text(part.unit),
        visited=None if part.visited is None else _limits(units.shown(list(part.visited), part.knot_unit)),
        formula=None if part.formula is None else formula_shown(part.formula, part, units),
        rivals=[formula_shown(formula, part, units) for formula in part.rivals],
        curve=None if part.curve is None else _curve(part.curve, part, units),
    )


def _limits(values: Sequence[float]) -> tuple[float, float]:
    return min(values), max(values)


def _curve(curve: Curve, part: LearnedPart, units: DeclaredUnits) -> Curve:
    return replace(
        curve,
        knots=units.shown(curve.knots, part.knot_unit),
        values=units.shown(curve.values, part.unit),
        standard_deviations=units.shown(curve.standard_deviations, part.unit),
    )


def formula_shown(formula: Formula, part: LearnedPart, units: DeclaredUnits) -> Formula:
    """A formula of a law, which is in SI units, as people read it."""
    heights, knots = units.factor(part.unit), units.factor(part.knot_unit)
    slopes = {"constant": heights, "slope": heights / knots}
    return replace(
        formula.with_length(None if formula.length is None else formula.length / knots),
        parameters={name: _estimate(quantity, units) for name, quantity in formula.parameters.items()},
        held={name: value / slopes[name] for name, value in formula.held.items()},
        points=units.shown(formula.points, part.knot_unit),
        values=units.shown(formula.values, part.unit),
        carried=units.shown(formula.carried, part.unit),
    )
