"""What a camera with a short shutter does to models that declare its exposure, ignore it or approximate it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.ablations.identification_runs import (
    NO_BIAS,
    by_parameter,
    excitation_signal,
    percent_errors,
    whole_experiment,
)
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction
from camid.identification.estimate import estimate
from camid.identification.predictor import Predictor
from camid.identification.structure import Structure
from camid.paper.cases import PARAMETERS, declared_experiment
from camid.paper.datasets import believed_plant

Array = NDArray[np.float64]

# (a) to (e) of the figure, in the words of its legend.
MODELS = ("exact", "first-order-hold", "model-2", "model-3", "instant")


def compute(settings: Mapping[str, Any], shared: Mapping[str, Any]) -> pd.DataFrame:
    """Identify the paper's plant seen by cameras of every exposure with five declarations of the sensor.

    The input is held and there is no noise, so every error is a bias. Models: ``exact`` (camera with the true
    exposure), ``first-order-hold`` (the paper's argument: first-order hold, instant sensor, u[k] paired with w[k+1]),
    ``model-2`` (mean of the positions at the start and end of the true exposure), ``model-3`` (instant sensor with a
    latency of half the true exposure) and ``instant`` (held input, instant sensor at the time of delivery).

    Parameters
    ----------
    settings : mapping
        ``periods`` in s, ``exposures`` as shares of the period.
    shared : mapping
        Sections ``plant`` and ``excitation``.

    Returns
    -------
    DataFrame
        One row per fit: ``period`` (s), ``exposure`` (share of the period), ``model``, ``converged``, ``error_<p>`` in
        percent of the true value.
    """
    plant = believed_plant(shared["plant"])
    signal = excitation_signal(shared["excitation"])
    rows: list[dict[str, Any]] = []
    for period in settings["periods"]:
        for share in settings["exposures"]:
            output = sample(plant, signal, Acquisition(period, exposure=share * period))
            for model in MODELS:
                estimated, converged = _identify(model, plant, signal, output, period, share * period)
                rows.append(
                    {"period": float(period), "exposure": float(share), "model": model, "converged": converged}
                    | by_parameter("error", percent_errors(estimated, plant))
                )
    return pd.DataFrame(rows)


def _identify(
    model: str, plant: TransferFunction, signal: Array, output: Array, period: float, exposure: float
) -> tuple[TransferFunction, bool]:
    """Plant under one declaration of the sensor, and whether the estimate converged."""
    if model == "model-2":
        return _identify_mean_of_two_instants(plant, signal, output, period, exposure)
    if model == "first-order-hold":
        experiment = declared_experiment(signal, output, period, {"hold": "foh", "sensor": "instant", "shift": 1})
    else:
        declared = {
            "exact": Acquisition(period, exposure=exposure),
            "model-3": Acquisition(period, sensor="instant", latency=0.5 * exposure),
            "instant": Acquisition(period, sensor="instant"),
        }[model]
        experiment = whole_experiment(signal, output, declared)
    result = estimate(Structure.of_order(2, 0), [experiment], nominal=plant)
    return result.plant, result.converged


def _identify_mean_of_two_instants(
    plant: TransferFunction, signal: Array, output: Array, period: float, exposure: float
) -> tuple[TransferFunction, bool]:
    """Output-error estimate under Model #2, which is not a sensor of the public interface.

    The mean of the positions at the start and end of the exposure is the mean of two instant sensors, one of them with
    a latency of the exposure: outputs and sensitivities of the two are averaged and given to
    ``scipy.optimize.least_squares``, started at the truth.
    """
    from scipy.optimize import least_squares

    structure = Structure.of_order(2, 0)
    ends = [
        Predictor.around(
            structure,
            [whole_experiment(signal, output, Acquisition(period, sensor="instant", latency=latency))],
            np.asarray(plant.denominator),
        )
        for latency in (0.0, exposure)
    ]

    def residual(parameters: Array) -> Array:
        return np.asarray(np.mean([end.linearise(parameters)[0] for end in ends], axis=0))

    def jacobian(parameters: Array) -> Array:
        return np.asarray(-np.mean([end.linearise(parameters)[1] for end in ends], axis=0))

    start = ends[0].from_physical(np.array([*plant.numerator, *plant.denominator[1:]]))
    solution = least_squares(residual, start, jac=jacobian, method="lm", xtol=1e-14, ftol=1e-14, gtol=1e-14)
    return structure.plant(ends[0].to_physical(solution.x)), bool(solution.success)


def quantities(table: pd.DataFrame) -> dict[str, tuple[float, str]]:
    """Largest bias of each model (over exposures and parameters), alone and at each period.

    Besides: ``foh_against_camera_at_full_exposure`` (% that the paper's argument errs where it should be exact),
    ``ratio_model-2_to_model-3`` (of the biases of b0 at the shortest exposure of the longest period) and
    ``foh_better_than_instant_from`` (share of the period from which the paper's argument errs less than an instant
    sensor, at the shortest period).
    """
    errors = [f"error_{p}" for p in PARAMETERS]
    largest = table.assign(largest=table[errors].abs().max(axis=1))
    shortest, full = float(table["exposure"].min()), float(table["exposure"].max())

    def worst(rows: pd.DataFrame) -> float:
        return float(rows["largest"].max())

    found: dict[str, tuple[float, str]] = {
        "shortest_exposure": (shortest, "T"),
        "not_converged": (float((~table["converged"]).sum()), "fits"),
    }
    for model, group in largest.groupby("model"):
        found[f"largest_{model}"] = (worst(group), "%")
        for period, at_period in group.groupby("period"):
            found[f"largest_{model}_at_{period:g}"] = (worst(at_period), "%")
    hold = largest[largest["model"] == "first-order-hold"]
    found["foh_at_full_exposure"] = (worst(hold[hold["exposure"] == full]), "%")
    found["foh_at_full_exposure_of"] = (full, "T")
    start = table[(table["period"] == table["period"].max()) & (table["exposure"] == shortest)].set_index("model")
    found["ratio_model-2_to_model-3"] = (float(start["error_b0"]["model-2"] / start["error_b0"]["model-3"]), "")
    fast = largest[largest["period"] == table["period"].min()].pivot(
        index="exposure", columns="model", values="largest"
    )
    better = fast.index[fast["first-order-hold"] < fast["instant"]]
    found["foh_better_than_instant_from"] = (float(better.min()) if len(better) else float("nan"), "T")
    return found


def conclusion(value: Mapping[str, float]) -> str:
    """The answer for an engineer."""
    periods = sorted(float(k.rsplit("_", 1)[1]) for k in value if k.startswith("largest_exact_at_"))
    milliseconds = ", ".join(f"{1e3 * p:g}" for p in periods)

    def listed(model: str) -> str:
        return ", ".join(f"{value[f'largest_{model}_at_{p:g}']:.2g}" for p in periods) + " %"

    exact = value["largest_exact"]
    declared = (
        "Declare the exposure and there is no bias"
        if exact < NO_BIAS
        else f"Even with the exposure declared the largest bias is {exact:.2g} %"
    )
    full = value["foh_at_full_exposure"]
    argument = (
        f"the paper's first-order hold is exact only at {value['foh_at_full_exposure_of']:g} T"
        if full < NO_BIAS
        else f"the paper's first-order hold errs by {full:.2g} % even at {value['foh_at_full_exposure_of']:g} T"
    )
    ratio = value["ratio_model-2_to_model-3"]
    relation = (
        "Model #3 (half as wrong, with the opposite sign)"
        if abs(ratio + 2.0) < 0.1
        else f"Model #3 (biases in the ratio {ratio:.2g})"
    )
    return (
        f"{declared}; {argument} and errs by up to {listed('first-order-hold')} with shorter shutters down to "
        f"{value['shortest_exposure']:g} T (T = {milliseconds} ms). With the true exposure, Model #2 errs by up to "
        f"{listed('model-2')}, {relation} by up to {listed('model-3')}; an instant sensor errs by up to "
        f"{listed('instant')} and is the better guess than a first-order hold for shutters below "
        f"{value['foh_better_than_instant_from']:g} T."
    )
