"""Frequency responses before and after a diagnosis, for its report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import pi

import numpy as np

from camid.analysis.empirical_response import EmpiricalResponse, empirical_response
from camid.analysis.frequency_response import FrequencyResponses, ResponseCurve, frequencies_for
from camid.analysis.linear_model import linear_models, units_of
from camid.errors import InputError
from camid.recording.recording import Recording
from camid.simulation.model import Simulation


def diagnosed_responses(
    models: Mapping[str, Simulation], recordings: Sequence[Recording], largest_share: float = 0.1
) -> FrequencyResponses | None:
    """Responses of plants over the frequencies that a recording holds, and its own beside them.

    Parameters
    ----------
    models : mapping of str to Simulation
        By the names that a legend calls them.
    recordings : sequence of Recording
    largest_share : float
        Of the longest recording, that the longest period may have.

    Returns
    -------
    FrequencyResponses or None
        None without an input, and where a plant has no linear part; without the recording's response where it shows
        none.
    """
    first = next(iter(models.values()))
    if first.input_column is None:
        return None
    period = recordings[0].period
    longest = max(len(one) for one in recordings) * period
    limits = 2.0 * pi / (largest_share * longest), pi / period
    try:
        linear = linear_models(models)
    except InputError:
        return None
    empirical = _shown_by(recordings, first)
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
