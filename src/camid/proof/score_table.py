"""Scores of concealed recordings: what the diagnosis says, and what its improved model gains on held-out recordings."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.errors import InputError
from camid.proof.scoring import parameter_rows, score, weight_rows
from camid.proof.sealed_files import DIAGNOSIS, HELD_OUT, IMPROVED, RECORDING, SIMULATION, read_truth
from camid.simulation.model import Simulation

Array = NDArray[np.float64]

# Where the noise-free output is nearer to the refitted one than this share of the noise, nothing can be gained.
SMALLEST_GAIN = 1e-3
PARAMETER_COLUMNS = ["index", "id", "parameter", "true", "value", "std", "unit", "covered"]
WEIGHT_COLUMNS = ["index", "id", "weight", "right"]


def score_cases(
    indices: list[int], recordings: Path, held_out: Path, truths: Path, diagnoses: Path
) -> tuple[pd.DataFrame, pd.DataFrame, pd.DataFrame]:
    """Score diagnoses.

    Returns
    -------
    tuple of DataFrame
        One row per recording (:func:`camid.proof.scoring.score` and :func:`recovered_shares`), one row per parameter
        (:func:`camid.proof.scoring.parameter_rows`), one row per member of a class
        (:func:`camid.proof.scoring.weight_rows`), all with ``index``.
    """
    scores: list[dict[str, Any]] = []
    parameters: list[dict[str, Any]] = []
    weights: list[dict[str, Any]] = []
    for index in indices:
        truth = read_truth(index, truths)
        file = diagnoses / str(index) / DIAGNOSIS
        diagnosis = json.loads(file.read_text(encoding="utf-8")) if file.exists() else None
        modelled = truth["kind"] in {"single", "several", "outside"} and truth["repeatable"] and diagnosis is not None
        shares = recovered_shares(index, recordings, held_out, diagnoses) if modelled else _NO_SHARES
        scores.append({"index": index, **score(truth, diagnosis), **shares})
        parameters += [{"index": index, **row} for row in parameter_rows(truth, diagnosis)]
        weights += [{"index": index, **row} for row in weight_rows(truth, diagnosis)]
    return (
        pd.DataFrame(scores),
        pd.DataFrame(parameters, columns=PARAMETER_COLUMNS).astype({"covered": bool}),
        pd.DataFrame(weights, columns=WEIGHT_COLUMNS).astype({"right": bool, "weight": float}),
    )


_NO_SHARES = {
    f"{quantity}_{name}": np.nan for name in HELD_OUT for quantity in ("refitted", "improved", "floor", "share")
}


def recovered_shares(index: int, recordings: Path, held_out: Path, diagnoses: Path) -> dict[str, float]:
    """Share of the avoidable error that the improved model avoids on recordings that were not fitted.

    Returns
    -------
    dict
        For each held-out recording the NRMSE of the refitted nominal simulation (``refitted_…``), of improved.yaml
        (``improved_…``) and of the noise-free output (``floor_…``), and ``share_…`` = (refitted − improved) /
        (refitted − floor); NaN where the refitted simulation leaves nothing to gain. Frames that were exposed before
        the recording do not count where the initial state is estimated: nobody knows of the motion then.
    """
    from camid.commands.identify import identify
    from camid.commands.simulate import rows_compared, simulate

    folder = recordings / str(index)
    try:
        refitted = identify(folder / RECORDING, folder / SIMULATION).simulation
    except InputError:  # without a refitted simulation there is nothing to compare with
        return dict(_NO_SHARES)
    models: dict[str, Simulation | Path] = {"refitted": refitted, "improved": diagnoses / str(index) / IMPROVED}
    found: dict[str, float] = {}
    for name in HELD_OUT:
        table = pd.read_csv(held_out / str(index) / f"{name}.csv")
        rows, simulated = np.ones(len(table), bool), {"floor": table["clean"].to_numpy(float)}
        for which, model in models.items():
            try:
                run = simulate(table, model)
            except InputError:  # a model that cannot be run on new data is infinitely wrong there
                simulated[which] = np.full(len(table), np.inf)
                continue
            simulated[which] = run["simulated"].to_numpy(float)
            if which == "refitted":
                rows = rows_compared(refitted, run)
        recorded = table["y"].to_numpy(float)
        errors = {which: nrmse(output[rows], recorded[rows]) for which, output in simulated.items()}
        found |= {f"{which}_{name}": error for which, error in errors.items()}
        avoidable = errors["refitted"] - errors["floor"]
        worthwhile = avoidable > SMALLEST_GAIN * errors["floor"]
        found[f"share_{name}"] = (errors["refitted"] - errors["improved"]) / avoidable if worthwhile else np.nan
    return found


def nrmse(simulated: Array, recorded: Array) -> float:
    """Root mean square of the difference over the standard deviation of the recorded output."""
    return float(np.sqrt(np.mean((simulated - recorded) ** 2)) / np.std(recorded))
