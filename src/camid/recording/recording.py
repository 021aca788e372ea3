"""Recordings: tables with times, read strictly, brought to SI units and onto a regular grid."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError
from camid.recording.files import read_tables
from camid.recording.numbers import RowNumbers, common_rows, numbers, runs, times, with_unit_of_header
from camid.recording.options import Reading
from camid.recording.table import Table
from camid.recording.time_grid import Grid, check_order, grid_of
from camid.recording.units import Conversion

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

FEWEST_ROWS = 3
# A longer period, in seconds, is as likely one in milliseconds.
LONG_PERIOD = 10.0


@dataclass(frozen=True)
class Recording:
    """A recording on a regular grid, in SI units.

    Attributes
    ----------
    time : ndarray, shape (N,)
        Seconds, strictly increasing: the recorded times where they are regular, else the grid.
    columns : dict of str to ndarray, each of shape (N,)
        The columns that were asked for. Outputs are interpolated where the times were irregular.
    period : float
        Seconds: the median step, or the slope of the times where rounding or jitter makes the steps differ.
    source : str
        Name for messages.
    period_uncertainty : float
        Seconds by which rounded or irregular times may have falsified the period; 0 where the steps are equal.
    missing : ndarray of bool, shape (N,)
        RowNumbers without recorded output near, which are not compared.
    recorded_time : ndarray, shape (M,)
        Seconds: the times in the file.
    recorded_columns : dict of str to ndarray, each of shape (M,)
        The rows of the file.
    experiment : str or None
        What tells this recording from the others in its file.
    warnings : tuple of str
        What was done to the rows, one sentence each.
    """

    time: Array
    columns: dict[str, Array]
    period: float
    source: str
    period_uncertainty: float = 0.0
    missing: NDArray[np.bool_] = field(default=None)  # type: ignore[arg-type]
    recorded_time: Array = field(default=None)  # type: ignore[arg-type]
    recorded_columns: dict[str, Array] = field(default=None)  # type: ignore[arg-type]
    experiment: str | None = None
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name, value in (
            ("missing", np.zeros(len(self.time), bool)),
            ("recorded_time", self.time),
            ("recorded_columns", self.columns),
        ):
            if getattr(self, name) is None:
                object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.time)


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
    wanted = list(dict.fromkeys([*timed, *required]))
    holds = holds or {}
    recordings, empty = [], []
    for table in _side_by_side(source, [*wanted, *label_columns], reading):
        columns = list(dict.fromkeys([*wanted, *(c for c in optional if table.find(c) is not None)]))
        roles = {c: "time" if c in timed else "input" if c in holds else "output" for c in columns}
        rows = common_rows(table, roles | dict.fromkeys(label_columns, "label"))
        said: tuple[str, ...] | None = table.notes
        for label, part in runs(table, label_columns[0], rows) if label_columns else [(None, rows)]:
            name = table.name if label is None else f"{table.name}, {label_columns[0]} {label}"
            piece = _Piece(table, part, name, reading, holds, conversions or {})
            found = piece.recording(time_column, columns, said)
            if found is None:
                empty.append(name)
                continue
            experiment = ", ".join(e for e in (table.experiment, label) if e is not None) or None
            recordings.append(replace(found, experiment=experiment))
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


def _rows(count: int) -> str:
    return f"{count} row{'' if count == 1 else 's'}"


def _time(seconds: float) -> str:
    """A short time with the unit that leaves one to three digits before the point."""
    for unit, factor in (("s", 1.0), ("ms", 1e3), ("µs", 1e6)):
        if factor * seconds >= 1.0:
            return f"{factor * seconds:.6g} {unit}" if factor * seconds >= 1000.0 else f"{factor * seconds:.4g} {unit}"
    return f"{1e9 * seconds:.3g} ns"


def _seconds(value: float | None, word: str) -> str:
    return word if value is None else f"{value:g} s"


@dataclass(frozen=True)
class _Piece:
    """RowNumbers of a table that are one experiment."""

    table: Table
    rows: RowNumbers
    name: str
    reading: Reading
    holds: Mapping[str, str]
    conversions: Mapping[str, Conversion]

    def recording(self, time_column: str, columns: Sequence[str], said: Sequence[str] | None) -> Recording | None:
        """The recording; None if no row lies between start and end.

        ``said`` is what was said of the file before; None: what the headers say of units has been said.
        """
        reading = self.reading
        if len(self.rows) < FEWEST_ROWS:
            raise self._few(len(self.rows))
        notes: list[str] = []
        if reading.period is None:
            time, notes = times(self.table, time_column, self.rows, self.name, reading.time)
        else:
            time = np.arange(len(self.rows), dtype=np.float64) * np.float64(reading.period)
        kept = np.flatnonzero(
            (time >= (-np.inf if reading.start is None else reading.start))
            & (time <= (np.inf if reading.end is None else reading.end))
        )
        if kept.size == 0:
            return None
        if kept.size < FEWEST_ROWS:
            raise self._few(kept.size)
        time, rows = time[kept], self.rows[kept]

        def where(row: int) -> str:
            return f"{self.name}, {self.table.where(int(rows[row]))}, column '{time_column}'"

        values = {}
        for column in (c for c in columns if c != time_column or reading.period is not None):
            values[column], unit_said = self._values(column, rows)
            notes += unit_said
        check_order(time, where)
        grid = grid_of(time, where) if reading.period is None else Grid(time, time, reading.period)
        driven = [c for c in values if c in self.holds]
        if grid.gaps is not None and driven and reading.gaps != "hold":
            raise self._gap(grid, where)
        on_grid = {c: grid.held(values[c], self.holds[c]) for c in driven}
        missing = np.zeros(len(grid.time), bool)
        for column in (c for c in values if c not in self.holds):
            on_grid[column], unknown = grid.interpolated(values[column])
            missing |= unknown
        if missing.all():
            raise InputError("no row of the grid has an output near", where=self.name, hint="record more densely")
        return Recording(
            grid.time,
            {c: on_grid[c] for c in values},
            grid.period,
            self.name,
            grid.uncertainty,
            missing,
            time,
            values,
            warnings=tuple(
                f"{self.name}: {sentence}"
                for sentence in (
                    *([] if said is None else [*said, *notes]),
                    *self._warnings(grid, missing, values, bool(driven)),
                )
            ),
        )

    def _values(self, column: str, rows: RowNumbers) -> tuple[Array, list[str]]:
        optional = self.reading.missing == "leave-out" and column not in self.holds
        cells = numbers(self.table, column, rows, self.name, empty_allowed=optional)
        conversion, said = with_unit_of_header(self.table, column, self.conversions.get(column, Conversion()))
        return conversion(cells), said

    def _few(self, count: int) -> InputError:
        return InputError(f"{count} rows", where=self.name, hint=f"a recording needs at least {FEWEST_ROWS}")

    def _gap(self, grid: Grid, where: Callable[[int], str]) -> InputError:
        """What to say about the largest gap."""
        steps = np.diff(grid.recorded) * np.asarray(grid.gaps)
        row = int(np.argmax(steps)) + 1
        lost = max(round(steps[row - 1] / grid.period) - 1, 1)
        return InputError(
            f"a step of {steps[row - 1]:.6g} s where the others have {grid.period:.6g} s: "
            f"{'a row seems' if lost == 1 else f'{lost} rows seem'} to be missing, and what the input did is unknown",
            where=where(row),
            hint="cut the recording there, or say gaps: hold under recording if the input was held",
        )

    def _warnings(self, grid: Grid, missing: NDArray[np.bool_], values: dict[str, Array], driven: bool) -> list[str]:
        """What was done to the rows."""
        said = []
        lost = grid.rows_missing()
        if not grid.regular and (lost or not all(grid.negligible_for(v) for v in values.values())):
            said.append(
                f"the times are off a regular grid of {_time(grid.period)} by {_time(grid.scatter)} RMS and at "
                f"most {_time(grid.deviation * grid.period)} ({100 * grid.deviation:.2g} % of the period)"
                + (f", and {lost} rows are missing" if lost > 0 else "")
                + "; the output is interpolated to the grid (cubic)"
                + (", the input brought there by its hold" if driven else "")
                + (" and held over the gaps" if driven and grid.gaps is not None else "")
            )
        empty = max((int(np.isnan(v).sum()) for v in values.values()), default=0)
        if empty:
            said.append(f"{_rows(empty)} ({100 * empty / len(grid.recorded):.3g} %) without output")
        if missing.any():
            share = 100 * float(np.mean(missing))
            said.append(f"{_rows(int(missing.sum()))} of the grid ({share:.3g} %) without output near, not compared")
        if grid.period > LONG_PERIOD and self.reading.period is None and self.reading.time.unit is None:
            said.append(f"the period is {grid.period:g} s: if the times are milliseconds, say unit: ms under time")
        return said
