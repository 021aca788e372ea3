"""Recordings: tables with times, read strictly, brought to SI units and onto a regular grid."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError
from camid.recording.files import read_tables
from camid.recording.numbers import RowNumbers, common_rows, numbers, runs
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
    recordings, empty = [], []
    for table in read_tables(source, [*wanted, *label_columns], reading):
        columns = list(dict.fromkeys([*wanted, *(c for c in optional if c in table.columns)]))
        rows = common_rows(table, [*columns, *label_columns])
        for label, part in runs(table, label_columns[0], rows) if label_columns else [(None, rows)]:
            name = table.name if label is None else f"{table.name}, {label_columns[0]} {label}"
            piece = _Piece(table, part, name, reading, holds or {}, conversions or {})
            found = piece.recording(time_column, columns)
            if found is None:
                empty.append(name)
                continue
            experiment = ", ".join(e for e in (table.experiment, label) if e is not None) or None
            recordings.append(replace(found, experiment=experiment))
    if not recordings:
        raise _nothing_between(reading, empty[0])
    if empty:
        said = f"{', '.join(empty)}: no row between start and end, left out"
        recordings[0] = replace(recordings[0], warnings=(*recordings[0].warnings, said))
    return recordings


def _nothing_between(reading: Reading, name: str) -> InputError:
    return InputError(
        f"no row lies between {_seconds(reading.start, 'the start')} and {_seconds(reading.end, 'the end')}",
        where=name,
        hint="correct start and end under recording in the simulation; they are seconds",
    )


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

    def recording(self, time_column: str, columns: Sequence[str]) -> Recording | None:
        """The recording; None if no row lies between start and end."""
        reading = self.reading
        if len(self.rows) < FEWEST_ROWS:
            raise self._few(len(self.rows))
        if reading.period is None:
            time = reading.time(numbers(self.table, time_column, self.rows, self.name))
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

        values = {c: self._values(c, rows) for c in columns if c != time_column or reading.period is not None}
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
            warnings=tuple(self._warnings(grid, missing, values, bool(driven))),
        )

    def _values(self, column: str, rows: RowNumbers) -> Array:
        optional = self.reading.missing == "leave-out" and column not in self.holds
        cells = numbers(self.table, column, rows, self.name, empty_allowed=optional)
        return self.conversions.get(column, Conversion())(cells)

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
        if not grid.regular:
            count = 0 if grid.gaps is None else round(float(np.sum(np.diff(grid.recorded)[grid.gaps])) / grid.period)
            lost = count - (0 if grid.gaps is None else int(grid.gaps.sum()))
            said.append(
                f"{100 * grid.off_grid:.3g} % of the rows are off the regular grid of {grid.period:.6g} s, by at most "
                f"{100 * grid.deviation:.3g} % of the period"
                + (f", and {lost} rows are missing" if lost > 0 else "")
                + "; the output is interpolated to the grid (cubic)"
                + (", the input brought there by its hold" if driven else "")
                + (" and held over the gaps" if driven and grid.gaps is not None else "")
            )
        empty = max((int(np.isnan(v).sum()) for v in values.values()), default=0)
        if empty:
            said.append(f"{empty} rows ({100 * empty / len(grid.recorded):.3g} %) have no output")
        if missing.any():
            share = 100 * float(np.mean(missing))
            said.append(
                f"{int(missing.sum())} rows of the grid ({share:.3g} %) have no output near and are not compared"
            )
        if grid.period > LONG_PERIOD and self.reading.period is None and self.reading.time.unit is None:
            said.append(f"the period is {grid.period:g} s: if the times are milliseconds, say unit: ms under time")
        return [f"{self.name}: {sentence}" for sentence in said]
