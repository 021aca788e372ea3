"""Frequency responses of the three camera models (Fig. 6)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from camid.chain.camera_models import model_1_response, model_2_response, model_3_response


def camera_model_responses(configuration: Mapping[str, Any]) -> pd.DataFrame:
    """Gain and phase of Models #1 to #3.

    The phase is that of the common factor e^(−jωT/2) times the sign of the real remaining factor, continued without
    jumps of a whole turn: at each zero of Model #1 or #2 it steps by half a turn.

    Returns
    -------
    DataFrame
        Columns ``frequency`` (Hz), ``angular_frequency_times_period``, ``gain_<1..3>``, ``phase_<1..3>`` (degrees).
    """
    period = configuration["period"]
    normalised = np.geomspace(configuration["lowest"], configuration["highest"], configuration["points"])
    # The zeros themselves, so that the table shows them and not a neighbour.
    zeros = [2.0 * np.pi * k for k in range(1, 50)] + [np.pi * (2 * k + 1) for k in range(50)]
    normalised = np.union1d(normalised, [z for z in zeros if z <= configuration["highest"]])
    angular = normalised / period
    table: dict[str, Any] = {
        "frequency": angular / (2.0 * np.pi),
        "angular_frequency_times_period": normalised,
    }
    for number, response in enumerate((model_1_response, model_2_response, model_3_response), start=1):
        values = response(angular, period)
        remaining = np.real(values * np.exp(0.5j * normalised))
        table[f"gain_{number}"] = np.abs(values)
        table[f"phase_{number}"] = -np.degrees(0.5 * normalised) - np.where(remaining < -1e-9, 180.0, 0.0)
    return pd.DataFrame(table)
