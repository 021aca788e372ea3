"""Recordings and a simulation, read, checked against each other and turned into what is identified."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.errors import InputError
from camid.identification.experiment import Experiment
from camid.identification.unknown_constants import with_unknown_constants
from camid.recording.read import read_recordings
from camid.recording.recording import Recording
from camid.recording.time_grid import noise_of
from camid.recording.two_rates import sum_of_logs
from camid.recording.units import Conversion
from camid.simulation.model import Simulation

Array = NDArray[np.float64]
# Periods that an unknown latency may have.
LATENCY_ALLOWED = 3
# Rows that are fitted at once: more take more than minutes, and more memory than most machines have. An identification
# keeps about 1 kB for each row, a diagnosis up to 3 kB.
MOST_ROWS = 3_000_000
RecordingSource = str | os.PathLike[str] | Any
SimulationSource = str | os.PathLike[str] | Mapping[str, Any] | Simulation


class ZeroInput(InputError):  # noqa: N818 - an InputError that callers may take for a free decay
    """The declared input is zero in every recording."""

    def __init__(self, column: str, where: str) -> None:
        hint = "for a free decay say input: null and initial_state: estimate in the simulation"
        super().__init__(f"column '{column}' is zero throughout", where=where, hint=hint)


def load_recordings(recording: RecordingSource, simulation: Simulation, *, output_needed: bool) -> list[Recording]:
    """Columns that a simulation names, checked against each other, of each experiment in a file."""
    reading = simulation.reading
    roles = {
        "time": simulation.time_column if reading.period is None else None,
        "input": simulation.input_column,
        **_output_roles(simulation),
        "reference": None if simulation.controller is None else simulation.controller.reference,
        "experiment": reading.experiment,
        "time of the frames": reading.frame_time,
        **{f"the added {column}": column for column in reading.added},
    }
    for (one, first), (other, second) in combinations(roles.items(), 2):
        if first is not None and first == second:
            raise InputError(
                f"{one} and {other} are the same column '{first}'", where=simulation.source, hint="name two columns"
            )
    outputs = simulation.output_columns or (simulation.output_column,)
    named = [roles["input"], roles["reference"]]
    required = [
        *(column for column in named if column is not None),
        *(outputs if output_needed else ()),
        *reading.added,
    ]
    optional = [] if output_needed else [*outputs]
    held = [column for column in (roles["input"], roles["reference"], *reading.added) if column is not None]
    conversions = {**dict.fromkeys(outputs, _from_zero(reading.output, simulation)), **reading.added}
    if roles["input"] is not None:
        conversions[roles["input"]] = replace(reading.input, offset=reading.input.offset + simulation.known_bias)
    if roles["reference"] is not None:
        conversions[roles["reference"]] = reading.reference
    found = read_recordings(
        recording,
        simulation.time_column,
        required,
        optional,
        reading,
        dict.fromkeys(held, simulation.hold),
        conversions,
    )
    if not simulation.estimates_initial_state:  # at rest where the input begins, not at the first frame
        found = [one.from_start_of_log() for one in found]
    if simulation.input_column is None or not reading.added:
        return found
    return [_with_added(one, simulation.input_column, list(reading.added)) for one in found]


def _output_roles(simulation: Simulation) -> dict[str, str]:
    """What the output columns are called in messages."""
    if not simulation.output_columns:
        return {"output": simulation.output_column}
    return {f"the reading {column}": column for column in simulation.output_columns}


def _with_added(recording: Recording, column: str, added: Sequence[str]) -> Recording:
    """The recording with the sum of the input and of what is added to it as its input."""

    def summed(columns: Mapping[str, Array]) -> dict[str, Array]:
        if column not in columns:  # where frames have times of their own, the input is not recorded at them
            return dict(columns)
        return {**columns, column: np.sum([columns[c] for c in (column, *added)], axis=0)}

    logs = {column: sum_of_logs(recording.logs, [column, *added])} if recording.logs else {}
    return replace(
        recording,
        columns=summed(recording.columns),
        recorded_columns=summed(recording.recorded_columns),
        logs=logs,
    )


def _from_zero(conversion: Conversion, simulation: Simulation) -> Conversion:
    """Conversion of the output, without its offset where that is subtracted."""
    if not simulation.is_read_from_zero or not isinstance(simulation.offset, float):
        return conversion
    return replace(conversion, offset=conversion.offset - simulation.offset)


def acquisition_of(recording: Recording, simulation: Simulation) -> Acquisition:
    """Acquisition that a simulation declares for a recording; InputError where it cannot be."""
    try:
        acquisition = simulation.acquisition(recording.period, recording.period_uncertainty)
    except InputError as error:
        taken = recording.units.get(simulation.time_column)
        if taken is None or simulation.reading.time.unit is not None:
            raise
        hint = f"{error.hint}; the times are read in {taken}, as their header says: declare another unit under time"
        raise InputError(error.problem, where=error.where, hint=hint) from None
    duration = float(recording.time[-1] - recording.time[0])
    if acquisition.latency > duration:
        raise InputError(
            f"latency = {acquisition.latency:g} s is longer than {recording.source}, which lasts {duration:g} s",
            where=f"{simulation.source}, sensor",
            hint="give it in seconds",
        )
    return acquisition


def experiment_of(recording: Recording, simulation: Simulation) -> Experiment:
    """A recording as identification sees it."""
    acquisition = acquisition_of(recording, simulation)
    count = len(recording)
    signal = np.zeros(count) if simulation.input_column is None else recording.columns[simulation.input_column]
    used = np.ones(count, bool)
    if simulation.estimates_initial_state and simulation.input_column is not None:
        # What the input did before the record is unknown, so frames exposed before its start say nothing.
        before = LATENCY_ALLOWED if simulation.latency == "estimate" else 0
        used[: acquisition.window()[0] + before] = False
    used &= ~recording.missing
    used &= recording.time >= recording.time[0] + simulation.reading.leave_out
    if not used.any():
        raise InputError(
            f"no row with an output is left to compare after {simulation.reading.leave_out:g} s",
            where=recording.source,
            hint=f"the recording lasts {recording.time[-1] - recording.time[0]:g} s: choose a shorter leave_out",
        )
    return Experiment(
        signal,
        recording.columns[simulation.output_column],
        acquisition,
        used,
        simulation.estimates_initial_state,
        simulation.known_offset,
        estimate_latency=simulation.latency == "estimate",
        estimate_skew=simulation.skew == "estimate",
        input_log=None if simulation.input_column is None else recording.logs.get(simulation.input_column),
        interpolated=recording.interpolated,
    )


def readings_of(recording: Recording, simulation: Simulation) -> list[tuple[Recording, Experiment]]:
    """A recording as identification sees it, once for each column of the sensor.

    Several columns have the motion, the times and the initial state in common. Each is weighted by the noise that its
    fourth differences show, as that of the first.
    """
    if not simulation.output_columns:
        return [(recording, experiment_of(recording, simulation))]
    noises = [noise_of(recording.columns[column]) for column in simulation.output_columns]
    found = []
    for number, column in enumerate(simulation.output_columns):
        columns = {**recording.columns, simulation.output_column: recording.columns[column]}
        part = replace(recording, columns=columns, source=f"{recording.source}, {column}", warnings=())
        if number == 0:
            part = replace(part, warnings=recording.warnings)
        weight = noises[0] / noises[number] if noises[0] > 0.0 and noises[number] > 0.0 else 1.0
        experiment = experiment_of(part, simulation)
        found.append((part, replace(experiment, output=weight * experiment.output, seen=number, weight=weight)))
    return found


def validation_rows(recording: Recording, simulation: Simulation) -> NDArray[np.bool_]:
    """Rows that the simulation keeps for validation, shape (N,)."""
    if simulation.validation is None:
        return np.zeros(len(recording), bool)
    start, end = simulation.validation
    return (recording.time >= start) & (recording.time <= end)


def experiments_of(
    recording: RecordingSource | Sequence[RecordingSource],
    believed: Simulation,
    progress: Callable[[str], None] | None,
) -> tuple[list[Recording], list[Experiment], list[NDArray[np.bool_]]]:
    """Recordings, what is fitted of them, and their validation rows; a file may hold several of them."""
    sources = recording if isinstance(recording, list | tuple) else [recording]
    if not sources:
        raise InputError("no recording is given", hint="name at least one")
    files = [os.path.realpath(source) for source in sources if isinstance(source, str | os.PathLike)]
    if len(set(files)) < len(files):
        raise InputError("the same recording is named twice", where=str(sources[0]), hint="it would count twice")
    if progress:
        progress("reading the recording")
    runs = [r for source in sources for r in load_recordings(source, believed, output_needed=True)]
    _refuse_too_long(runs)
    recordings: list[Recording] = []
    experiments: list[Experiment] = []
    held_out = []
    for one in runs:
        first = len(recordings)
        for number, (part, experiment) in enumerate(readings_of(one, believed)):
            rows = validation_rows(one, believed)
            held_out.append(rows & experiment.used)
            run = None if number == 0 else first
            alone = experiment.estimate_initial_state and run is None
            used = experiment.used & ~rows
            experiments.append(replace(experiment, used=used, same_run_as=run, estimate_initial_state=alone))
            recordings.append(part)
            _refuse_constant(part, believed, several=len(runs) > 1)
    if believed.validation is not None and not any(rows.any() for rows in held_out):
        raise InputError(
            f"no row of the recording lies between {believed.validation[0]:g} s and {believed.validation[1]:g} s",
            where=f"{believed.source}, validation",
            hint=f"the recording lasts from {recordings[-1].time[0]:g} s to {recordings[-1].time[-1]:g} s",
        )
    if not any(e.used.any() for e in experiments):
        start, end = believed.validation or (0.0, 0.0)
        raise InputError(
            f"the validation rows, {start:g} s to {end:g} s, leave no row to fit",
            where=f"{believed.source}, validation",
            hint=f"the recording lasts from {recordings[-1].time[0]:g} s to {recordings[-1].time[-1]:g} s",
        )
    if believed.input_column is not None and not any(np.any(e.signal) for e in experiments):
        raise ZeroInput(believed.input_column, recordings[0].source)
    if differing := _different_units(believed, recordings):
        recordings[0] = replace(recordings[0], warnings=(*recordings[0].warnings, *differing))
    return recordings, with_unknown_constants(experiments, believed), held_out


def experiments_or_free_decay(
    recording: RecordingSource | Sequence[RecordingSource],
    believed: Simulation,
    progress: Callable[[str], None] | None,
) -> tuple[Simulation, list[Recording], list[Experiment], list[NDArray[np.bool_]]]:
    """What :func:`experiments_of` returns, after the simulation; an input of zeros alone makes it a free decay."""
    try:
        recordings, experiments, held_out = experiments_of(recording, believed, progress)
        return with_units_of_headers(believed, recordings), recordings, experiments, held_out
    except ZeroInput as zero:
        if believed.controller is not None:
            raise
        decay = replace(believed, input_column=None, initial_state="estimate", bias=None, bias_deviation=None)
        recordings, experiments, held_out = experiments_of(recording, decay, progress)
        said = f"{zero.where}: {zero.problem}: read as a free decay (input: null, initial_state: estimate)"
        first = replace(recordings[0], warnings=(*recordings[0].warnings, said))
        return with_units_of_headers(decay, recordings), [first, *recordings[1:]], experiments, held_out


def with_units_of_headers(simulation: Simulation, recordings: Sequence[Recording]) -> Simulation:
    """The simulation with the units that headers say, where it declares none and they agree.

    What is written of it reads the same files as before, and says what people read its numbers in.
    """
    reading = simulation.reading
    outputs = simulation.output_columns or (simulation.output_column,)
    for name, columns in (("input", (simulation.input_column,)), ("output", outputs)):
        said = {one.units.get(str(column)) for one in recordings for column in columns}
        if getattr(reading, name).unit is None and len(said) == 1 and None not in said:
            reading = replace(reading, **{name: replace(getattr(reading, name), unit=said.pop())})
    return replace(simulation, reading=reading)


def _different_units(simulation: Simulation, recordings: Sequence[Recording]) -> list[str]:
    """A sentence for each column whose headers say different units in different files."""
    sentences = []
    for column in dict.fromkeys(c for one in recordings for c in one.units):
        files = {one.units.get(column): one.source for one in reversed(recordings) if column in one.columns}
        if len(files) > 1:
            listed = ", ".join(f"{unit or 'no unit'} in {source}" for unit, source in reversed(files.items()))
            sentences.append(
                f"the headers of column '{column}' differ: {listed}; each file is read as its own says, none as SI: "
                f"declare the unit in {simulation.source} if that is not so"
            )
    return sentences


def warnings_of(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """What was done to the rows of recordings, one sentence each."""
    return tuple(sentence for one in recordings for sentence in one.warnings)


def _refuse_too_long(runs: Sequence[Recording]) -> None:
    """Refuse more rows than a fit takes in minutes, with the cut that helps."""
    rows = sum(len(run) for run in runs)
    if rows <= MOST_ROWS:
        return
    longest = max(runs, key=len)
    hint = "name fewer recordings"
    if len(longest) > MOST_ROWS:
        start, end = longest.time[0], longest.time[MOST_ROWS - 1]
        hint = f"cut it in the simulation, for instance recording: {{start: {start:.10g}, end: {end:.10g}}}"
    raise InputError(
        f"{rows:,} rows are too many to fit at once (at most {MOST_ROWS:,})", where=longest.source, hint=hint
    )


def _refuse_constant(recording: Recording, simulation: Simulation, *, several: bool) -> None:
    if np.ptp(recording.columns[simulation.output_column]) == 0.0:
        raise InputError(
            f"column '{simulation.output_column}' is constant",
            where=recording.source,
            hint="there is nothing to identify in it",
        )
    column = simulation.input_column
    still = column is not None and not np.any(recording.columns[column])
    if several and still and not simulation.estimates_initial_state:
        raise InputError(
            f"column '{column}' is zero throughout",
            where=recording.source,
            hint="for a free decay among others say initial_state: estimate",
        )
