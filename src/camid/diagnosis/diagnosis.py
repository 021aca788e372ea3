"""What a diagnosis says: the verdict, the place, the effects, the fit, and what the recording could not have shown."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.finding import Finding
from camid.diagnosis.in_declared_units import with_declared
from camid.diagnosis.learned_part import LearnedPart
from camid.diagnosis.normalised_errors import NormalisedErrors
from camid.diagnosis.provenance import Provenance
from camid.diagnosis.swinging_coefficient import Swing
from camid.simulation.declared_units import SignalUnit
from camid.simulation.model import Simulation

if TYPE_CHECKING:
    from camid.analysis.diagnosed_responses import DiagnosedResponses
    from camid.analysis.frequency_response import FrequencyResponses
    from camid.diagnosis.effect_signals import EffectSignals
    from camid.diagnosis.remaining_hypotheses import Conditions, RemainingHypothesis

Array = NDArray[np.float64]

# What the simulations before and after are called in pictures.
AS_GIVEN, REFITTED, IMPROVED = "as given", "re-estimated", "improved"
# Factor of a coefficient from which the refit has run away from what it is.
FAR_OFF = 30.0


@dataclass(frozen=True)
class Location:
    """Where in the chain, when, at which frequencies and in which region of a signal the mismatch sits.

    Attributes
    ----------
    place : str or None
        ``actuator``, ``plant``, ``disturbance``, ``sensor`` or ``noise``; None where nothing is left out.
    places : dict of str to float
        Share of each place in the mismatch; they add up to one.
    time : tuple of float or None
        Span in seconds, where the mismatch is not spread over the whole recording.
    frequency : tuple of float or None
        Band in hertz.
    state : tuple of (str, float, float) or None
        Variable (``input``, ``position`` or ``velocity``) and range in its units.
    """

    place: str | None = None
    places: dict[str, float] = field(default_factory=dict)
    time: tuple[float, float] | None = None
    frequency: tuple[float, float] | None = None
    state: tuple[str, float, float] | None = None

    def to_mapping(self) -> dict[str, Any]:
        """Part of diagnosis.json."""
        state = self.state and {"variable": self.state[0], "range": [self.state[1], self.state[2]]}
        return {
            "place": self.place,
            "places": [
                {"place": place, "share": share} for place, share in sorted(self.places.items(), key=lambda p: -p[1])
            ],
            "time": self.time and list(self.time),
            "frequency": self.frequency and list(self.frequency),
            "state": state or None,
        }


@dataclass(frozen=True)
class Undetectable:
    """An effect that was not found, and the smallest size at which this recording would have shown it.

    Attributes
    ----------
    identifier, reason : str
    parameter, unit : str or None
    value : float or None
        Detected in about 95 % of recordings like this one; None where no size would have shown.
    others : dict
        Values of the effect's other parameters at which this holds.
    shape : dict
        Values and units of those of them that are numbers.
    neutral : float or None
        Value of the parameter that means no effect; None where no number does.
    shows_above : bool
        Whether larger values would have shown, and not smaller ones, as of a limit.
    shows : bool
        Whether an effect without a number, so that it has no smallest size, would have shown.
    """

    identifier: str
    reason: str
    parameter: str | None = None
    value: float | None = None
    unit: str | None = None
    others: dict[str, Any] = field(default_factory=dict)
    shows: bool = False
    shape: dict[str, tuple[float, str]] = field(default_factory=dict)
    neutral: float | None = None
    shows_above: bool = True

    @property
    def would_show(self) -> bool:
        """Whether this recording would have shown it, at some size if it has one."""
        return self.shows or self.value is not None

    def to_mapping(self) -> dict[str, Any]:
        """Part of diagnosis.json."""
        smallest = None
        if self.value is not None:
            side = "above" if self.shows_above else "below"
            smallest = {"parameter": self.parameter, "value": self.value, "unit": self.unit, "shows": side}
        return {
            "id": self.identifier,
            "reason": self.reason,
            "smallest_detectable": smallest,
            "at": self.others,
            "would_show": self.would_show,
        }


@dataclass(frozen=True)
class Coefficient:
    """A coefficient of the plant as believed, refitted alone, and fitted together with the effects.

    Attributes
    ----------
    name : str
    nominal, refitted, improved : float
    refitted_deviation, improved_deviation : float
        Standard deviations; zero where it is fixed.
    unit : str
        In u, y and s; of a named constant that which the plant declares.
    declared_by_plant : bool
        Whether it is such a constant.
    """

    name: str
    nominal: float
    refitted: float
    refitted_deviation: float
    improved: float
    improved_deviation: float
    unit: str = ""
    declared_by_plant: bool = False

    @property
    def ran_away(self) -> bool:
        """Whether the refit alone found no plant that is anything like the one which is left with the effects."""
        return abs(self.refitted) > FAR_OFF * abs(self.improved) > 0.0


@dataclass(frozen=True)
class Signals:
    """What the pictures of the report show and residuals.csv holds, one entry per row of a recording.

    Attributes
    ----------
    time, signal, recorded : ndarray, shape (N,)
        Seconds, input, output.
    nominal, refitted, improved : ndarray, shape (N,)
        Simulated outputs.
    position : ndarray, shape (N,)
        Of the refitted simulation; in a closed loop, where recorded and simulated values are those of the control, it
        is the motion.
    velocity : ndarray, shape (N,)
        Of the refitted simulation, in units of y per second.
    equivalent_input : ndarray, shape (N,)
        The refitted residual as an input that would have caused it, in units of u, smoothed to what the data carry.
    fitted : ndarray of bool, shape (N,)
        Rows that were fitted.
    validates : ndarray of bool, shape (N,)
        Rows that judge; those that are neither say nothing of the motion, or nobody knows what drove it there.
    """

    time: Array
    signal: Array
    recorded: Array
    nominal: Array
    refitted: Array
    improved: Array
    position: Array
    velocity: Array
    equivalent_input: Array
    fitted: NDArray[np.bool_]
    validates: NDArray[np.bool_]


@dataclass(frozen=True)
class StructureTest:
    """One of the tests for structure: what it asks, and its p-value before and after the effects were modelled."""

    name: str
    question: str
    before: float | None
    after: float | None


@dataclass(frozen=True)
class Diagnosis:
    """Everything that diagnosis.json, improved.yaml, residuals.csv and report.html say.

    Attributes
    ----------
    verdict, explanation : str
    location : Location
    findings : list of Finding
        The strongest first.
    fit : NormalisedErrors
    undetectable : list of Undetectable
    coefficients : list of Coefficient
    tests : list of StructureTest
    signals : Signals
        Of the first recording.
    improved : Simulation
    recordings : list of str
        Where they were read from.
    rows_fitted : int
    period : float
        Seconds, of the first recording.
    seconds : float
        How long the diagnosis took.
    warnings : list of str
        What was done to the rows of the recordings before.
    residual_of : str
        What recorded and simulated values are of: the ``output`` or, in a closed loop, the ``control``.
    known_remainder : float or None
        Root mean square of what the simulation declares to be unexplained, where the verdict rests on it.
    further_signals : list of Signals
        Of the other recordings, in the order of ``recordings``.
    learned : list of LearnedPart
        Laws of the improved simulation that have no name.
    structured : bool
        Whether what the improved simulation leaves is more than noise.
    swing : Swing or None
        A coefficient that swings in time, where what names leave shows one.
    own_titles : dict of str to str
        What a user's own effects are called, by identifier.
    own_files : list of str
        Files that they were read from.
    hypotheses : list of RemainingHypothesis
        What the next experiment may have to tell apart.
    conditions : Conditions or None
        How the recordings were made.
    effect_signals : list of EffectSignals
        What the first recording shows of the effects that are named, and of the learned laws.
    refitted : Simulation or None
        As given, its coefficients re-estimated.
    response_source : DiagnosedResponses or None
        What the frequency responses are made from.
    provenance : Provenance or None
        Where all of this comes from.
    """

    verdict: str
    explanation: str
    location: Location
    findings: list[Finding]
    fit: NormalisedErrors
    undetectable: list[Undetectable]
    coefficients: list[Coefficient]
    tests: list[StructureTest]
    signals: Signals
    improved: Simulation
    recordings: list[str] = field(default_factory=list)
    rows_fitted: int = 0
    period: float = 0.0
    seconds: float = 0.0
    warnings: list[str] = field(default_factory=list)
    residual_of: str = "output"
    known_remainder: float | None = None
    further_signals: list[Signals] = field(default_factory=list)
    learned: list[LearnedPart] = field(default_factory=list)
    structured: bool = False
    swing: Swing | None = None
    own_titles: dict[str, str] = field(default_factory=dict)
    own_files: list[str] = field(default_factory=list)
    hypotheses: list[RemainingHypothesis] = field(default_factory=list)
    conditions: Conditions | None = None
    effect_signals: list[EffectSignals] = field(default_factory=list)
    refitted: Simulation | None = None
    response_source: DiagnosedResponses | None = None
    provenance: Provenance | None = None

    @property
    def explains_nothing(self) -> bool:
        """Whether nothing structured is left of an output of which the simulation explains hardly anything."""
        return self.verdict == "adequate" and self.known_remainder is None and self.fit.explains_nothing

    @property
    def verdict_in_words(self) -> str:
        """The verdict; that of an adequate simulation says nothing where it explains nothing."""
        return "nothing explained" if self.explains_nothing else self.verdict

    @property
    def responses(self) -> FrequencyResponses | None:
        """Of the plant as given, re-estimated and improved, where it has an input and a linear part."""
        return None if self.response_source is None else self.response_source.found

    @property
    def compared(self) -> str:
        """Column that recorded and simulated values are of: in a closed loop the control."""
        return str(self.improved.input_column) if self.residual_of == "control" else self.improved.output_column

    @property
    def compared_signal(self) -> SignalUnit:
        """Units of that."""
        units = self.improved.units
        return units.input if self.residual_of == "control" else units.output

    @property
    def learned_by_share(self) -> list[LearnedPart]:
        """The laws without a name, the one that removes most first."""
        return sorted(self.learned, key=lambda part: -part.share)

    def to_mapping(self) -> dict[str, Any]:
        """diagnosis.json, version 1 of the design's contract: SI units, and in ``declared`` what people read."""
        content = {
            "schema": 1,
            "verdict": self.verdict,
            "explanation": self.explanation,
            "location": self.location.to_mapping(),
            "effects": [f.to_mapping() for f in self.findings] + [part.to_mapping() for part in self.learned_by_share],
            "fit": self.fit.to_mapping(),
            "undetectable": [u.to_mapping() for u in self.undetectable],
            "coefficients": [{k: v for k, v in vars(c).items() if k != "declared_by_plant"} for c in self.coefficients],
            "tests": [vars(t) for t in self.tests],
            "warnings": self.warnings,
            "hypotheses": [h.to_mapping() for h in self.hypotheses],
            "conditions": None if self.conditions is None else self.conditions.to_mapping(),
        }
        return with_declared(content, self)
