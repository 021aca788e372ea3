"""A law without a name, as a diagnosis says it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import exp
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.weights import UNLISTED
from camid.number_text import SPACE, plain, with_deviation

LENGTH = "X"  # in expressions


@dataclass(frozen=True)
class Quantity:
    """A number of a formula: value, standard deviation and unit (in u, y and s)."""

    value: float
    standard_deviation: float | None
    unit: str

    def to_mapping(self) -> dict[str, Any]:
        """Part of diagnosis.json."""
        return {"value": self.value, "std": self.standard_deviation, "unit": self.unit}


@dataclass(frozen=True)
class Formula:
    """A formula for a learned law.

    Attributes
    ----------
    form : str
        What it is, in words.
    expression : str
        With names for its numbers; x, y, u and v = ẏ in the units of the recording.
    parameters : dict of str to Quantity
    replaces : list of str
        Identifiers of the effects that it stands for together with the learned law.
    held : dict of str to float
        ``constant`` and ``slope`` of it that the coefficients of the improved simulation hold already.
    points, values : list of float
        The formula without that, and without the effects that it stands for: what the learned law has to be compared
        with.
    carried : list of float
        What those effects hold of the law, at the points.
    pattern : str
        The expression with ``LENGTH`` where it divides its variable by a length.
    length : float or None
        That length, in units of the variable; None where it divides by none.
    """

    form: str
    expression: str
    parameters: dict[str, Quantity]
    replaces: list[str] = field(default_factory=list)
    held: dict[str, float] = field(default_factory=dict)
    points: list[float] = field(default_factory=list)
    values: list[float] = field(default_factory=list)
    carried: list[float] = field(default_factory=list)
    pattern: str = ""
    length: float | None = None

    def with_length(self, length: float | None) -> Formula:
        """The same with another number in the expression, as another unit of its variable asks for."""
        if length is None:
            return self
        return replace(self, length=length, expression=self.pattern.replace(LENGTH, plain(length)))

    @property
    def text(self) -> str:
        """Expression and numbers in one line, in u, y and s."""
        numbers = [
            f"{name} = {with_deviation(p.value, p.standard_deviation, p.unit)}" for name, p in self.parameters.items()
        ]
        return ", ".join([self.expression, *numbers]).replace(SPACE, " ")


@dataclass(frozen=True)
class Curve:
    """A learned curve: knots, values and their standard deviations."""

    knots: list[float]
    values: list[float]
    standard_deviations: list[float]


def over_visited(
    visited: tuple[float, float] | None, points: Sequence[float], *values: Sequence[float]
) -> tuple[NDArray[np.float64], ...]:
    """Points of a curve over what a recording visits, its ends among them, and values there."""
    at = np.asarray(points, dtype=float)
    if visited is not None:
        low, high = max(visited[0], float(at[0])), min(visited[1], float(at[-1]))
        if low < high:
            at = np.concatenate([[low], at[(at > low) & (at < high)], [high]])
    return at, *(np.interp(at, points, each) for each in values)


@dataclass(frozen=True)
class LearnedPart:
    """A law without a name that the improved simulation holds for what the laws of the findings leave.

    Attributes
    ----------
    identifier, place, title, variables : str
        ``variables`` is what it depends on.
    knots, values, standard_deviations : list of float
    knot_unit, unit : str
        In u, y and s.
    log_evidence : float
        Natural logarithm of the evidence for the law against none.
    share : float
        Of the refitted sum of squares that it removes, fitted rows.
    formula : Formula or None
        A short formula that says as much; None where none is known, or several do.
    rivals : list of Formula
        Formulas that say as much and cannot be told apart.
    description : str
        The law in words; empty where nothing is known.
    curve : Curve or None
        The learned curve that a formula was compared with, where the values are those of the formula.
    visited : tuple of float or None
        Where the middle 98 % of the fitted rows lie: at the ends of its knots few rows, or none, say what it is.
    """

    identifier: str
    place: str
    title: str
    variables: str
    knots: list[float]
    values: list[float]
    standard_deviations: list[float]
    knot_unit: str
    unit: str
    log_evidence: float
    share: float
    formula: Formula | None = None
    rivals: list[Formula] = field(default_factory=list)
    description: str = ""
    curve: Curve | None = None
    visited: tuple[float, float] | None = None

    @property
    def sits_at(self) -> str:
        """Place of the mismatch that it explains: what multiplies the input is the actuator's."""
        return "actuator" if self.variables.startswith("gain over") else self.place

    @property
    def largest(self) -> float:
        """The largest of what was learned over what the recording visits, without its sign."""
        heights = over_visited(self.visited, self.learned.knots, self.heights)[1]
        return float(np.max(np.abs(heights)))

    @property
    def heights(self) -> list[float]:
        """What was learned: of a curve by how much it bends."""
        learned = self.learned
        if self.identifier != "learned-curve":
            return learned.values
        return [value - knot for value, knot in zip(learned.values, learned.knots, strict=True)]

    @property
    def learned(self) -> Curve:
        """The curve that was learned, whatever the improved simulation holds."""
        return self.curve or Curve(self.knots, self.values, self.standard_deviations)

    @property
    def name(self) -> str:
        """What it is, in words: Learned force over the velocity."""
        kind, _, over = self.variables.rpartition(" over ")
        return f"Learned {kind} over the {over}" if kind else f"{self.title} over the {self.variables}"

    @property
    def drawn(self) -> list[Formula]:
        """The formula, or those that cannot be told apart."""
        return self.rivals if self.formula is None else [self.formula]

    def formula_mapping(self) -> dict[str, Any]:
        """Part of diagnosis.json: the formula, its numbers, and the law in words."""
        if self.formula is None:
            alike = [formula.text for formula in self.rivals]
            return {"formula": None, "formula_rivals": alike, "description": self.description}
        return {
            "formula": self.formula.text,
            "formula_parameters": {name: q.to_mapping() for name, q in self.formula.parameters.items()},
            "formula_replaces": self.formula.replaces,
            "formula_held": self.formula.held,
            "formula_rivals": [],
            "description": self.description,
        }

    def to_mapping(self) -> dict[str, Any]:
        """Part of diagnosis.json: an effect that claims no name, so that all of its weight is outside the catalogue."""
        return {
            "id": self.identifier,
            "place": self.place,
            "variables": self.variables,
            "knots": self.knots,
            "visited": None if self.visited is None else list(self.visited),
            "values": self.values,
            "standard_deviations": self.standard_deviations,
            "values_from": "curve" if self.curve is None else "formula",
            **self.formula_mapping(),
            "parameters": {
                "variables": {"value": self.variables, "std": None, "unit": ""},
                "knots": {"value": self.knots, "std": None, "unit": self.knot_unit},
                "values": {"value": self.values, "std": self.standard_deviations, "unit": self.unit},
            },
            "evidence": {
                "share": self.share,
                "validation_gain": None,
                # Where there is nothing, evidence of x to one turns up with a probability of at most 1/x (Markov).
                "false_alarm_probability": min(exp(-self.log_evidence), 1.0),
                "log_evidence": self.log_evidence,
            },
            "weight": 0.0,
            "alternatives": [{"id": UNLISTED, "weight": 1.0}],
            "separating_experiment": None,
            "simulated": True,
        }
