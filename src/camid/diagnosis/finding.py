"""An effect that a diagnosis has found: its parameters, the evidence for it, and what cannot be told apart from it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from camid.diagnosis.weights import UNLISTED, Comparison


@dataclass(frozen=True)
class ParameterEstimate:
    """A parameter of an effect: value, standard deviation and unit (in u, y and s).

    Where the fit ends at a bound of the parameter the curvature there is no standard deviation: it has none. Nor has a
    number that was stated for others to be counted by.
    """

    value: float | str
    standard_deviation: float | None
    unit: str
    at_bound: bool = False
    stated: bool = False

    def to_mapping(self) -> dict[str, Any]:
        """Part of diagnosis.json."""
        return {"value": self.value, "std": self.standard_deviation, "unit": self.unit}


@dataclass(frozen=True)
class Finding:
    """An effect that the recording supports, and what cannot be told apart from it.

    Attributes
    ----------
    identifier, place, title : str
    equation : str
        LaTeX, without dollar signs.
    reference : str
    parameters : dict of str to ParameterEstimate
    evidence : dict
        Numbers behind the claim: ``delta_bic`` (against leaving the effect out), ``share`` (of the refitted error's
        sum of squares that it removes beside the others), ``share_together`` (that several remove together),
        ``validation_gain`` (as ``share``, on rows not fitted), ``nrmse_without`` (the normalised error on rows not
        fitted that the simulation has without it), …
    weight : float
        Posterior weight of this effect within its class; with those of the alternatives it sums to one.
    alternatives : list of (str, float)
        What this recording cannot tell apart from it, with weights; ``unlisted`` is physics outside the catalogue.
    separating_experiment : str or None
    comparison : Comparison or None
        What the weights are made from; not part of diagnosis.json.
    simulated : bool
        Whether the improved simulation holds it; a law without a name that it only resembles may stand in its place.
    certain : bool
        Of an effect on the noise whether it shows beside whatever structure the residual has.
    """

    identifier: str
    place: str
    title: str
    equation: str
    reference: str
    parameters: dict[str, ParameterEstimate]
    evidence: dict[str, Any]
    weight: float = 1.0
    alternatives: list[tuple[str, float]] = field(default_factory=list)
    separating_experiment: str | None = None
    comparison: Comparison | None = None
    simulated: bool = True
    certain: bool = False

    @property
    def named(self) -> float:
        """Weight of all its names together; what they leave is that of physics outside the catalogue."""
        return self.weight + sum(weight for name, weight in self.alternatives if name != UNLISTED)

    def to_mapping(self) -> dict[str, Any]:
        """Part of diagnosis.json."""
        return {
            "id": self.identifier,
            "place": self.place,
            "parameters": {name: p.to_mapping() for name, p in self.parameters.items()},
            "evidence": self.evidence,
            "weight": self.weight,
            "alternatives": [{"id": name, "weight": weight} for name, weight in self.alternatives],
            "separating_experiment": self.separating_experiment,
            "simulated": self.simulated,
        }
