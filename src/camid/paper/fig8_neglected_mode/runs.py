"""Identification runs for Fig. 8: errors due to a neglected mode at ω1 (section 3.3)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from camid.identification.estimate import estimate
from camid.identification.structure import Structure
from camid.paper.cases import PARAMETERS, declared_experiment, parameter_vector
from camid.paper.datasets import believed_plant


def identify_neglected_mode(
    outputs: pd.DataFrame,
    plant: Mapping[str, float],
    sweep: Mapping[str, Any],
    cases: Mapping[str, Mapping[str, Any]],
) -> pd.DataFrame:
    """Fit b0/(s² + a1 s + a0) to the output of a plant with two modes, in every case at every ω1.

    Parameters
    ----------
    outputs : DataFrame
        From :func:`camid.paper.datasets.neglected_mode_outputs`.
    plant, sweep, cases : mapping
        Sections of the configuration; ``measured`` of a case names the column of ``outputs``.

    Returns
    -------
    DataFrame
        One row per fit: ``omega_1`` (rad/s), ``period_times_omega_1``, ``case``, ``converged``, ``error_<p>`` in %.
    """
    believed = believed_plant(plant)
    truth = parameter_vector(believed.numerator, believed.denominator)
    rows: list[dict[str, Any]] = []
    for key, group in outputs.groupby("omega_1"):
        omega = float(str(key))
        for name, case in cases.items():
            experiment = declared_experiment(
                group["u"].to_numpy(), group[case["measured"]].to_numpy(), sweep["period"], case
            )
            # The believed plant is the start: what the neglected mode shifts is the question, not whether it is found.
            result = estimate(Structure.of_order(2, 0), [experiment], nominal=believed)
            error = parameter_vector(result.plant.numerator, result.plant.denominator) / truth - 1.0
            rows.append(
                {
                    "omega_1": omega,
                    "period_times_omega_1": omega * sweep["period"],
                    "case": name,
                    "converged": result.converged,
                    **{f"error_{p}": 100.0 * error[i] for i, p in enumerate(PARAMETERS)},
                }
            )
    return pd.DataFrame(rows)
