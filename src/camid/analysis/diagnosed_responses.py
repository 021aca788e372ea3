"""Frequency responses before and after a diagnosis, for its report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np

from camid.analysis.empirical_response import EmpiricalResponse, empirical_response
from camid.analysis.frequency_response import FrequencyResponses, ResponseCurve, frequencies_for
from camid.analysis.linear_model import linear_models, units_of
from camid.errors import InputError
from camid.recording.recording import Recording
from camid.simulation.model import Simulation

# Of the longest recording, that the longest period may have.
LARGEST_SHARE = 0.1


@dataclass(frozen=True)
class DiagnosedResponses:
    """What frequency responses are made from: the report needs them alone, and its process makes them beside.

    Attributes
    ----------
    models : mapping of str to Simulation
        By the names that a legend calls them.
    recordings : sequence of Recording
    """

    models: Mapping[str, Simulation]
    recordings: Sequence[Recording]

    @cached_property
    def found(self) -> FrequencyResponses | None:
        """Responses of the plants over the frequencies that a recording holds, and its own beside them.

        None without an input, and where a plant has no linear part; without the recording's response where it shows
        none.
        """
        first = next(iter(self.models.values()))
        if first.input_column is None:
            return None
        period = self.recordings[0].period
        longest = max(len(one) for one in self.recordings) * period
        limits = 2.0 * pi / (LARGEST_SHARE * longest), pi / period
        try:
            linear = linear_models(self.models)
        except InputError:
            return None
        empirical = _shown_by(self.recordings, first)
        if limits[0] >= limits[1]:
            return None
        if empirical is not None and len(empirical.angular_frequency):
            limits = min(limits[0], float(empirical.angular_frequency[0])), limits[1]
        omega = frequencies_for(linear, limits, None)
        curves = [ResponseCurve.of(model, omega, None) for model in linear]
        if not all(np.any(np.isfinite(c.magnitude) & (c.magnitude > 0.0)) for c in curves):
            return None
        remarks = tuple(sentence for model in linear for sentence in model.linearised)
        return FrequencyResponses(curves, empirical, False, units_of(first), remarks)


def _shown_by(recordings: Sequence[Recording], simulation: Simulation) -> EmpiricalResponse | None:
    """What recordings show of the response; None where they show nothing of it."""
    if simulation.output_columns:
        return None
    try:
        return empirical_response([*recordings], simulation, seen_by_camera=False)
    except InputError:
        return None
