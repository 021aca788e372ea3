"""What a wrong pairing of input and output samples costs, for both holds.

A held input is half a frame late on average, and so is the mean over a full exposure: the camera's data lag their input
samples by a frame. With an instant sensor declared, a first-order hold lags by nothing and a zero-order hold by half a
frame. So with u[k] paired with w[k + shift], the data lag the model by ``1 - shift`` frames (first-order hold) or
``1/2 - shift`` frames (zero-order hold): ``lag_left``. The bias is that of an undeclared latency of this size, be it
positive or negative.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from camid.ablations.identification_runs import NO_BIAS, by_parameter, excitation_signal, percent_errors
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.identification.estimate import estimate
from camid.identification.structure import Structure
from camid.paper.cases import PARAMETERS, declared_experiment
from camid.paper.datasets import believed_plant

LAG_WITHOUT_SHIFT = {"foh": 1.0, "zoh": 0.5}  # frames
RIGHT = ("foh", 1)
SHIFTS = (0, 1, 2)


def compute(settings: Mapping[str, Any], shared: Mapping[str, Any]) -> pd.DataFrame:
    """Identify the paper's plant from its camera data, held input, no noise, with an instant sensor declared.

    Parameters
    ----------
    settings : mapping
        ``periods`` in s, ``holds`` (declared), ``shifts`` (u[k] is paired with w[k + shift]) and ``methods``.
    shared : mapping
        Sections ``plant`` and ``excitation``.

    Returns
    -------
    DataFrame
        One row per fit: ``period`` (s), ``hold``, ``shift``, ``lag_left`` (frames), ``method``, ``converged``,
        ``error_<p>`` in percent.
    """
    plant = believed_plant(shared["plant"])
    # At rest for longer than the largest shift, so that every pairing begins before anything moves.
    rest = np.zeros(max(settings["shifts"]) + 1)
    signal = np.concatenate([rest, excitation_signal(shared["excitation"])])
    rows: list[dict[str, Any]] = []
    for period in settings["periods"]:
        output = sample(plant, signal, Acquisition(period))
        for hold in settings["holds"]:
            for shift in settings["shifts"]:
                case = {"hold": hold, "sensor": "instant", "shift": shift}
                experiment = declared_experiment(signal, output, period, case)
                for method in settings["methods"]:
                    # The question is bias and not search, but plain SRIVC is the paper's only with its own start.
                    nominal = None if method == "plain-srivc" else plant
                    result = estimate(Structure.of_order(2, 0), [experiment], nominal=nominal, method=method)
                    rows.append(
                        {
                            "period": float(period),
                            "hold": hold,
                            "shift": int(shift),
                            "lag_left": LAG_WITHOUT_SHIFT[hold] - shift,
                            "method": method,
                            "converged": result.converged,
                            **by_parameter("error", percent_errors(result.plant, plant)),
                        }
                    )
    return pd.DataFrame(rows)


def quantities(table: pd.DataFrame) -> dict[str, tuple[float, str]]:
    """Largest error of every pairing at every period, errors of a0 a frame of lag left, and plain SRIVC's own errors.

    ``<hold>_<shift>_at_<T>``: largest of the three errors, default method; ``a0_per_frame_at_<T>``: change of the error
    of a0 over that of the lag between the two pairings with a zero-order hold that are half a frame off;
    ``plain_zoh_<shift>_<p>_at_<T>`` of these two where plain SRIVC was run and converged.
    """
    errors = [f"error_{p}" for p in PARAMETERS]
    default = table[table["method"] == "srivc"]
    found: dict[str, tuple[float, str]] = {}
    largest = default[errors].abs().max(axis=1)
    for row, error in zip(default.to_dict("records"), largest, strict=True):
        found[f"{row['hold']}_{row['shift']}_at_{row['period']:g}"] = (float(error), "%")
    zero = default[(default["hold"] == "zoh") & (default["lag_left"].abs() == 0.5)]
    for period, pair in zero.sort_values("lag_left").groupby("period"):
        found[f"a0_per_frame_at_{period:g}"] = (float(pair["error_a0"].iloc[-1] - pair["error_a0"].iloc[0]), "%")
    plain = table[(table["method"] == "plain-srivc") & table["converged"] & (table["hold"] == "zoh")]
    for row in plain[plain["lag_left"].abs() == 0.5].to_dict("records"):
        for p in PARAMETERS:
            name = f"plain_{row['hold']}_{row['shift']}_{p}_at_{row['period']:g}"
            found[name] = (float(row[f"error_{p}"]), "%")
    return found


def conclusion(value: Mapping[str, float]) -> str:
    """The answer for an engineer."""
    periods = sorted(float(k.removeprefix("a0_per_frame_at_")) for k in value if k.startswith("a0_per_frame_at_"))
    quoted = (periods[0], periods[-1])
    at = " and ".join(f"{1e3 * p:g}" for p in quoted)

    def listed(hold: str, shift: int) -> str:
        errors = [value[f"{hold}_{shift}_at_{p:g}"] for p in quoted]
        return " and ".join(f"{e:.0f}" if e >= 10.0 else f"{e:.2g}" for e in errors) + " %"

    right = max(value[f"{RIGHT[0]}_{RIGHT[1]}_at_{p:g}"] for p in periods)
    smallest_zero = min(value[f"zoh_{s}_at_{p:g}"] for s in SHIFTS for p in periods)
    best = "has no bias" if right < NO_BIAS else f"is biased by up to {right:.2g} %"
    never = (
        "No pairing makes a zero-order hold right"
        if smallest_zero >= NO_BIAS
        else "Some pairing makes a zero-order hold right"
    )
    frame = " and ".join(f"{value[f'a0_per_frame_at_{p:g}']:+.2g} %" for p in quoted)
    return (
        f"A first-order hold with u[k] paired with w[k+1] {best}; paired with w[k] or w[k+2] it is a frame off and "
        f"errs by {listed('foh', 0)} or by {listed('foh', 2)} at T = {at} ms. {never}: with w[k+1] or w[k] it is half "
        f"a frame off to either side and errs by {listed('zoh', 1)} or by {listed('zoh', 0)}. The lag that is left "
        f"decides: a frame of it moves a0 by {frame}."
    )
