"""What a design says."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.experiment_design.hypothesis import Hypothesis, Played
from camid.experiment_design.limits import Limits

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Expectation:
    """What an experiment is expected to say if one name is right.

    Attributes
    ----------
    identifier : str
        The name that is right.
    rival : str
        The name that comes nearest.
    evidence : float
        Expected difference of Bayes's criterion (twice the natural logarithm of the Bayes factor) against it, after the
        rival was fitted again.
    evidence_per_second : float
    linearised : float
        The same evidence before the rivals were really fitted: to first order.
    weight : float
        That a diagnosis of all recordings would state for the name, among the names.
    seconds : float or None
        After which that is 95 %; None where no experiment of this kind gets there.
    """

    identifier: str
    rival: str
    evidence: float
    evidence_per_second: float
    linearised: float
    weight: float
    seconds: float | None

    def to_mapping(self) -> dict[str, Any]:
        """Part of design.json."""
        return {
            "if_right": self.identifier,
            "nearest_rival": self.rival,
            "delta_bic": self.evidence,
            "delta_bic_per_second": self.evidence_per_second,
            "delta_bic_linearised": self.linearised,
            "weight": self.weight,
            "seconds_to_decide": self.seconds,
        }


@dataclass(frozen=True)
class Determined:
    """A parameter of the likeliest hypothesis: value, and standard deviations before and after the experiment.

    ``unit`` is in u, y and s, or what a plant of named constants declares.
    """

    name: str
    value: float
    before: float
    after: float
    unit: str = ""

    def to_mapping(self) -> dict[str, Any]:
        """Part of design.json."""
        return {"name": self.name, "value": self.value, "std_before": self.before, "std_after": self.after}


@dataclass(frozen=True)
class Design:
    """The next experiment.

    Attributes
    ----------
    hypotheses : list of Hypothesis
        That were compared.
    limits : Limits
    kind : str
        Family of the input.
    described : dict
        Which of its members.
    played : Played
    expectations : list of Expectation
        One for each name; empty where there is nothing to tell apart.
    determined : list of Determined
    outputs : dict of str to ndarray, each of shape (N,)
        What each hypothesis predicts.
    travel : tuple of float
        Least and largest position that any hypothesis predicts.
    others : dict of str to float
        Evidence against the nearest rival, in the mean over the names, of the best experiment of each family; where
        there is nothing to tell apart, the information in nats.
    growth : dict of str to ndarray, each of shape (K,)
        Evidence for each name against its nearest rival after ``growth_times``, to first order.
    growth_times : ndarray, shape (K,)
        Seconds.
    seconds : float
        That the design took.
    looked_at : int
        Experiments that were simulated.
    warnings : list of str
    source : str
        What it was made from.
    """

    hypotheses: list[Hypothesis]
    limits: Limits
    kind: str
    described: dict[str, Any]
    played: Played
    expectations: list[Expectation]
    determined: list[Determined]
    outputs: dict[str, Array]
    travel: tuple[float, float]
    others: dict[str, float]
    growth: dict[str, Array] = field(default_factory=dict)
    growth_times: Array = field(default_factory=lambda: np.zeros(0))
    seconds: float = 0.0
    looked_at: int = 0
    warnings: list[str] = field(default_factory=list)
    source: str = ""

    @property
    def duration(self) -> float:
        """Seconds of the experiment."""
        return len(self.played.signal) * self.played.period

    @property
    def evidence(self) -> float | None:
        """Expected evidence against the nearest rival, in the mean over the names by their weights; None without."""
        if not self.expectations:
            return None
        weights = {h.identifier: h.weight for h in self.hypotheses}
        total = sum(weights[e.identifier] for e in self.expectations) or 1.0
        return sum(weights[e.identifier] * e.evidence for e in self.expectations) / total

    @property
    def seconds_to_decide(self) -> float | None:
        """After which one name has 95 %, whichever is right; None where none gets there for some."""
        found = [e.seconds for e in self.expectations]
        return None if not found or any(s is None for s in found) else max(s for s in found if s is not None)

    def to_mapping(self) -> dict[str, Any]:
        """design.json, version 1."""
        limits, played, evidence = self.limits, self.played, self.evidence
        return {
            "schema": 1,
            "source": self.source,
            "hypotheses": [
                {"id": h.identifier, "weight": h.weight, "instead_of": h.question}
                for h in self.hypotheses
                if h.identifier
            ],
            "limits": {
                "amplitude": {"low": limits.low, "high": limits.high},
                "rate": limits.rate,
                "duration": limits.duration,
                "travel": None if limits.travel is None else {"low": limits.travel[0], "high": limits.travel[1]},
            },
            "experiment": {
                "kind": self.kind,
                "parameters": self.described,
                "rows": len(played.signal),
                "duration": self.duration,
                "frame_rate": 1.0 / played.period,
                "exposure": played.exposure,
                "initial_position": played.position,
                "travel": {"low": self.travel[0], "high": self.travel[1]},
            },
            "evidence": None
            if evidence is None
            else {
                "unit": "difference of the Bayesian information criterion, as in diagnosis.json",
                "delta_bic": evidence,
                "delta_bic_per_second": evidence / self.duration,
                "seconds_to_decide": self.seconds_to_decide,
                "names": [e.to_mapping() for e in self.expectations],
            },
            "parameters": [d.to_mapping() for d in self.determined],
            "candidates": [{"kind": kind, "score": score} for kind, score in self.others.items()],
            "warnings": self.warnings,
        }
