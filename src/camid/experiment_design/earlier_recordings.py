"""The recordings that were diagnosed, from the diagnosis itself or from their files."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.diagnosis import Diagnosis
from camid.errors import InputError
from camid.experiment_design.prediction import NoiseModel
from camid.experiment_design.together import Earlier, Recorded
from camid.fitting.from_simulation import problem_of, structure_of
from camid.fitting.problem import Problem
from camid.identification.from_recordings import RecordingSource, experiments_of
from camid.simulation.model import Simulation

Array = NDArray[np.float64]

RESIDUALS = "residuals.csv"
# Difference of two columns that are the same, as a share of their size.
SAME = 1e-6


def of_diagnosis(diagnosis: Diagnosis, noise: NoiseModel, period: float) -> Earlier | None:
    """The recordings of a diagnosis that is at hand; None where it compares something else than the output."""
    if diagnosis.residual_of != "output":
        return None
    every = (diagnosis.signals, *diagnosis.further_signals)
    recorded = tuple(Recorded(s.time, s.signal, s.recorded, s.fitted) for s in every)
    return Earlier(recorded, noise, period, diagnosis.improved.initial_state == "zero")


def of_files(
    folder: Path, recordings: Sequence[RecordingSource], simulation: Simulation, noise: NoiseModel, period: float
) -> Earlier:
    """The recordings of a diagnosis that was written into a folder.

    Raises
    ------
    InputError
        If these are not the recordings that were diagnosed.
    """
    found, experiments, _ = experiments_of(list(recordings), simulation, None)
    problem = problem_of(simulation, structure_of(simulation), found, experiments)
    output, fitted = _residuals(folder)
    mine = np.concatenate([e.output for e in problem.experiments])
    if len(mine) != len(output) or np.max(np.abs(mine - output)) > SAME * np.max(np.abs(output), initial=1e-300):
        raise InputError(
            "these are not the recordings that were diagnosed",
            where=str(recordings[0]),
            hint=f"name those of {folder}, in the same order, or none",
        )
    ends = np.cumsum([len(e.output) for e in problem.experiments])
    parts = np.split(fitted, ends[:-1])
    recorded = tuple(
        Recorded(time, e.signal, e.output, rows & e.used)
        for e, time, rows in zip(problem.experiments, problem.times, parts, strict=True)
    )
    return Earlier(recorded, noise, period, simulation.initial_state == "zero")


def of_problem(problem: Problem, noise: NoiseModel) -> Earlier:
    """The recordings that simulations were fitted to."""
    pairs = zip(problem.experiments, problem.times, strict=True)
    recorded = tuple(Recorded(time, e.signal, e.output, e.used) for e, time in pairs)
    at_rest = not any(e.estimate_initial_state for e in problem.experiments)
    return Earlier(recorded, noise, float(problem.acquisition.period), at_rest)


def _residuals(folder: Path) -> tuple[Array, NDArray[np.bool_]]:
    """What was recorded, and which rows were fitted, shapes (N,), as the folder of a diagnosis holds them."""
    path = folder / RESIDUALS
    try:
        with path.open(encoding="utf-8", newline="") as stream:
            rows = [(float(row["recorded"]), row["fitted"] == "1") for row in csv.DictReader(stream)]
    except (OSError, ValueError, KeyError):
        raise InputError(f"no {RESIDUALS} of a diagnosis", where=str(folder), hint="diagnose again") from None
    return np.array([value for value, _ in rows]), np.array([used for _, used in rows], bool)
