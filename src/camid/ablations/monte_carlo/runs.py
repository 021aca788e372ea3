"""Errors of identification over the Cramér–Rao bound at every period of Fig. 7, from no starting value at all.

Many noise seeds per period at the paper's signal-to-noise ratio. A shard holds sums over its own seeds, so memory does
not grow with their number, and any number of shards runs side by side.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.ablations.identification_runs import excitation_signal, unit_noise, whole_experiment
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.identification.accuracy import cramer_rao_bound
from camid.identification.estimate import estimate
from camid.identification.structure import Structure
from camid.paper.cases import PARAMETERS, parameter_vector
from camid.paper.datasets import believed_plant, noise_level, sweep_periods

Array = NDArray[np.float64]

# First number of the spawn key: streams of their own, apart from the noise samples of Fig. 7.
STREAM = 31
# An error beyond this share of the true value is a gross failure: at 10 dB the bound lies between 0.3 and 7 %.
GROSS_RELATIVE_ERROR = 0.5
NORMAL_95 = 1.959964


def shard_seeds(seeds: int, shard: int, shards: int) -> range:
    """Seeds of one shard: every ``shards``-th, so that all shards take equally long."""
    return range(shard, seeds, shards)


def compute_shard(
    settings: Mapping[str, Any], shared: Mapping[str, Any], seeds: Sequence[int], periods: Array | None = None
) -> pd.DataFrame:
    """Sums over the fits of some seeds.

    Parameters
    ----------
    settings : mapping
        Section ``monte_carlo`` of the configuration.
    shared : mapping
        ``plant``, ``excitation``, ``sampling_period_sweep`` and ``seed``.
    seeds : sequence of int
    periods : ndarray, optional
        Sampling periods in s; those of Fig. 7 unless given.

    Returns
    -------
    DataFrame
        One row per period and parameter: ``period``, ``parameter``, ``fits``, ``sum`` and ``sum_of_squares`` (of errors
        in units of the Cramér–Rao bound), ``covered`` (95 % intervals that hold the truth), ``gross`` (failures),
        ``not_converged``, ``bound`` (percent of the true value).
    """
    plant = believed_plant(shared["plant"])
    truth = parameter_vector(plant.numerator, plant.denominator)
    signal = excitation_signal(shared["excitation"])
    rows: list[dict[str, Any]] = []
    for i, period in enumerate(sweep_periods(shared["sampling_period_sweep"]) if periods is None else periods):
        acquisition = Acquisition(float(period))
        clean = sample(plant, signal, acquisition)
        level = noise_level(clean, settings["signal_to_noise_ratio"], "power")
        bound = np.sqrt(np.diag(cramer_rao_bound(plant, signal, acquisition, level**2)))
        totals = np.zeros((4, len(PARAMETERS)))
        not_converged = 0
        for s in seeds:
            output = clean + level * unit_noise(len(clean), shared["seed"], STREAM, i, s)
            result = estimate(Structure.of_order(2, 0), [whole_experiment(signal, output, acquisition)])
            error = parameter_vector(result.plant.numerator, result.plant.denominator) - truth
            totals[0] += error / bound
            totals[1] += (error / bound) ** 2
            totals[2] += np.abs(error) <= NORMAL_95 * result.standard_deviations
            totals[3] += np.abs(error) > GROSS_RELATIVE_ERROR * truth
            not_converged += not result.converged
        rows += [
            {
                "period": float(period),
                "parameter": parameter,
                "fits": len(seeds),
                "sum": totals[0, j],
                "sum_of_squares": totals[1, j],
                "covered": int(totals[2, j]),
                "gross": int(totals[3, j]),
                "not_converged": not_converged,
                "bound": 100.0 * bound[j] / truth[j],
            }
            for j, parameter in enumerate(PARAMETERS)
        ]
    return pd.DataFrame(rows)


def compute_numbered_shard(
    settings: Mapping[str, Any], shared: Mapping[str, Any], seeds: int, shard: int, shards: int
) -> pd.DataFrame:
    """Sums over the fits of one of several shards, see :func:`compute_shard`."""
    return compute_shard(settings, shared, shard_seeds(seeds, shard, shards))


def combine(shards: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """The same table for the seeds of all shards."""
    keys = ["period", "parameter", "bound"]
    return pd.concat(shards).groupby(keys, as_index=False, sort=True).sum()


def compute(settings: Mapping[str, Any], shared: Mapping[str, Any]) -> pd.DataFrame:
    """All shards one after the other."""
    shards = settings["shards"]
    return combine([compute_shard(settings, shared, shard_seeds(settings["seeds"], s, shards)) for s in range(shards)])


def with_ratios(table: pd.DataFrame) -> pd.DataFrame:
    """The table with ``ratio`` (root mean square error over bound), ``mean`` (in bounds) and ``coverage`` (share)."""
    return table.assign(
        ratio=np.sqrt(table["sum_of_squares"] / table["fits"]),
        mean=table["sum"] / table["fits"],
        coverage=table["covered"] / table["fits"],
    )


def quantities(table: pd.DataFrame) -> dict[str, tuple[float, str]]:
    """Ratios to the bound, coverage and failures, pooled and at the worst period."""
    ratios = with_ratios(table)
    seeds = float(table["fits"].iloc[0])
    found: dict[str, tuple[float, str]] = {"seeds": (seeds, "a period"), "periods": (table["period"].nunique(), "")}
    for parameter, group in ratios.groupby("parameter"):
        pooled = float(np.sqrt(group["sum_of_squares"].sum() / group["fits"].sum()))
        found[f"ratio_{parameter}"] = (pooled, "of the bound")
        found[f"coverage_{parameter}"] = (100.0 * float(group["covered"].sum() / group["fits"].sum()), "%")
    worst = ratios.iloc[int(ratios["ratio"].to_numpy().argmax())]
    found["largest_ratio"] = (float(worst["ratio"]), "of the bound")
    found["largest_ratio_period"] = (float(worst["period"]), "s")
    # A root mean square over S fits scatters by 1/√(2S) of itself.
    found["largest_ratio_in_standard_errors"] = ((float(worst["ratio"]) - 1.0) * np.sqrt(2.0 * seeds), "")
    found["smallest_coverage"] = (100.0 * float(ratios["coverage"].min()), "%")
    found["largest_coverage"] = (100.0 * float(ratios["coverage"].max()), "%")
    spread = np.sqrt(0.95 * 0.05 / seeds)
    found["worst_coverage_in_standard_errors"] = (float((ratios["coverage"] - 0.95).abs().max() / spread), "")
    first = table[table["parameter"] == PARAMETERS[0]]
    found["gross_failures"] = (float(table["gross"].sum()), "fits")
    found["not_converged"] = (float(first["not_converged"].sum()), "fits")
    return found


def conclusion(value: Mapping[str, float]) -> str:
    """In words."""
    ratios = [value[f"ratio_{p}"] for p in PARAMETERS]
    # What scatter alone adds to the largest of some two hundred ratios.
    reached = max(ratios) <= 1.05 and value["largest_ratio_in_standard_errors"] <= 4.5
    failures = value["gross_failures"]
    return (
        f"Without any starting value the default method {'reaches' if reached else 'misses'} the Cramér–Rao bound at "
        f"{value['periods']:.0f} periods up to the Shannon limit with {value['seeds']:.0f} noise seeds each: "
        f"rms error {ratios[0]:.3f}, {ratios[1]:.3f}, {ratios[2]:.3f} times the bound for b0, a1, a0 "
        f"(largest at a single period {value['largest_ratio']:.3f}), "
        f"{'no gross failure' if failures == 0 else f'{failures:.0f} gross failures'}, 95 % intervals that cover "
        f"{value['smallest_coverage']:.1f} to {value['largest_coverage']:.1f} %."
    )
