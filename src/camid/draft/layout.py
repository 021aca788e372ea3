"""Layout of a file that nobody has described: which of its groups are recordings, and the numbers in its columns."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.errors import InputError
from camid.recording.cells import as_dates, as_floats, seconds_after
from camid.recording.files import possible_readings
from camid.recording.options import Reading
from camid.recording.table import Table

Array = NDArray[np.float64]

FEWEST_ROWS = 20
# Share of a step by which the time of a frame may lie outside of its row, as rounding makes it.
IN_A_ROW = 0.01
# Share of its rows by which a column may go on after the others.
LONGER = 0.05


@dataclass(frozen=True)
class Layout:
    """Columns of a file that may belong to a recording.

    Attributes
    ----------
    reading : Reading
        How the file is read: header, names of columns, group.
    columns : dict of str to ndarray
        Numbers of the first experiment; NaN where there are none; dates as seconds.
    dates : tuple of str
        Columns that hold dates.
    values : dict of str to float
        Single values beside them, which may be a period.
    experiments : tuple of str
        Names of the experiments in the file; empty if it holds one.
    frame_time : str or None
        Column with the times of frames between the samples of another clock, blank in rows without a frame.
    seen : tuple of str
        Columns that are blank in those rows, too.
    left_out : dict of str to str
        Columns that belong to no recording, and why.
    """

    reading: Reading
    columns: dict[str, Array]
    dates: tuple[str, ...] = ()
    values: dict[str, float] = field(default_factory=dict)
    experiments: tuple[str, ...] = ()
    frame_time: str | None = None
    seen: tuple[str, ...] = ()
    left_out: dict[str, str] = field(default_factory=dict)


def layout_of(path: Path) -> Layout:
    """Look at a file; of its groups the first with at least two columns of one length is taken.

    Raises
    ------
    InputError
        If it cannot be read, or holds no columns of numbers of at least twenty rows.
    """
    found = [_layout(reading, tables) for reading, tables in possible_readings(path)]
    best = next((f for f in found if len(f.columns) > 1), next((f for f in found if f.columns), None))
    if best is None:
        raise InputError(
            f"no column holds numbers in at least {FEWEST_ROWS} rows",
            where=str(path),
            hint="a recording is a table of numbers: a time, an input, an output",
        )
    return best


def _layout(reading: Reading, tables: list[Table]) -> Layout:
    first = tables[0]
    common = [n for n in first.columns if all(n in t.columns for t in tables)]
    columns: dict[str, Array] = {}
    dates: list[str] = []
    values: dict[str, float] = {}
    numeric: dict[str, Array] = {}
    left_out = {str(n): "not in every experiment" for n in first.columns if n not in common}
    for name in common:
        cells = pd.Series(first.columns[name]).reset_index(drop=True)
        numbers = as_floats(cells)
        known = np.flatnonzero(np.isfinite(numbers))
        if not known.size and (times := as_dates(cells)) is not None:
            numbers, known = seconds_after(times, 0), np.arange(len(cells))
            dates.append(str(name))
        if known.size >= FEWEST_ROWS and name not in dates:
            numeric[str(name)] = numbers
        if known.size >= FEWEST_ROWS and known.size >= 0.5 * (known[-1] + 1):
            columns[str(name)] = numbers[: known[-1] + 1]
        elif known.size == 1 and known[0] == 0:
            values[str(name)] = float(numbers[0])
        else:
            left_out[str(name)] = _why_none(len(cells) - int(cells.isna().sum()), known.size)
    frame_time, seen = _frames(numeric)
    columns |= {n: numeric[n] for n in (frame_time, *seen) if n is not None}
    values |= first.single
    lengths = Counter(len(c) for c in columns.values())
    # Columns of a recording have one length; runs side by side may have several, each more than once.
    usual = {n for n, count in lengths.items() if count > 1} or {max(lengths, default=0)}
    fitted = {n: _of_usual_length(c, usual) for n, c in columns.items()}
    left_out = {n: why for n, why in left_out.items() if n not in columns}
    left_out |= {n: f"numbers in {len(columns[n])} rows only" for n, c in fitted.items() if c is None}
    columns = {n: c for n, c in fitted.items() if c is not None}
    experiments = tuple(str(t.experiment) for t in tables) if len(tables) > 1 else ()
    held = tuple(d for d in dates if d in columns)
    return Layout(reading, columns, held, values, experiments, frame_time, seen, left_out)


def _why_none(filled: int, numbers: int) -> str:
    """Why a column belongs to no recording, from how many of its cells are not blank and how many are numbers."""
    if filled == 0:
        return "blank"
    return "text" if numbers == 0 else f"numbers in only {numbers} of its rows"


def _of_usual_length(values: Array, usual: set[int]) -> Array | None:
    """A column made as long as the others, whose last cells may be blank; None where it is much shorter or longer."""
    length = len(values)
    if length in usual:
        return values
    above = min((n for n in usual if n > length), default=None)
    if above is not None and np.isfinite(values).sum() >= 0.5 * above:
        return np.concatenate([values, np.full(above - length, np.nan)])
    below = max((n for n in usual if n < length), default=0)
    return values[:below] if length - below <= LONGER * below else None


def _frames(columns: dict[str, Array]) -> tuple[str | None, tuple[str, ...]]:
    """The column with the times of frames between the rows of a clock, and those that are blank with it."""
    for name, values in columns.items():
        known = np.isfinite(values)
        inside = known[: np.flatnonzero(known)[-1] + 1]  # a shorter run beside others ends in blanks
        if inside.all() or not np.all(np.diff(values[known]) > 0.0):
            continue
        clocks = [c for n, c in columns.items() if n != name and np.all(np.isfinite(c)) and np.all(np.diff(c) > 0.0)]
        blank = (n for n, c in columns.items() if n != name and not np.any(np.isfinite(c[~known])))
        seen = tuple(blank)
        if seen and any(_in_their_rows(values[known], np.flatnonzero(known), clock) for clock in clocks):
            return name, seen
    return None, ()


def _in_their_rows(times: Array, rows: NDArray[np.intp], clock: Array) -> bool:
    """Whether each time lies between that of its row and that of the next."""
    step = float(np.median(np.diff(clock)))
    later = times - clock[rows]
    return bool(np.all(later >= -IN_A_ROW * step) and np.all(later <= (1.0 + IN_A_ROW) * step) and np.any(later))
