"""Numbers by which the replication is judged: what tolerances guard and claims quote, in one table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.paper.cases import PARAMETERS

Array = NDArray[np.float64]

REPORTED_PERIODS = (0.02, 0.05, 0.1, 0.2, 0.3)
REPORTED_PRODUCTS = (0.6, 1.0, 1.6, 3.0)  # Tω1
GOOD = 1.0  # percent: "relative accuracy of 1 %", section 3.3


class Quantities:
    """Growing table of target, quantity, value and unit."""

    def __init__(self) -> None:
        self.rows: list[dict[str, Any]] = []

    def add(self, target: str, quantity: str, value: float, unit: str = "") -> None:
        """Append a row."""
        self.rows.append({"target": target, "quantity": quantity, "value": float(value), "unit": unit})

    def table(self) -> pd.DataFrame:
        """All rows."""
        return pd.DataFrame(self.rows)


def all_quantities(tables: Mapping[str, pd.DataFrame], configuration: Mapping[str, Any]) -> pd.DataFrame:
    """Every number that is guarded or quoted.

    Parameters
    ----------
    tables : mapping of str to DataFrame
        ``excitation``, ``marker_trajectory``, ``assumptions``, ``camera_models``, ``discrete_time``,
        ``sampling_period``, ``neglected_mode``, and the plotted numbers ``fig1`` and ``fig2``.
    configuration : mapping
        The workflow's configuration.

    Returns
    -------
    DataFrame
        Columns ``target``, ``quantity``, ``value``, ``unit``.
    """
    quantities = Quantities()
    excitation_quantities(quantities, tables["excitation"])
    _imaging(quantities, tables)
    _camera_models(quantities, tables["camera_models"])
    _discrete_time(quantities, tables["discrete_time"])
    sampling_period_quantities(quantities, tables["sampling_period"], configuration)
    _neglected_mode(quantities, tables["neglected_mode"])
    return quantities.table()


def excitation_quantities(quantities: Quantities, excitation: pd.DataFrame) -> None:
    """Add those of the excitation to the quantities: length, balance and autocorrelation."""
    signal = excitation["u"].to_numpy()
    count = len(signal)
    correlation = np.fft.ifft(np.abs(np.fft.fft(signal)) ** 2).real / np.mean(signal**2)
    quantities.add("excitation", "length", count, "samples")
    quantities.add("excitation", "levels", len(np.unique(signal)))
    quantities.add("excitation", "mean", float(np.mean(signal)), "u")
    quantities.add("excitation", "largest_side_of_autocorrelation", float(np.max(np.abs(correlation[1:]))), "of N")


def _imaging(quantities: Quantities, tables: Mapping[str, pd.DataFrame]) -> None:
    trajectory = tables["fig1"]
    steps = np.hypot(np.diff(trajectory["x"]), np.diff(trajectory["y"]))
    quantities.add("fig1", "length_of_trajectory", float(steps.sum()), "px")
    quantities.add("fig1", "brightest_grey_level", float(trajectory["grey_level"].max()), "grey levels")
    centres = tables["fig2"].set_index("quantity")["value"]
    for name in ("centroid_x", "centroid_y"):
        quantities.add("fig2", name, float(centres[name]), "px")
    distance = np.hypot(centres["centroid_x"] - centres["time_mean_x"], centres["centroid_y"] - centres["time_mean_y"])
    quantities.add("fig2", "distance_from_time_mean", float(distance), "px")

    slow = tables["marker_trajectory"]
    model = slow[["model_x", "model_y"]].to_numpy()
    outward = model - model.mean(axis=0)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    for name in ("measured", "half_threshold", "grey_level"):
        error = slow[[f"{name}_x", f"{name}_y"]].to_numpy() - model
        power = np.sum((model - model.mean(axis=0)) ** 2) / np.sum(error**2)
        quantities.add("fig3", f"signal_to_noise_{name}", float(10.0 * np.log10(power)), "dB")
        quantities.add("fig3", f"outward_error_{name}", float(np.mean(np.sum(error * outward, axis=1))), "px")
    error = slow[["measured_x", "measured_y"]].to_numpy() - model
    radial = np.sum(error * outward, axis=1)
    quantities.add("fig3", "systematic_share_of_error", float(np.mean(radial) ** 2 / np.mean(np.sum(error**2, axis=1))))

    failures = tables["assumptions"]
    for row in failures.to_dict("records"):
        setting = f"{row['assumption']}_{row['setting']:g}_threshold_{row['threshold']:g}"
        if row["assumption"] in {"A1", "A2"}:
            quantities.add("assumptions", setting, row["value"], "px")
    by_quantity = failures.set_index("quantity")["value"]
    quantities.add("assumptions", "A4_holds", by_quantity["distance of (2) from the time mean, constant speed"], "px")
    quantities.add("assumptions", "A4_fails", by_quantity["distance of (2) from the time mean, from rest"], "px")
    quantities.add("assumptions", "colour_against_grey", by_quantity["largest difference from a grey camera"], "levels")


def _camera_models(quantities: Quantities, responses: pd.DataFrame) -> None:
    normalised = responses["angular_frequency_times_period"].to_numpy()
    turns = normalised / (2.0 * np.pi)

    def at(column: str, value: float) -> float:
        return float(np.interp(value, normalised, responses[column]))

    zeros_1 = np.isclose(turns, np.round(turns), atol=1e-12) & (turns > 0.5)
    zeros_2 = np.isclose(turns - 0.5, np.round(turns - 0.5), atol=1e-12)
    quantities.add("fig6", "gain_1_at_its_zeros", float(responses["gain_1"][zeros_1].max()))
    quantities.add("fig6", "gain_2_at_its_zeros", float(responses["gain_2"][zeros_2].max()))
    quantities.add("fig6", "zeros_shown_1", int(zeros_1.sum()))
    quantities.add("fig6", "zeros_shown_2", int(zeros_2.sum()))
    phases = responses[["phase_1", "phase_2", "phase_3"]].to_numpy()
    apart = phases - phases[:, 2:]
    quantities.add(
        "fig6", "phase_apart_modulo_half_turn", float(np.max(np.abs(apart - 180.0 * np.round(apart / 180.0)))), "°"
    )
    before = normalised < 0.999 * np.pi
    quantities.add("fig6", "phase_apart_below_first_zero", float(np.max(np.abs(apart[before]))), "°")
    for number in (1, 2):
        quantities.add("fig6", f"gain_{number}_at_1_over_T", 20.0 * np.log10(at(f"gain_{number}", 1.0)), "dB")
    quantities.add("fig6", "phase_at_1_over_T", at("phase_1", 1.0), "°")
    for number in (1, 2):
        inside = (turns > 1.0) & (turns < 3.0)
        gain = float(responses[f"gain_{number}"][inside].max())
        quantities.add("fig6", f"largest_gain_{number}_past_1_over_T_hertz", 20.0 * np.log10(gain), "dB")


def _discrete_time(quantities: Quantities, table: pd.DataFrame) -> None:
    for column in ("closed_form", "hold_equivalent", "identified"):
        difference = float(np.max(np.abs(table[column] - table["exact"])))
        quantities.add("discrete_time", f"largest_difference_{column}", difference)
    quantities.add("discrete_time", "coefficients", table["coefficient"].nunique())


def sampling_period_quantities(
    quantities: Quantities, estimates: pd.DataFrame, configuration: Mapping[str, Any]
) -> None:
    """Add those of Fig. 7 to the quantities: errors of each case, bounds, and where plain SRIVC fails."""
    from scipy.special import chdtrc

    errors = [f"error_{p}" for p in PARAMETERS]

    def runs(case: str, method: str = "srivc") -> pd.DataFrame:
        return estimates[(estimates["case"] == case) & (estimates["method"] == method)]

    for case in ("camera", "foh-argument"):
        largest = float(np.max(np.abs(runs(case)[errors].to_numpy())))
        quantities.add("fig7", f"largest_error_{case}", largest, "%")
    plain = runs("camera", "plain-srivc")
    good = plain[plain["converged"]]
    quantities.add("fig7", "largest_error_plain_srivc_where_converged", float(np.max(np.abs(good[errors]))), "%")
    failed = plain[~plain["converged"]]["period"]
    first = float(failed.min()) if len(failed) else float("nan")
    quantities.add("fig7", "plain_srivc_fails_from_period", first, "s")
    product = first * configuration["plant"]["natural_frequency"]
    quantities.add("fig7", "plain_srivc_fails_from_product", product)
    for case, method in (("zoh", "plain-srivc"), ("zoh", "srivc"), ("zoh-unshifted", "srivc")):
        for period in REPORTED_PERIODS[:3]:
            row = runs(case, method)
            row = row[np.isclose(row["period"], period)]
            for parameter in PARAMETERS:
                value = float(row[f"error_{parameter}"].iloc[0]) if len(row) else float("nan")
                quantities.add("fig7", f"{case}_{method}_{parameter}_at_{period:g}", value, "%")
    noisy = runs("camera-noise")
    for parameter in PARAMETERS:
        rms = float(np.sqrt(np.mean(noisy[f"error_{parameter}"] ** 2)))
        bound = float(np.sqrt(np.mean(noisy[f"bound_{parameter}"] ** 2)))
        quantities.add("fig7", f"noise_rms_error_{parameter}", rms, "%")
        quantities.add("fig7", f"noise_bound_{parameter}", bound, "%")
        amplitude = runs("camera-noise-amplitude")[f"error_{parameter}"]
        quantities.add("fig7", f"noise_rms_error_{parameter}_amplitude", float(np.sqrt(np.mean(amplitude**2))), "%")
        for period in REPORTED_PERIODS:
            row = noisy[np.isclose(noisy["period"], period)]
            if len(row):
                quantities.add(
                    "fig7", f"bound_{parameter}_at_{period:g}", float(row[f"bound_{parameter}"].iloc[0]), "%"
                )
    statistic, freedom = float(noisy["chi_square"].sum()), len(PARAMETERS) * len(noisy)
    quantities.add("fig7", "chi_square", statistic)
    quantities.add("fig7", "chi_square_freedom", freedom)
    quantities.add("fig7", "chi_square_probability", float(chdtrc(freedom, statistic)))
    standardised = noisy[[f"standardised_{p}" for p in PARAMETERS]].to_numpy()
    quantities.add("fig7", "largest_standardised_error", float(np.max(np.abs(standardised))))
    quantities.add(
        "fig7", "not_converged", int((~estimates[estimates["method"] == "srivc"]["converged"]).sum()), "fits"
    )


def _neglected_mode(quantities: Quantities, estimates: pd.DataFrame) -> None:
    cases = {str(c): g.sort_values("omega_1") for c, g in estimates.groupby("case")}
    for case, group in cases.items():
        for product in REPORTED_PRODUCTS:
            for parameter in PARAMETERS:
                value = np.interp(np.log(product), np.log(group["period_times_omega_1"]), group[f"error_{parameter}"])
                quantities.add("fig8", f"{case}_{parameter}_at_{product:g}", float(value), "%")
    errors = [f"error_{p}" for p in PARAMETERS]
    camera, instant = cases["camera-foh"][errors].to_numpy(), cases["instant-zoh"][errors].to_numpy()
    quantities.add("fig8", "camera_foh_against_instant_zoh", float(np.max(np.abs(camera - instant))), "%")
    group = cases["camera-foh"]
    good = (group[errors].abs() <= GOOD).all(axis=1).to_numpy()
    # From the first frequency after which no error exceeds one percent.
    bad = np.flatnonzero(~good)
    first = int(bad[-1]) + 1 if bad.size else 0
    product = float(group["period_times_omega_1"].iloc[first]) if first < len(group) else float("nan")
    quantities.add("fig8", "one_percent_from_product", product)
    far = {c: float(np.abs(g["error_a0"].iloc[-1])) for c, g in cases.items()}
    quantities.add("fig8", "a0_error_foh_at_highest", far["camera-foh"], "%")
    quantities.add("fig8", "a0_error_zoh_at_highest", far["camera-zoh"], "%")
