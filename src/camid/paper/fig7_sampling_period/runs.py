"""Identification runs for Fig. 7: errors of b0, a1 and a0 against the sampling period."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.identification.accuracy import cramer_rao_bound
from camid.identification.estimate import estimate
from camid.identification.structure import Structure
from camid.paper.cases import PARAMETERS, declared_experiment, parameter_vector
from camid.paper.datasets import believed_plant, noise_level

Array = NDArray[np.float64]


def identify_sampling_period(
    outputs: pd.DataFrame,
    noise: pd.DataFrame,
    plant: Mapping[str, float],
    sweep: Mapping[str, Any],
    cases: Mapping[str, Mapping[str, Any]],
) -> pd.DataFrame:
    """Run every case at every sampling period.

    Parameters
    ----------
    outputs, noise : DataFrame
        From :mod:`camid.paper.datasets`.
    plant, sweep, cases : mapping
        Configuration sections. A case with ``noise: true`` runs once per noise sample; ``ratio_of`` overrides the
        sweep's.

    Returns
    -------
    DataFrame
        One row per fit: ``period``, ``case``, ``sample`` (-1 without noise), ``method``, ``converged``, ``error_<p>``
        in percent of the true value, ``standard_deviation_<p>`` in percent, ``bound_<p>`` (Cramér–Rao, percent),
        ``standardised_<p>`` (error over bound) and ``chi_square`` (three degrees of freedom), the last three with
        noise.
    """
    truth_plant = believed_plant(plant)
    truth = parameter_vector(truth_plant.numerator, truth_plant.denominator)
    structure = Structure.of_order(2, 0)
    samples = {(p, s): g["noise"].to_numpy() for (p, s), g in noise.groupby(["period", "sample"])}
    rows: list[dict[str, Any]] = []
    for key, group in outputs.groupby("period"):
        period = float(str(key))
        signal, clean = group["u"].to_numpy(), group["w"].to_numpy()
        for name, case in cases.items():
            for s in range(sweep["noise_samples"]) if case.get("noise") else (-1,):
                level, bound = 0.0, np.zeros((3, 3))
                output = clean
                if s >= 0:
                    level = noise_level(clean, sweep["signal_to_noise_ratio"], case.get("ratio_of", sweep["ratio_of"]))
                    output = clean + level * samples[(key, s)]
                    bound = cramer_rao_bound(truth_plant, signal, Acquisition(period), level**2)
                experiment = declared_experiment(signal, output, period, case)
                for method in case["methods"]:
                    result = estimate(structure, [experiment], method=method)
                    estimated = parameter_vector(result.plant.numerator, result.plant.denominator)
                    row: dict[str, Any] = {
                        "period": period,
                        "case": name,
                        "sample": s,
                        "method": method,
                        "converged": result.converged,
                    }
                    error = estimated - truth
                    for i, parameter in enumerate(PARAMETERS):
                        row[f"error_{parameter}"] = 100.0 * error[i] / truth[i]
                        row[f"standard_deviation_{parameter}"] = 100.0 * result.standard_deviations[i] / truth[i]
                        row[f"bound_{parameter}"] = 100.0 * np.sqrt(bound[i, i]) / truth[i]
                        row[f"standardised_{parameter}"] = error[i] / np.sqrt(bound[i, i]) if s >= 0 else np.nan
                    row["chi_square"] = error @ np.linalg.solve(bound, error) if s >= 0 else np.nan
                    rows.append(row)
    return pd.DataFrame(rows)
