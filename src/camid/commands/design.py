"""``camid.design``: the next experiment from a diagnosis, or from simulations that are held against each other."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from camid.diagnosis.diagnosis import Diagnosis
from camid.diagnosis.watch import Watch
from camid.effects.own_effects import EffectSource, own_effects
from camid.engine.mechanics import NotApplicable
from camid.errors import InputError
from camid.experiment_design.result import Design
from camid.experiment_design.run import Task, design_for
from camid.experiment_design.sources import (
    Wishes,
    known_from_diagnosis,
    known_from_folder,
    known_from_simulations,
    limits_of,
    noise_of,
)
from camid.identification.from_recordings import RecordingSource, SimulationSource
from camid.linear_algebra_threads import one_blas_thread

# Seconds after which nothing new is tried.
TIME_LIMIT = 50.0


@one_blas_thread()
def design(
    source: Diagnosis | SimulationSource | Sequence[SimulationSource],
    *,
    amplitude: tuple[float, float] | None = None,
    rate: float | None = None,
    duration: float | None = None,
    travel: tuple[float, float] | None = None,
    frame_rate: float | Sequence[float] = (),
    exposure: float | Sequence[float] = (),
    initial_position: float | Sequence[float] = (),
    noise: float | None = None,
    recording: RecordingSource | Sequence[RecordingSource] = (),
    progress: Callable[[str], None] | None = None,
    time_limit: float | None = TIME_LIMIT,
    effects: Sequence[EffectSource] | EffectSource = (),
) -> Design:
    """Compute the next experiment: the one that tells remaining hypotheses apart, or determines coefficients.

    Limits are in the units of the columns of the rig's files. What is not given is as in the recordings that were
    diagnosed; the travel may then be a tenth larger.

    Parameters
    ----------
    source : Diagnosis, folder of a diagnosis, simulation, or list of simulations
        What is to be told apart. Of one simulation, or a diagnosis with one name, the coefficients are determined.
    amplitude : (float, float), optional
        Least and largest input.
    rate : float, optional
        Largest change of the input in a second.
    duration : float, optional
        Seconds.
    travel : (float, float), optional
        Least and largest reading of the position.
    frame_rate, exposure, initial_position : float or sequence of float, optional
        What can be changed beside the input: frames per second, seconds, readings from which the rig can be released.
    noise : float, optional
        Standard deviation of a reading.
    recording : path, DataFrame, or list of them, optional
        Recordings of the rig, for simulations: they are fitted to it first. For the folder of a diagnosis: those that
        were diagnosed, so that rivals are fitted to them and the experiment together.
    progress : callable, optional
        Called with a sentence about the current step.
    time_limit : float, optional
        Seconds after which nothing new is tried; None for no limit.
    effects : sequence of path or subclass of Effect, optional
        Effects of your own that the hypotheses hold. A file is Python, and is run.

    Returns
    -------
    Design
        :func:`camid.experiment_design.results_folder.write_design` puts it into files.

    Raises
    ------
    InputError
        If limits are missing, contradict each other or cannot be kept, or the rig has no input to design.
    """
    watch = Watch(progress, time_limit)
    watch.say("reading what is to be told apart")
    wishes = Wishes(
        _two(amplitude, "amplitude"),
        rate,
        duration,
        _two(travel, "travel"),
        _several(frame_rate),
        _several(exposure),
        _several(initial_position),
        noise,
    )
    if any(f <= 0.0 for f in wishes.frame_rates):
        raise InputError("a frame rate must be above zero", hint="give it in frames per second")
    recordings = list(recording) if isinstance(recording, list | tuple) else [recording]
    with own_effects(effects):
        found = _designed(source, wishes, recordings, watch)
    late = watch.warning()
    return replace(found, warnings=[*found.warnings, *([late] if late else [])])


def _designed(
    source: Diagnosis | SimulationSource | Sequence[SimulationSource],
    wishes: Wishes,
    recordings: list[RecordingSource],
    watch: Watch,
) -> Design:
    """The design for what is wished."""
    period = 1.0 / min(wishes.frame_rates) if wishes.frame_rates else None
    try:
        if isinstance(source, Diagnosis):
            known = known_from_diagnosis(source)
        elif isinstance(source, str | os.PathLike) and _is_diagnosis(Path(source)):
            known = known_from_folder(Path(source), recordings)
        else:
            sources = list(source) if isinstance(source, list | tuple) else [source]
            known = known_from_simulations(sources, recordings, period)
        limits, noise = limits_of(known, wishes), noise_of(known, wishes)
        task = Task(known.hypotheses, limits, noise, known.rows, known.experiments, known.earlier)
        found = design_for(task, watch)
    except InputError:
        raise
    except (NotApplicable, ValueError, ArithmeticError, np.linalg.LinAlgError) as error:
        raise InputError(f"no design: {error}", hint="check the simulations and the units") from None
    return replace(found, source=known.source, warnings=[*found.warnings, *known.warnings])


def _is_diagnosis(path: Path) -> bool:
    return path.is_dir() or path.suffix == ".json"


def _several(values: float | Sequence[float]) -> tuple[float, ...]:
    return (float(values),) if isinstance(values, int | float) else tuple(float(v) for v in values)


def _two(limits: tuple[float, float] | None, name: str) -> tuple[float, float] | None:
    if limits is None:
        return None
    if len(limits) != 2 or not all(np.isfinite(limits)) or limits[0] > limits[1]:
        raise InputError(f"{name} {limits}", hint="give a least and a largest number")
    return float(limits[0]), float(limits[1])
