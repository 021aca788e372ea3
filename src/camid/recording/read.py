"""Recordings, read strictly from tables with times, one for each experiment."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from camid.errors import InputError
from camid.recording.experiment_rows import ExperimentRows
from camid.recording.files import read_tables
from camid.recording.numbers import common_rows, runs
from camid.recording.options import Reading
from camid.recording.recording import Recording
from camid.recording.table import Table
from camid.recording.units import Conversion

if TYPE_CHECKING:
    import pandas as pd


def read_recording(
    source: str | os.PathLike[str] | pd.DataFrame,
    time_column: str,
    required: Sequence[str],
    optional: Sequence[str] = (),
    reading: Reading | None = None,
    holds: Mapping[str, str] | None = None,
) -> Recording:
    """Read the only experiment of a file; see :func:`read_recordings`.

    Raises
    ------
    InputError
        As there, and if the file holds several experiments.
    """
    found = read_recordings(source, time_column, required, optional, reading, holds)
    if len(found) > 1:
        raise InputError(f"{len(found)} experiments", where=str(source), hint="read_recordings returns them all")
    return found[0]


def read_recordings(
    source: str | os.PathLike[str] | pd.DataFrame,
    time_column: str,
    required: Sequence[str],
    optional: Sequence[str] = (),
    reading: Reading | None = None,
    holds: Mapping[str, str] | None = None,
    conversions: Mapping[str, Conversion] | None = None,
) -> list[Recording]:
    """Read and check the columns of a file, one recording per experiment.

    Parameters
    ----------
    source : path or DataFrame
        CSV or other text, Parquet, MAT or HDF5 file, or a table.
    time_column : str
        Not looked for where ``reading`` gives the period.
    required : sequence of str
        Columns that must be there.
    optional : sequence of str
        Columns that are taken where they are there.
    reading : Reading, optional
        What is known of the file.
    holds : mapping of str to {"zoh", "foh"}, optional
        Columns that are inputs, with their hold; the others are outputs.
    conversions : mapping of str to Conversion, optional
        Units of the columns, SI where they are not in it.

    Raises
    ------
    InputError
        No such file or column, text or NaN in a cell, times that are unsorted, duplicated or too irregular, rows
        missing from an input, too few rows.
    """
    reading = reading or Reading()
    timed = [] if reading.period is not None else [time_column]
    label_columns = [] if reading.experiment is None else [reading.experiment]
    frames = [] if reading.frame_time is None else [reading.frame_time]
    wanted = list(dict.fromkeys([*timed, *frames, *required]))
    holds = holds or {}
    recordings, empty = [], []
    for table in _side_by_side(source, [*wanted, *label_columns], reading):
        columns = list(dict.fromkeys([*wanted, *(c for c in optional if table.find(c) is not None)]))
        roles = {c: "time" if c in (*timed, *frames) else "input" if c in holds else "output" for c in columns}
        rows = common_rows(table, roles | dict.fromkeys(label_columns, "label"))
        said: tuple[str, ...] | None = table.notes
        for label, part in runs(table, label_columns[0], rows) if label_columns else [(None, rows)]:
            name = table.name if label is None else f"{table.name}, {label_columns[0]} {label}"
            piece = ExperimentRows(table, part, name, reading, holds, conversions or {}, time_column)
            found = piece.recording(columns, said)
            if found is None:
                empty.append(name)
                continue
            experiment = ", ".join(e for e in (table.experiment, label) if e is not None) or None
            recordings.append(replace(found, experiment=experiment, units=piece.units(columns)))
            said = None
    if not recordings:
        raise _nothing_between(reading, empty[0])
    if empty:
        left_out = f"{', '.join(empty)}: no row between start and end, left out"
        recordings[0] = replace(recordings[0], warnings=(*recordings[0].warnings, left_out))
    return recordings


def _side_by_side(
    source: str | os.PathLike[str] | pd.DataFrame, wanted: Sequence[str], reading: Reading
) -> Iterator[Table]:
    """Tables of a file; of runs side by side in a table, one for each run."""
    if not reading.runs:
        yield from read_tables(source, wanted, reading)
        return
    first = reading.runs[0]
    for table in read_tables(source, [first.get(c, c) for c in wanted], reading):
        for run in reading.runs:
            label = ", ".join(run.values())
            experiment = ", ".join(e for e in (table.experiment, label) if e is not None)
            yield replace(table.renamed(run), name=f"{table.name}, run {label}", experiment=experiment)


def _nothing_between(reading: Reading, name: str) -> InputError:
    return InputError(
        f"no row lies between {_seconds(reading.start, 'the start')} and {_seconds(reading.end, 'the end')}",
        where=name,
        hint="correct start and end under recording in the simulation; they are seconds",
    )


def _seconds(value: float | None, word: str) -> str:
    return word if value is None else f"{value:g} s"
