"""What ``camid.identify`` and ``camid.diagnose`` return: the result, and the pictures of it as methods."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from html import escape
from typing import TYPE_CHECKING, Any, Self

from camid.analysis.view import ShortTable, html_table
from camid.diagnosis.diagnosis import Diagnosis
from camid.diagnosis.in_declared_units import in_declared_units
from camid.diagnosis.report.summary import estimate_text
from camid.effects.own_effects import own_effects
from camid.identification.from_recordings import RecordingSource
from camid.identification.identification import Identification
from camid.number_text import percentage, with_deviation
from camid.simulation.model import Simulation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from camid.analysis.comparison import Comparison
    from camid.analysis.frequency_response import FrequencyResponses
    from camid.analysis.models import ModelSource
    from camid.analysis.poles_and_zeros import PolesAndZeros
    from camid.analysis.residual_correlations import ResidualCorrelations
    from camid.analysis.step_response import StepResponses

# Lines of a repr between the first and the last.
MOST_LINES = 8


class Drawable(ABC):
    """A result of which pictures can be drawn; every method returns what the function of that name returns."""

    @abstractmethod
    def _recording(self) -> RecordingSource:
        """What is drawn beside the models where nothing else is named."""

    @abstractmethod
    def _sources(self) -> list[RecordingSource]:
        """All recordings."""

    def _beside(self) -> list[ModelSource]:
        """Models that are drawn before this result."""
        return []

    def _simulated_beside(self) -> list[ModelSource]:
        """Those of them that can be simulated."""
        return self._beside()

    def _held_out(self) -> tuple[float, float] | None:
        return None

    def _own_files(self) -> Sequence[str]:
        """Files with effects of a user's own that the result names."""
        return ()

    def plot(self) -> Figure:
        """Recorded and simulated output over time, as a figure of matplotlib: the picture of :meth:`compare`."""
        return self.compare().figure()

    def compare(
        self,
        *others: ModelSource,
        recording: RecordingSource | None = None,
        held_out: tuple[float, float] | None = None,
        zoom: tuple[float, float] | None = None,
    ) -> Comparison:
        """Fit in per cent to a recording, beside that of other models; see :func:`camid.compare`."""
        from camid.commands.compare import compare

        part = self._held_out() if held_out is None and recording is None else held_out
        source = self._recording() if recording is None else recording
        with own_effects(self._own_files()):
            return compare(source, *self._simulated_beside(), self, *others, held_out=part, zoom=zoom)

    def bode(
        self,
        *others: ModelSource,
        recording: RecordingSource | bool | None = None,
        camera: bool = False,
        frequencies: tuple[float, float] | None = None,
        segment: float | None = None,
    ) -> FrequencyResponses:
        """Frequency response with a band, beside those of other models; see :func:`camid.bode`.

        ``recording=True`` draws the empirical response of the recording that the result is from.
        """
        from camid.commands.bode import bode

        source = self._recording() if recording is True else None if recording is False else recording
        models = (*self._beside(), self, *others)
        with own_effects(self._own_files()):
            return bode(*models, recording=source, camera=camera, frequencies=frequencies, segment=segment)

    def residuals(self, recording: RecordingSource | None = None) -> ResidualCorrelations:
        """Correlations of the residual with itself and with the input; see :func:`camid.residuals`."""
        from camid.commands.residuals import residuals

        with own_effects(self._own_files()):
            return residuals(self._sources() if recording is None else recording, self)

    def poles(self, *others: ModelSource) -> PolesAndZeros:
        """Poles and zeros with ellipses, beside those of other models; see :func:`camid.poles`."""
        from camid.commands.poles import poles

        with own_effects(self._own_files()):
            return poles(*self._beside(), self, *others)

    def step(self, *others: ModelSource, amplitude: float = 1.0, duration: float | None = None) -> StepResponses:
        """Step response with a band, beside those of other models; see :func:`camid.step`."""
        from camid.commands.step import step

        with own_effects(self._own_files()):
            return step(*self._beside(), self, *others, amplitude=amplitude, duration=duration)


@dataclass(frozen=True, repr=False, eq=False)
class IdentificationResult(Identification, Drawable):
    """An :class:`~camid.identification.identification.Identification` that draws itself.

    Attributes
    ----------
    sources : tuple
        The recordings, as they were given.
    """

    sources: tuple[RecordingSource, ...] = field(default=(), kw_only=True)

    @classmethod
    def of(cls, found: Identification, sources: Sequence[RecordingSource]) -> Self:
        """The same identification with its recordings."""
        return cls(**_values(found, Identification), sources=tuple(sources))

    def _recording(self) -> RecordingSource:
        return self.sources[0]

    def _sources(self) -> list[RecordingSource]:
        return [*self.sources]

    def _rows(self) -> list[tuple[str, str, str]]:
        """Quantity, estimate and unit of what describes the plant."""
        return [(name, with_deviation(v, d), unit) for group in self.quantities() for name, v, d, unit in group]

    def _headline(self) -> str:
        state = "converged" if self.converged else "NOT CONVERGED"
        validation = "" if self.nrmse_validation is None else f", {percentage(self.nrmse_validation)} on held-out rows"
        return f"{state}, residual {percentage(self.nrmse)}{validation}, {self.rows_fitted} rows fitted"

    def __repr__(self) -> str:
        lines = [f"{name}: {value} {unit}".rstrip() for name, value, unit in self._rows()]
        return _few_lines(f"<Identification: {self._headline()}", lines)

    def _repr_html_(self) -> str:
        """Table of the estimates and what limits them, for a notebook."""
        headings = ("quantity", "value ± standard deviation", "unit")
        table = html_table(ShortTable(f"Identified plant: {self._headline()}", headings, self._rows()))
        return f"<div>{table}{_html_list(self.warnings())}</div>"


@dataclass(frozen=True, repr=False, eq=False)
class DiagnosisResult(Diagnosis, Drawable):
    """A :class:`~camid.diagnosis.diagnosis.Diagnosis` that draws itself, beside the simulation that was believed.

    Attributes
    ----------
    sources : tuple
        The recordings, as they were given.
    believed : Simulation
    """

    sources: tuple[RecordingSource, ...] = field(default=(), kw_only=True)
    believed: Simulation = field(kw_only=True)

    @classmethod
    def of(cls, found: Diagnosis, sources: Sequence[RecordingSource], believed: Simulation) -> Self:
        """The same diagnosis with its recordings and what was believed."""
        return cls(**_values(found, Diagnosis), sources=tuple(sources), believed=believed)

    def _recording(self) -> RecordingSource:
        return self.sources[-1]  # which validates, where there are several

    def _sources(self) -> list[RecordingSource]:
        return [*self.sources]

    def _beside(self) -> list[ModelSource]:
        return [self.believed]

    def _simulated_beside(self) -> list[ModelSource]:
        # Frames cannot be placed by a latency or a clock that was left open; the improved simulation knows both.
        return [] if "estimate" in (self.believed.latency, self.believed.skew) else self._beside()

    def _own_files(self) -> Sequence[str]:
        return self.own_files

    def _held_out(self) -> tuple[float, float] | None:
        return self.fit.validation

    def _rows(self) -> list[tuple[str, str, str]]:
        """Effect, weight, and its parameters."""
        rows = []
        for finding in in_declared_units(self).findings:
            parameters = ", ".join(f"{name} {estimate_text(p)}" for name, p in finding.parameters.items())
            rows.append((finding.identifier, percentage(finding.weight, 2), parameters))
        return rows

    def _headline(self) -> str:
        errors = self.fit
        return (
            f"{self.verdict_in_words}; error on held-out rows {percentage(errors.as_given)} as given, "
            f"{percentage(errors.refitted)} re-estimated, {percentage(errors.improved)} improved, "
            f"{percentage(errors.noise_floor)} noise"
        )

    def __repr__(self) -> str:
        lines = [f"{name} (weight {weight}): {parameters}" for name, weight, parameters in self._rows()]
        return _few_lines(f"<Diagnosis: {self._headline()}", lines)

    def _repr_html_(self) -> str:
        """Explanation and effects, for a notebook."""
        title = f"Diagnosis: {self._headline()}"
        table = html_table(ShortTable(title, ("effect", "weight", "parameters"), self._rows()))
        return f"<div>{table}<p>{escape(self.explanation)}</p>{_html_list(self.warnings)}</div>"


def _values(found: Any, kind: type) -> dict[str, Any]:
    return {f.name: getattr(found, f.name) for f in fields(kind)}


def _few_lines(first: str, lines: Sequence[str]) -> str:
    """At most ten lines."""
    shown = (
        [*lines] if len(lines) <= MOST_LINES else [*lines[: MOST_LINES - 1], f"… {len(lines) - MOST_LINES + 1} more"]
    )
    return "\n".join([first, *(f"  {line}" for line in shown)]) + ">"


def _html_list(sentences: Sequence[str]) -> str:
    return f"<ul>{''.join(f'<li>{escape(s)}</li>' for s in sentences)}</ul>" if sentences else ""
