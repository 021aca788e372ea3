"""How the paper's cases declare hold and sensor, and which samples they pair."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.identification.experiment import Experiment

Array = NDArray[np.float64]

PARAMETERS = ("b0", "a1", "a0")


def declared_experiment(signal: Array, output: Array, period: float, case: Mapping[str, Any]) -> Experiment:
    """The data as a case declares them.

    Parameters
    ----------
    signal, output : ndarray, shape (N,)
        Input u_k and camera output w_k.
    period : float
        Seconds.
    case : mapping
        ``hold``, ``sensor`` and ``shift``: with a shift of one, u_k is paired with w_{k+1}, which is what an instant
        sensor must be given by hand and a camera sensor implies.
    """
    shift = int(case.get("shift", 0))
    if shift:
        # The input before the record was zero, and the first-order hold rises from it.
        signal = np.concatenate([np.zeros(shift), signal[:-shift]]) if case["hold"] == "foh" else signal[:-shift]
        output = output if case["hold"] == "foh" else output[shift:]
    acquisition = Acquisition(period, case["hold"], case["sensor"])
    return Experiment(signal, output, acquisition, np.ones(len(output), bool))


def parameter_vector(numerator: tuple[float, ...], denominator: tuple[float, ...]) -> Array:
    """[b0, a1, a0] of b0/(s² + a1 s + a0)."""
    return np.array([numerator[-1], denominator[-2], denominator[-1]])


def with_gain(estimates: pd.DataFrame) -> pd.DataFrame:
    """The table with ``error_K``, in percent: of the static gain K = b0/a0, from the errors of b0 and a0."""
    ratio = (1.0 + estimates["error_b0"] / 100.0) / (1.0 + estimates["error_a0"] / 100.0)
    return estimates.assign(error_K=100.0 * (ratio - 1.0))
