"""A diagnosis from files and into files: diagnosis.json, improved.yaml, residuals.csv and report.html."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain import time_scale
from camid.diagnosis.diagnose import Outcome, investigate
from camid.diagnosis.fit import refit
from camid.diagnosis.problem import Model, Problem
from camid.diagnosis.result import Diagnosis
from camid.errors import InputError
from camid.identification.predictor import Experiment, Structure
from camid.loading import RecordingSource, SimulationSource, experiments_of
from camid.physics.declared import declared, effects_of
from camid.plant import TransferFunction
from camid.recording import Recording, write_table, write_whole
from camid.simulation import Simulation, load_simulation

Array = NDArray[np.float64]

FILES = ("diagnosis.json", "improved.yaml", "residuals.csv", "report.html")
# Share of a recording that validates where the simulation does not say, and how much more of the mismatch than elsewhere
# that part may hold before another one is taken.
VALIDATION_SHARE = 0.2
CONCENTRATED = 3.0
ROWS_A_NUMBER = 5
# Effects that a simulation declares in other words.
DECLARATIONS = ("input-hold", "exposure", "delay")


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
    structure = _structure(believed)
    _refuse_few(structure, experiments, recordings)
    problem = Problem(structure, experiments, [r.time for r in recordings], time_scale(tuple(structure.denominator)))
    nominal = Model(structure.coefficients(), effects)
    try:
        problem, validation, chosen = _with_validation(problem, nominal, held_out)
        outcome = investigate(problem, nominal, validation, chosen, progress)
    except InputError:
        raise
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
        _improved(believed, structure, outcome),
        [r.source for r in recordings],
        int(sum(e.used.sum() for e in problem.experiments)),
        recordings[0].period,
        time.perf_counter() - begun,
    )


def _structure(believed: Simulation) -> Structure:
    monic = believed.plant.monic
    if monic.order == 0:
        raise InputError("the plant has no dynamics", where=believed.source, mend="give it at least one pole")
    # A free decay says nothing of the numerator: it keeps its believed value.
    free = believed.free_numerator & (believed.input_column is not None)
    return Structure(np.array(monic.numerator), np.array(monic.denominator), free, believed.free_denominator)


def _refuse_few(structure: Structure, experiments: list[Experiment], recordings: list[Recording]) -> None:
    unknowns = int(structure.free.sum()) + structure.order * sum(e.estimate_initial_state for e in experiments)
    rows = int(sum(e.used.sum() for e in experiments))
    if rows < ROWS_A_NUMBER * (unknowns + 1):
        raise InputError(
            f"{rows} samples are too few to diagnose a plant of {unknowns} unknowns",
            where=recordings[0].source,
            mend=f"record at least {ROWS_A_NUMBER * (unknowns + 1)}",
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
    """The last part of a recording; where a single event makes most of the mismatch in it, the part with the least."""
    experiment = problem.experiments[0]
    residual = experiment.output - problem.simulate(refit(problem, Model(nominal.coefficients)).model)[0]
    parts = np.array_split(np.arange(len(residual)), round(1.0 / VALIDATION_SHARE))
    energy = np.array([float(np.median(residual[p] ** 2)) for p in parts])
    loud = energy[-1] > CONCENTRATED * float(np.mean(energy[:-1]))
    part = parts[int(np.argmin(energy[1:])) + 1] if loud else parts[-1]
    rows = np.zeros(len(residual), bool)
    rows[part] = True
    return rows & experiment.used


def _improved(believed: Simulation, structure: Structure, outcome: Outcome) -> Simulation:
    """The simulation with what was found: coefficients, corrected declarations, effects."""
    lead = believed.plant.denominator[0]
    model = outcome.decision.fitted.model
    plant = structure.plant(model.coefficients)
    covariance = np.square(lead) * outcome.covariance
    deviations = _in_shape(structure, np.sqrt(np.abs(np.diag(covariance))))
    finite = bool(np.all(np.isfinite(covariance)))
    acquisition = outcome.acquisition
    kept = [i for i, e in enumerate(outcome.effects) if e.identifier not in DECLARATIONS]
    return replace(
        believed,
        plant=TransferFunction(
            tuple(lead * b for b in model.coefficients[: structure.degree + 1]),
            tuple(lead * a for a in plant.denominator),
        ),
        hold=acquisition.hold,
        sensor=acquisition.sensor,
        exposure=acquisition.exposure if acquisition.sensor == "camera" else None,
        latency=acquisition.latency,
        standard_deviations=deviations if finite else None,
        covariance=_full(structure, covariance).tolist() if finite else None,
        effects=declared([outcome.effects[i] for i in kept], [outcome.deviations[i] for i in kept]),
    )


def _in_shape(structure: Structure, deviations: Array) -> dict[str, list[float]]:
    every = np.zeros(len(structure.free))
    every[structure.free] = deviations
    split = structure.degree + 1
    return {"numerator": every[:split].tolist(), "denominator": [0.0, *every[split:].tolist()]}


def _full(structure: Structure, covariance: Array) -> Array:
    free = np.flatnonzero(structure.free)
    result = np.zeros((len(structure.free), len(structure.free)))
    result[np.ix_(free, free)] = covariance
    return result


def write_diagnosis(diagnosis: Diagnosis, folder: Path, *, report: bool = True) -> list[Path]:
    """Write the files of a diagnosis into a folder, which is made if its parent is there; each whole or not at all.

    Parameters
    ----------
    diagnosis : Diagnosis
    folder : Path
    report : bool
        Whether to draw report.html, too.

    Returns
    -------
    list of Path

    Raises
    ------
    InputError
        If the folder cannot be written to.
    """
    import pandas as pd

    from camid.identification.result import without_infinities
    from camid.simulation import write_simulation

    prepare(folder)
    content: dict[str, Any] = without_infinities(diagnosis.to_mapping())
    text = json.dumps(content, indent=2, ensure_ascii=False) + "\n"
    write_whole(folder / "diagnosis.json", lambda path: path.write_text(text, encoding="utf-8"))
    comment = f"improved by camid diagnose from {', '.join(diagnosis.recordings)}: {diagnosis.verdict}"
    write_simulation(diagnosis.improved, folder / "improved.yaml", comment)
    signals = diagnosis.signals
    table = pd.DataFrame(
        {
            diagnosis.improved.time_column: signals.time,
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
    write_table(table, folder / "residuals.csv")
    written = [folder / name for name in FILES[:3]]
    if report:
        from camid.diagnosis.report import write_report

        write_report(diagnosis, folder / "report.html")
        written.append(folder / "report.html")
    return written


def prepare(folder: Path) -> None:
    """Make the folder for the results, or refuse before the work is done.

    Raises
    ------
    InputError
        If it is a file, or its parent does not exist.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError("this is a file", where=str(folder), mend="name a folder for the results")
    if not folder.resolve().parent.is_dir():
        raise InputError("no such folder", where=str(folder.resolve().parent), mend="make it, or write elsewhere")
    folder.mkdir(exist_ok=True)
