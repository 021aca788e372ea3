"""Further proofs: recordings by authors who have read the documentation alone, diagnosed and scored like the first.

Their generators were written without a look at the tool's code or at the first generator: other rigs, integrators,
excitations and strengths. What the proofs say does not rest on one author's idea of a rig. Those in
:mod:`camid.proof.second_author` are rigs of all kinds, those in :mod:`camid.proof.undeclared_loops` machines under
industrial controllers that the user has not declared.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import pandas as pd

from camid.errors import InputError
from camid.proof.diagnoses import diagnose_all
from camid.proof.score_table import PARAMETER_COLUMNS, WEIGHT_COLUMNS, nrmse
from camid.proof.scoring import STRONG, parameter_rows, score, weight_rows
from camid.proof.sealed_files import DIAGNOSIS, IMPROVED, RECORDING, SIMULATION, write_table, write_yaml
from camid.proof.second_author.concealment import NotShownError
from camid.proof.second_author.recordings import make as second_author
from camid.proof.targets import Line, calibration, naming, recovered_line, run_time_lines, share_line
from camid.proof.undeclared_loops.recordings import make as undeclared_loops

SMALLEST_GAIN = 1e-3


class Made(Protocol):
    """A recording, what its user believes, another recording of the same rig, and the truth."""

    @property
    def recording(self) -> pd.DataFrame:
        """Columns t (s), u and y, in the units of the cells."""

    @property
    def simulation(self) -> dict[str, Any]:
        """Content of the simulation file."""

    @property
    def again(self) -> pd.DataFrame | None:
        """The same of another recording, and ``clean``: without noise; None where there is none."""

    @property
    def truth(self) -> dict[str, Any]:
        """Kind, rig, excitation, noise and effects."""


# Each makes a recording from a seed, its number and how many there are.
AUTHORS: dict[str, Callable[[int, int, int], Made]] = {
    "second_author": second_author,
    "undeclared_loops": undeclared_loops,
}


def diagnose_and_score(
    author: str, indices: list[int], seed: int, count: int, folder: Path
) -> tuple[pd.DataFrame, pd.DataFrame, pd.DataFrame]:
    """Make, diagnose and score some of the recordings.

    Parameters
    ----------
    author : str
        Of `AUTHORS`.
    indices : list of int
    seed, count : int
        Of all of them.
    folder : Path
        Gets recordings and diagnoses.

    Returns
    -------
    tuple of DataFrame
        One row per recording (:func:`camid.proof.scoring.score`, ``recovered`` and ``seconds``), per parameter and per
        member of a class, all with ``index``; none for laws that no rig shows together.
    """
    recordings, diagnoses = folder / "recordings", folder / "diagnoses"
    made: dict[int, Made] = {}
    for index in indices:
        try:
            made[index] = AUTHORS[author](seed, index, count)
        except NotShownError:
            continue
        write_table(made[index].recording, recordings / str(index) / RECORDING)
        write_yaml(made[index].simulation, recordings / str(index) / SIMULATION)
    seconds = diagnose_all(list(made), recordings, diagnoses).set_index("index")["seconds"]
    scores: list[dict[str, Any]] = []
    parameters: list[dict[str, Any]] = []
    weights: list[dict[str, Any]] = []
    for index, case in made.items():
        file = diagnoses / str(index) / DIAGNOSIS
        diagnosis = json.loads(file.read_text(encoding="utf-8")) if file.exists() else None
        truth = {**case.truth, "snr_db": np.nan, "repeatable": case.again is not None, "images": False}
        recovered = np.nan if diagnosis is None else recovered_share(case, diagnoses / str(index) / IMPROVED)
        words = {key: case.truth[key] for key in ("rig", "excitation", "noise")}
        row = {"index": index, **score(truth, diagnosis), **words}
        scores.append({**row, "recovered": recovered, "seconds": float(seconds[index])})
        parameters += [{"index": index, **row} for row in parameter_rows(truth, diagnosis)]
        weights += [{"index": index, **row} for row in weight_rows(truth, diagnosis)]
    return (
        pd.DataFrame(scores),
        pd.DataFrame(parameters, columns=PARAMETER_COLUMNS).astype({"covered": bool}),
        pd.DataFrame(weights, columns=WEIGHT_COLUMNS).astype({"right": bool, "weight": float}),
    )


def recovered_share(case: Made, improved: Path) -> float:
    """Share of the avoidable error that the improved model avoids on another recording of the rig.

    NaN where there is no other recording, where nothing is to be gained, in a closed loop and where the simulation
    declares units.
    """
    from camid.commands.identify import identify
    from camid.commands.simulate import simulate

    if case.again is None or _declares_units(case.simulation) or "controller" in case.simulation:
        return float("nan")
    recorded = case.again["y"].to_numpy(float)
    table = case.again.drop(columns="clean")
    try:
        refitted = identify(case.recording, case.simulation).simulation
        errors = [nrmse(simulate(table, m)["simulated"].to_numpy(float), recorded) for m in (refitted, improved)]
    except InputError:
        return float("nan")
    floor = nrmse(case.again["clean"].to_numpy(float), recorded)
    if errors[0] - floor <= SMALLEST_GAIN * floor:
        return float("nan")
    return (errors[0] - errors[1]) / (errors[0] - floor)


def _declares_units(simulation: Mapping[str, Any]) -> bool:
    return any("unit" in part for part in simulation.values() if isinstance(part, Mapping))


def author_lines(scores: pd.DataFrame, parameters: pd.DataFrame, weights: pd.DataFrame) -> list[Line]:
    """Every measured rate beside the target of the first proof."""
    strong = scores[scores["multiple"] >= STRONG]
    named = strong["kind"].isin(["single", "several"])
    groups = {
        "": (strong[named & ~strong["inexact"]], ", laws of the catalogue", 0.95),
        "_inexact": (strong[named & strong["inexact"]], ", law not exact", 0.9),
        "_outside": (strong[strong["kind"] == "outside"], ", outside the catalogue", None),
    }
    return [
        *(line for line in naming(scores) if not line.quantity.endswith("invisible")),
        *(
            recovered_line(f"recovered_share{group}", f"{which}: {{}} on another recording", part["recovered"], target)
            for group, (part, which, target) in groups.items()
        ),
        share_line(
            "coverage",
            "95 % intervals of parameters that hold the truth",
            parameters["covered"],
            at_least=92.0,
            at_most=98.0,
        ),
        *calibration(weights),
        *run_time_lines(scores["seconds"]),
    ]
