"""A diagnosis from files and into files: diagnosis.json, improved.yaml, residuals.csv and report.html."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.diagnose import investigate
from camid.diagnosis.fit import refit
from camid.diagnosis.improved import improved
from camid.diagnosis.problem import Model, Problem
from camid.diagnosis.result import Diagnosis
from camid.diagnosis.setup import model_of, problem_of, structure_of
from camid.engine import NotApplicable
from camid.errors import InputError
from camid.identification.predictor import Experiment, Structure
from camid.identification.result import without_infinities
from camid.loading import RecordingSource, SimulationSource, experiments_of, warnings_of
from camid.physics.declared import effects_of
from camid.recording import Recording, check_writable, write_whole
from camid.simulation import load_simulation, simulation_text

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

FILES = ("diagnosis.json", "improved.yaml", "residuals.csv", "report.html")
# Share of a recording that validates where the simulation does not say, and how much more of the mismatch than
# elsewhere that part may hold before another one is taken.
VALIDATION_SHARE = 0.2
CONCENTRATED = 3.0
# A part with a smaller share of the largest variance of the output is at rest.
AT_REST = 0.02
# Rows that are needed for an unknown of the plant, and in any case: the tests for structure hold up to sixty functions
# of input, motion and output against the residual.
ROWS_A_NUMBER = 5
FEWEST_ROWS = 100
RESIDUALS = (
    "recorded",
    "nominal",
    "refitted",
    "improved",
    "residual_refitted",
    "residual_improved",
    "equivalent_input",
    "fitted",
)


def diagnose(
    recording: RecordingSource | Sequence[RecordingSource],
    simulation: SimulationSource,
    progress: Callable[[str], None] | None = None,
) -> Diagnosis:
    """See :func:`camid.diagnose`."""
    begun = time.perf_counter()
    believed = load_simulation(simulation)
    effects = effects_of(believed)
    if believed.input_column is None and not believed.estimates_initial_state:
        raise InputError(
            "without input and at rest nothing moves",
            where=believed.source,
            mend="set initial_state: estimate for a free decay",
        )
    recordings, experiments, held_out = experiments_of(recording, believed, progress)
    structure = structure_of(believed)
    _refuse_few(structure, experiments, recordings)
    problem = problem_of(believed, structure, recordings, experiments)
    nominal = model_of(believed, structure, effects)
    try:
        problem, validation, chosen = _with_validation(problem, nominal, held_out)
        outcome = investigate(problem, nominal, validation, chosen, progress)
    except InputError:
        raise
    except NotApplicable as error:
        raise InputError(
            str(error),
            where=believed.effects[0].where if believed.effects else believed.source,
            mend="remove the effect, or give the plant more poles than zeros",
        ) from None
    except (ValueError, ArithmeticError, np.linalg.LinAlgError) as error:
        raise InputError(
            f"no diagnosis: {error}", where=recordings[0].source, mend="check the simulation and the units"
        ) from None
    return Diagnosis(
        outcome.verdict,
        outcome.explanation,
        outcome.location,
        outcome.findings,
        outcome.fit,
        outcome.undetectable,
        outcome.coefficients,
        outcome.tests,
        outcome.signals,
        improved(believed, structure, outcome, problem.acquisition),
        [r.source for r in recordings],
        int(sum(e.used.sum() for e in problem.experiments)),
        recordings[0].period,
        time.perf_counter() - begun,
        list(warnings_of(recordings)),
    )


def _refuse_few(structure: Structure, experiments: list[Experiment], recordings: list[Recording]) -> None:
    unknowns = int(structure.free.sum()) + structure.order * sum(e.estimate_initial_state for e in experiments)
    rows = int(sum(e.used.sum() for e in experiments))
    needed = max(ROWS_A_NUMBER * (unknowns + 1), FEWEST_ROWS)
    if rows < needed:
        raise InputError(
            f"{rows} samples are too few to diagnose a plant of {unknowns} unknowns",
            where=recordings[0].source,
            mend=f"record at least {needed} outside of the validation rows",
        )


def _with_validation(
    problem: Problem, nominal: Model, held_out: list[NDArray[np.bool_]]
) -> tuple[Problem, list[NDArray[np.bool_]], bool]:
    """The problem without the rows that validate, these rows, and whether they were chosen here."""
    if any(rows.any() for rows in held_out):
        return problem, held_out, False
    experiments = problem.experiments
    if len(experiments) > 1:
        validation = [np.zeros(len(e.used), bool) for e in experiments[:-1]] + [experiments[-1].used.copy()]
        # The last recording's initial state has to come from somewhere: from its first fifth.
        if experiments[-1].estimate_initial_state:
            validation[-1][: len(validation[-1]) // 5] = False
    else:
        validation = [_quiet_part(problem, nominal)]
    used = [e.used & ~rows for e, rows in zip(experiments, validation, strict=True)]
    return problem.with_used(used), validation, True


def _quiet_part(problem: Problem, nominal: Model) -> NDArray[np.bool_]:
    """The last part of a recording that judges: another one where the rig rests or a single event makes the mismatch.

    Where the rig hardly moves in the last part (a free decay), it is the part after the first that moves most; where a
    single event makes most of the mismatch in it, the part with the least.
    """
    experiment = problem.experiments[0]
    residual = experiment.output - problem.simulate(refit(problem, replace(nominal, effects=())).model)[0]
    parts = np.array_split(np.arange(len(residual)), round(1.0 / VALIDATION_SHARE))
    energy = np.array([float(np.median(residual[p] ** 2)) for p in parts])
    motion = np.array([float(np.var(experiment.output[p])) for p in parts])
    if motion[-1] < AT_REST * float(np.max(motion[1:])):
        part = parts[int(np.argmax(motion[1:])) + 1]
    elif energy[-1] > CONCENTRATED * float(np.mean(energy[:-1])):
        part = parts[int(np.argmin(energy[1:])) + 1]
    else:
        part = parts[-1]
    rows = np.zeros(len(residual), bool)
    rows[part] = True
    return rows & experiment.used


def write_diagnosis(diagnosis: Diagnosis, folder: str | os.PathLike[str], *, report: bool = True) -> list[Path]:
    """Write the files of a diagnosis into a folder, which is made if its parent is there; each whole or not at all.

    Everything is made before the first file is written, so that what goes wrong leaves the folder as it was.

    Parameters
    ----------
    diagnosis : Diagnosis
    folder : path
    report : bool
        Whether to draw report.html, too; if not, one of an earlier diagnosis in the folder is removed.

    Returns
    -------
    list of Path

    Raises
    ------
    InputError
        If the folder cannot be written to; it says which files were written before.
    """
    folder = Path(folder)
    check_folder(folder)
    contents = {
        FILES[0]: json.dumps(without_infinities(diagnosis.to_mapping()), indent=2, ensure_ascii=False) + "\n",
        FILES[1]: simulation_text(
            diagnosis.improved,
            f"improved by camid diagnose from {', '.join(diagnosis.recordings)}: {diagnosis.verdict}",
        ),
        FILES[2]: residuals(diagnosis).to_csv(index=False),
    }
    if report:
        from camid.diagnosis.report import render

        contents[FILES[3]] = render(diagnosis)
    written: list[Path] = []
    try:
        folder.mkdir(exist_ok=True)
        if not report:
            (folder / FILES[3]).unlink(missing_ok=True)
        for name, content in contents.items():
            # A name from a file system may hold bytes that are no text.
            data = content.encode("utf-8", errors="replace")
            write_whole(folder / name, lambda path, data=data: path.write_bytes(data))  # type: ignore[misc]
            written.append(folder / name)
    except (OSError, InputError) as error:
        done = f"; written before: {', '.join(p.name for p in written)}" if written else ""
        problem = error.problem if isinstance(error, InputError) else f"cannot write ({error.strerror or error})"
        raise InputError(f"{problem}{done}", where=str(folder), mend="make room, or write elsewhere") from None
    return written


def residuals(diagnosis: Diagnosis) -> pd.DataFrame:
    """Table of residuals.csv: one row a row of the (first) recording."""
    import pandas as pd

    signals = diagnosis.signals
    time = diagnosis.improved.time_column
    return pd.DataFrame(
        {
            # A time column that is called like one of the others keeps its place under a name of its own.
            time if time not in RESIDUALS else f"{time} (time)": signals.time,
            "recorded": signals.recorded,
            "nominal": signals.nominal,
            "refitted": signals.refitted,
            "improved": signals.improved,
            "residual_refitted": signals.recorded - signals.refitted,
            "residual_improved": signals.recorded - signals.improved,
            "equivalent_input": signals.equivalent_input,
            "fitted": signals.fitted.astype(int),
        }
    )


def check_folder(folder: Path, inputs: Sequence[Path] = ()) -> None:
    """Refuse, before the work is done, a folder that the results cannot go to.

    Parameters
    ----------
    folder : Path
    inputs : sequence of Path
        What the results are made from, and what they may not overwrite.

    Raises
    ------
    InputError
        If it is a file or cannot be written to, its parent does not exist, or one of the results would overwrite an
        input or is called like a folder.
    """
    parent = folder.resolve().parent
    if folder.exists() and not folder.is_dir():
        raise InputError("this is a file", where=str(folder), mend="name a folder for the results")
    if not parent.is_dir():
        raise InputError("no such folder", where=str(parent), mend="make it, or write elsewhere")
    if not os.access(folder if folder.exists() else parent, os.W_OK | os.X_OK):
        raise InputError("no right to write here", where=str(folder), mend="write elsewhere")
    for name in FILES:
        target = folder / name
        for path in inputs:
            if target.exists() and path.exists() and target.samefile(path):
                raise InputError(
                    f"{name} would overwrite what it is made from", where=str(path), mend="name another folder"
                )
        if folder.exists():
            check_writable(target)
