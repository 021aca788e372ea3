"""The rows of one experiment, brought to SI units and onto a regular grid."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError
from camid.recording.numbers import RowNumbers, numbers, numbers_or_nan, times, with_unit_of_header
from camid.recording.options import Reading
from camid.recording.recording import Recording
from camid.recording.table import Table
from camid.recording.time_grid import Grid, check_order, grid_of
from camid.recording.two_rates import frames_in_log, input_logs
from camid.recording.units import Conversion

Array = NDArray[np.float64]

FEWEST_ROWS = 3
# A diagnosis adds up squares of squares; those of larger and of smaller numbers leave the range of double precision.
LARGEST, SMALLEST = 1e70, 1e-70
# Seconds: what a clock of light in a millimetre ticks, and thirty years.
SHORTEST_PERIOD, LONGEST_PERIOD = 1e-12, 1e9
# A longer period, in seconds, is as likely one in milliseconds.
LONG_PERIOD = 10.0


def _rows(count: int) -> str:
    return f"{count} row{'' if count == 1 else 's'}"


def _time(seconds: float) -> str:
    """A short time with the unit that leaves one to three digits before the point."""
    for unit, factor in (("s", 1.0), ("ms", 1e3), ("µs", 1e6)):
        if factor * seconds >= 1.0:
            return f"{factor * seconds:.6g} {unit}" if factor * seconds >= 1000.0 else f"{factor * seconds:.4g} {unit}"
    return f"{1e9 * seconds:.3g} ns"


@dataclass(frozen=True)
class ExperimentRows:
    """Rows of a table that are one experiment.

    Attributes
    ----------
    table : Table
    rows : ndarray of int
    name : str
        For messages.
    reading : Reading
    holds : mapping of str to {"zoh", "foh", "band-limited"}
        Columns that are inputs, with their hold.
    conversions : mapping of str to Conversion
        Units of the columns, SI where they are not in it.
    time_column : str
    """

    table: Table
    rows: RowNumbers
    name: str
    reading: Reading
    holds: Mapping[str, str]
    conversions: Mapping[str, Conversion]
    time_column: str

    def recording(self, columns: Sequence[str], said: Sequence[str] | None) -> Recording | None:
        """The recording; None if no row lies between start and end.

        Parameters
        ----------
        columns : sequence of str
        said : sequence of str or None
            What was said of the file before; None: what the headers say of units has been said.

        Raises
        ------
        InputError
            See :func:`camid.recording.read.read_recordings`.
        """
        reading, time_column = self.reading, self.time_column
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

        if reading.frame_time is not None:
            return self._at_frames(time, rows, columns, where, [] if said is None else [*said, *notes])
        values = {}
        for column in (c for c in columns if c != time_column or reading.period is not None):
            values[column], unit_said = self._values(column, rows)
            notes += unit_said
        check_order(time, where)
        grid = self._grid(time, where)
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

    def _at_frames(
        self, time: Array, rows: RowNumbers, columns: Sequence[str], where: Callable[[int], str], notes: list[str]
    ) -> Recording:
        """The recording with a row for each frame, delivered at its own time, and the inputs as they were logged."""
        reading, frame_column = self.reading, str(self.reading.frame_time)
        check_order(time, where)
        conversion, said = with_unit_of_header(self.table, frame_column, reading.time, dimension="[time]")
        cells = numbers(self.table, frame_column, rows, self.name, empty_allowed=True)
        frames = frames_in_log(conversion(cells), time, self.name, frame_column)
        notes = [*notes, *self._undated(rows[~np.isfinite(cells)], columns)]

        def frame(row: int) -> str:
            return f"{self.name}, {self.table.where(int(rows[frames.rows[row]]))}, column '{frame_column}'"

        if len(frames.rows) < FEWEST_ROWS:
            raise self._few(len(frames.rows), "frames")
        check_order(frames.time, frame)
        grid = grid_of(frames.time, frame)
        held, seen, notes = {}, {}, [*notes, *said, *frames.notes]
        for column in columns:
            if column in self.holds:
                held[column], unit_said = self._values(column, rows)
            elif column not in (frame_column, self.time_column):
                seen[column], unit_said = self._values(column, rows[frames.rows])
            else:
                continue
            notes += unit_said
        holds = {column: self.holds[column] for column in held}
        logs = input_logs(time, held, holds, gaps=reading.gaps, where=where)
        on_grid = {name: log.samples(grid.time, grid.period) for name, log in logs.items()}
        missing = np.zeros(len(grid.time), bool)
        for column, values in seen.items():
            on_grid[column], unknown = grid.interpolated(values)
            missing |= unknown
        notes += self._warnings(grid, missing, seen, False)
        warnings = tuple(f"{self.name}: {sentence}" for sentence in notes)
        return Recording(
            grid.time,
            {column: on_grid[column] for column in columns if column in on_grid},
            grid.period,
            self.name,
            grid.uncertainty,
            missing,
            frames.time,
            seen,
            warnings=warnings,
            logs=logs,
        )

    def _undated(self, rows: RowNumbers, columns: Sequence[str]) -> list[str]:
        """A sentence on rows without the time of a frame that nevertheless have an output."""
        own = {*self.holds, self.time_column, self.reading.frame_time}
        seen = [numbers_or_nan(self.table, column, rows) for column in columns if column not in own]
        lost = int(np.any(np.isfinite(seen), axis=0).sum()) if seen and len(rows) else 0
        if not lost:
            return []
        frames = "1 frame has" if lost == 1 else f"{lost} frames have"
        return [f"{frames} an output and no time in column '{self.reading.frame_time}', and are left out"]

    def _grid(self, time: Array, where: Callable[[int], str]) -> Grid:
        """The regular grid of the times, whose period is one that a recording may have."""
        period = self.reading.period
        grid = grid_of(time, where) if period is None else Grid(time, time, period)
        if not SHORTEST_PERIOD <= grid.period <= LONGEST_PERIOD:
            hint = "say the unit of the times: unit: under time"
            raise InputError(f"the period is {grid.period:g} s", where=self.name, hint=hint)
        return grid

    def units(self, columns: Sequence[str]) -> dict[str, str]:
        """What the cells of columns are in, where the simulation or the header says so."""
        found = {c: with_unit_of_header(self.table, c, self.conversions.get(c, Conversion()))[0].unit for c in columns}
        return {column: unit for column, unit in found.items() if unit is not None}

    def _values(self, column: str, rows: RowNumbers) -> tuple[Array, list[str]]:
        optional = self.reading.missing == "leave-out" and column not in self.holds
        cells = numbers(self.table, column, rows, self.name, empty_allowed=optional)
        conversion, said = with_unit_of_header(self.table, column, self.conversions.get(column, Conversion()))
        values = conversion(cells)
        self._refuse_scale(values, column, rows)
        return values, said

    def _refuse_scale(self, values: Array, column: str, rows: RowNumbers) -> None:
        """Refuse numbers whose powers are infinite or zero in double precision: no unit in use makes such."""
        size = np.abs(np.nan_to_num(values))
        largest = int(np.argmax(size))
        hint = f"choose another unit, or say scale: for column '{column}' in the simulation"
        if size[largest] > LARGEST:
            where = f"{self.name}, {self.table.where(int(rows[largest]))}, column '{column}'"
            cell = self.table.quoted(int(rows[largest]), column) or f"{values[largest]:g}"
            raise InputError(f"{cell} is too large to be squared", where=where, hint=hint)
        if 0.0 < size[largest] < SMALLEST:
            where = f"{self.name}, column '{column}'"
            raise InputError(f"all numbers are below {SMALLEST:g}, too small to be squared", where=where, hint=hint)

    def _few(self, count: int, what: str = "rows") -> InputError:
        return InputError(f"{count} {what}", where=self.name, hint=f"a recording needs at least {FEWEST_ROWS}")

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
        empty = max((int(np.isnan(v).sum()) for v in values.values()), default=0)
        absent = int(missing.sum())
        held = ", the input held over them" if driven and grid.gaps is not None else ""
        if not grid.regular and lost and grid.off_by_rounding:
            share = f"{100 * lost / len(grid.time):.3g} %"
            alone = absent == lost and not empty
            verb, compared = "is" if lost == 1 else "are", ", not compared" if alone else ""
            said.append(f"{_rows(lost)} {verb} missing ({share} of the grid){held}{compared}")
            absent = 0 if alone else absent
        elif not grid.regular and (lost or not all(grid.negligible_for(v) for v in values.values())):
            said.append(
                f"the times are off a regular grid of {_time(grid.period)} by {_time(grid.scatter)} RMS and at "
                f"most {_time(grid.deviation * grid.period)} ({100 * grid.deviation:.2g} % of the period)"
                + (f", and {lost} rows are missing" if lost > 0 else "")
                + "; the output is interpolated to the grid (cubic)"
                + (", the input brought there by its hold" if driven else "")
                + (" and held over the gaps" if driven and grid.gaps is not None else "")
            )
        if empty:
            alone = grid.regular and absent == empty  # the grid is that of the rows, and nothing else is missing in it
            compared = ", not compared" if alone else ""
            said.append(f"{_rows(empty)} ({100 * empty / len(grid.recorded):.3g} %) without output{compared}")
            absent = 0 if alone else absent
        if absent:
            share = f"{100 * absent / len(missing):.3g} %"
            said.append(f"{_rows(absent)} of the grid ({share}) without output near, not compared")
        if grid.period > LONG_PERIOD and self.reading.period is None and self.reading.time.unit is None:
            said.append(f"the period is {grid.period:g} s: if the times are milliseconds, say unit: ms under time")
        return said
