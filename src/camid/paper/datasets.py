"""Camera-sampled outputs of each sweep and noise samples (sections 3.2 and 3.3 of the paper)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction, second_order

Array = NDArray[np.float64]


def believed_plant(plant: Mapping[str, float]) -> TransferFunction:
    """G0(s) of equation (15) from the section ``plant`` of the configuration."""
    return second_order(plant["static_gain"], plant["natural_frequency"], plant["damping"])


def sweep_periods(configuration: Mapping[str, Any]) -> Array:
    """Sampling periods of Fig. 7 in seconds, shape (P,)."""
    steps = round((configuration["stop"] - configuration["start"]) / configuration["step"])
    # Rounded, so that a period reads as it was written and not as a sum of rounding errors.
    return np.round(configuration["start"] + configuration["step"] * np.arange(steps + 1), 12)


def with_closing_frame(signal: Array) -> Array:
    """The excitation and a last sample of zero, so that a frame is delivered when the last held sample ends.

    511 held samples then give 511 pairs of u[k] and w[k+1], the length that the paper states.
    """
    return np.append(signal, 0.0)


def sampling_period_outputs(
    excitation: pd.DataFrame, plant: Mapping[str, float], sweep: Mapping[str, Any]
) -> pd.DataFrame:
    """Camera output of G0 for every sampling period, by the exact chain of Fig. 4.

    Returns
    -------
    DataFrame
        Columns ``period`` (s), ``k``, ``u``, ``w``; N + 1 rows per period, the last for the closing frame.
    """
    signal = with_closing_frame(excitation["u"].to_numpy())
    tables = [
        pd.DataFrame(
            {
                "period": period,
                "k": np.arange(len(signal)),
                "u": signal,
                "w": sample(believed_plant(plant), signal, Acquisition(float(period))),
            }
        )
        for period in sweep_periods(sweep)
    ]
    return pd.concat(tables, ignore_index=True)


def noise_samples(excitation: pd.DataFrame, sweep: Mapping[str, Any], seed: int) -> pd.DataFrame:
    """Standard normal noise, a stream of its own for every period and sample.

    The stream of sample s at period number i is ``SeedSequence(seed, spawn_key=(i, s))``: the first of the sequence,
    none chosen.

    Returns
    -------
    DataFrame
        Columns ``period`` (s), ``sample`` (from 0), ``k``, ``noise`` (unit variance).
    """
    length = len(excitation) + 1  # with the closing frame
    tables = []
    for i, period in enumerate(sweep_periods(sweep)):
        for s in range(sweep["noise_samples"]):
            generator = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(i, s)))
            tables.append(
                pd.DataFrame(
                    {
                        "period": period,
                        "sample": s,
                        "k": np.arange(length),
                        "noise": generator.standard_normal(length),
                    }
                )
            )
    return pd.concat(tables, ignore_index=True)


def noise_level(output: Array, ratio: float, ratio_of: str) -> float:
    """Standard deviation of the noise for a signal-to-noise ratio of powers or of amplitudes."""
    return float(np.std(output)) / (np.sqrt(ratio) if ratio_of == "power" else ratio)


def neglected_frequencies(sweep: Mapping[str, Any]) -> Array:
    """ω1 of Fig. 8 in rad/s, shape (P,)."""
    return np.geomspace(sweep["start"], sweep["stop"], sweep["points"]) / sweep["period"]


def neglected_mode_outputs(
    excitation: pd.DataFrame, plant: Mapping[str, float], sweep: Mapping[str, Any]
) -> pd.DataFrame:
    """Outputs of G0·G1, equations (25) and (26), by camera and by an instant sensor.

    Returns
    -------
    DataFrame
        Columns ``omega_1`` (rad/s), ``k``, ``u``, ``camera``, ``instant``; N + 1 rows a frequency.
    """
    signal = with_closing_frame(excitation["u"].to_numpy())
    tables = []
    for omega in neglected_frequencies(sweep):
        whole = believed_plant(plant) * second_order(1.0, float(omega), sweep["damping"])
        tables.append(
            pd.DataFrame(
                {
                    "omega_1": omega,
                    "k": np.arange(len(signal)),
                    "u": signal,
                    "camera": sample(whole, signal, Acquisition(sweep["period"])),
                    "instant": sample(whole, signal, Acquisition(sweep["period"], sensor="instant")),
                }
            )
        )
    return pd.concat(tables, ignore_index=True)
