"""``camid.diagnose``: recordings and a simulation, loaded, diagnosed and put together into one result."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.analysis.diagnosed_responses import DiagnosedResponses
from camid.commands.results import DiagnosisResult
from camid.diagnosis.diagnosis import AS_GIVEN, IMPROVED, REFITTED, Diagnosis
from camid.diagnosis.moments_in_gaps import moments_in_gaps
from camid.diagnosis.provenance import provenance_of
from camid.diagnosis.residual.validation_rows import (
    refuse_too_short_to_diagnose,
    with_validation,
    without_unknown_input,
)
from camid.diagnosis.run import investigate
from camid.diagnosis.watch import EFFORT, TIME_LIMIT, Watch
from camid.effects.declared import effects_of
from camid.effects.own_effects import EffectSource, files_of, own_effects
from camid.engine.mechanics import MotionJumps, NotApplicable, mechanics_of
from camid.errors import InputError
from camid.experiment_design.quick import with_designed_experiments
from camid.fitting.from_simulation import model_of, problem_of, refuse_stillness, structure_of
from camid.identification.from_recordings import (
    RecordingSource,
    SimulationSource,
    experiments_or_free_decay,
    warnings_of,
)
from camid.linear_algebra_threads import one_blas_thread
from camid.number_text import printable, with_deviation
from camid.recording.recording import Recording
from camid.side_by_side import with_a_copy
from camid.simulation.file import load_simulation
from camid.simulation.model import Simulation


@one_blas_thread()
def diagnose(
    recording: RecordingSource | Sequence[RecordingSource],
    simulation: SimulationSource,
    *,
    progress: Callable[[str], None] | None = None,
    time_limit: float | None = TIME_LIMIT,
    effort: float | None = EFFORT,
    effects: Sequence[EffectSource] | EffectSource = (),
) -> DiagnosisResult:
    """Find, name and model what a simulation leaves out.

    Parameters
    ----------
    recording : path, DataFrame, or list of them
        Of one rig. All are fitted, and a fifth of each validates; of several runs in one file the last one validates.
        The simulation may say otherwise.
    simulation : path, mapping or Simulation
        What is believed of the rig: structure, nominal coefficients, declarations, effects that are known already.
    progress : callable, optional
        Called with a sentence about the current step.
    time_limit : float, optional
        Seconds after which nothing new is tried: the answer is the best until then, and its warnings say what was left
        out. None for no limit.
    effort : float, optional
        How much is simulated before nothing new is tried, in multiples of the usual, which bounds the time to some
        seconds; the answer does not depend on the machine. None for as much as it takes.
    effects : sequence of path or subclass of Effect, optional
        Effects of your own that the search and the simulation may use. A file is Python, and is run.

    Returns
    -------
    DiagnosisResult
        :func:`camid.diagnosis.results_folder.write_diagnosis` puts it into files; ``compare``, ``bode``, ``poles``,
        ``step`` and ``residuals`` draw it beside what was believed.

    Raises
    ------
    InputError
        If recording and simulation do not fit together or the data are too few, or an effect of your own is wrong.
    """
    started = time.perf_counter()
    with own_effects(effects) as own:
        found = _diagnosed(recording, load_simulation(simulation), Watch(progress, time_limit, effort))
    return replace(
        found,
        seconds=time.perf_counter() - started,
        own_titles={kind.identifier: kind.title for kind in own},
        own_files=files_of(effects),
    )


def _diagnosed(
    recording: RecordingSource | Sequence[RecordingSource], believed: Simulation, watch: Watch
) -> DiagnosisResult:
    """Diagnosis of what a simulation declares."""
    progress = watch.progress
    effects = effects_of(believed)
    refuse_stillness(believed)
    believed, recordings, experiments, held_out = experiments_or_free_decay(recording, believed, progress)
    experiments, held_out = without_unknown_input(experiments, held_out, believed)
    structure = structure_of(believed)
    refuse_too_short_to_diagnose(structure, experiments, recordings)
    problem = problem_of(believed, structure, recordings, experiments)
    nominal = model_of(problem, effects)
    try:
        mechanics_of(problem.chain(nominal, 0), experiments[0].signal)  # refuses before anything takes long
        one_file = not isinstance(recording, list | tuple) or len(recording) == 1
        last_judges = one_file and len(set(problem.runs)) > 1
        problem, validation, chosen = with_validation(problem, nominal, held_out, last_judges=last_judges)
        watch.count(problem.work, len(problem.output), len(problem.fitted_runs))
        diagnosis = investigate(believed, problem, nominal, validation, chosen, watch)
        watch.say("designing the next experiment")
        with with_a_copy():
            diagnosis = with_designed_experiments(diagnosis)
    except InputError:
        raise
    except MotionJumps:
        raise InputError(
            "the plant has as many zeros as poles: its motion jumps with the input, and has no velocity to diagnose",
            where=f"{believed.source}, plant",
            hint="add a fast pole, such as that of the amplifier; identify and simulate take the plant as it is",
        ) from None
    except NotApplicable as error:
        raise InputError(
            str(error),
            where=believed.effects[0].where if believed.effects else believed.source,
            hint="remove the effect, or give the plant more poles than zeros",
        ) from None
    except (ValueError, ArithmeticError, np.linalg.LinAlgError) as error:
        raise InputError(
            f"no diagnosis: {error}", where=recordings[0].source, hint="check the simulation and the units"
        ) from None
    sources = recording if isinstance(recording, list | tuple) else [recording]
    found = replace(
        diagnosis,
        response_source=_responses(believed, diagnosis, recordings),
        provenance=provenance_of(sources, believed.source, _first_stamps(sources, recordings)),
        recordings=[r.source for r in recordings],
        period=recordings[0].period,
        fit=replace(diagnosis.fit, of_recording=_judged(recordings, problem.runs, validation)),
        warnings=[
            *warnings_of(recordings),
            *moments_in_gaps(diagnosis.findings, recordings),
            *diagnosis.warnings,
            *problem.kind.remarks(diagnosis.improved),
            *_left_open(diagnosis.improved),
            *([late] if (late := watch.warning()) else []),
        ],
    )
    return DiagnosisResult.of(found, sources, believed)


def _responses(believed: Simulation, diagnosis: Diagnosis, recordings: Sequence[Recording]) -> DiagnosedResponses:
    """Of the plant before and after."""
    models = {AS_GIVEN: believed, REFITTED: diagnosis.refitted, IMPROVED: diagnosis.improved}
    if not (diagnosis.findings or diagnosis.learned):
        del models[IMPROVED]
    return DiagnosedResponses({name: model for name, model in models.items() if model is not None}, recordings)


def _judged(recordings: Sequence[Recording], runs: Sequence[int], rows: Sequence[NDArray[np.bool_]]) -> str:
    """Which of several recordings hold the rows that judge: several columns of one are one."""
    every = sorted(set(runs))
    judging = [run for run in every if rows[run].any()]
    if len(every) == 1:
        return ""
    if len(judging) > 1:
        return f"the first of {len(judging)} recordings, and likewise of the others"
    one = recordings[judging[0]]
    return printable(f"run {one.experiment}" if one.experiment else one.source)


def _first_stamps(sources: Sequence[RecordingSource], recordings: Sequence[Recording]) -> list[float | None]:
    """First entry of the time column of each source; None where a file holds several runs of one rig."""
    if len(sources) == len(recordings):
        return [float(r.recorded_time[0]) for r in recordings]
    return [float(recordings[0].recorded_time[0]) if len(sources) == 1 else None] * len(sources)


def _left_open(improved: Simulation) -> list[str]:
    """What a simulation left open beside the plant, as it was estimated with it; a sentence each."""
    return [
        f"the {name} was left open: {with_deviation(value, deviation)}{unit}"
        for name, value, deviation, unit in (
            ("latency of the sensor", improved.known_latency, improved.latency_deviation, " s"),
            ("skew of its clock", improved.known_skew, improved.skew_deviation, ""),
        )
        if deviation is not None
    ]
