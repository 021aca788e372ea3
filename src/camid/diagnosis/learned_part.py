"""A law without a name, as a diagnosis says it."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp
from typing import Any

from camid.diagnosis.weights import UNLISTED


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
    formula : str or None
        A short formula that says as much; None where none is known.
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
    formula: str | None = None

    @property
    def name(self) -> str:
        """What it is, in words: Learned force over the velocity."""
        kind, _, over = self.variables.rpartition(" over ")
        return f"Learned {kind} over the {over}" if kind else f"{self.title} over the {self.variables}"

    def to_mapping(self) -> dict[str, Any]:
        """Part of diagnosis.json: an effect that claims no name, so that all of its weight is outside the catalogue."""
        return {
            "id": self.identifier,
            "place": self.place,
            "variables": self.variables,
            "knots": self.knots,
            "values": self.values,
            "standard_deviations": self.standard_deviations,
            "formula": self.formula,
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
        }
