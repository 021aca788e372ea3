"""Tables of numbers on a clock of their own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camid.draft.layout import Layout, layout_of
from camid.draft.roles import says, time_of
from camid.errors import InputError, nearest_match
from camid.recording.units import Conversion, is_unit, unit_in_header

Array = NDArray[np.float64]

FEWEST_ROWS = 40
# Steps of the drive above this many times the median are gaps.
LARGEST_STEP = 1.9


@dataclass(frozen=True)
class TimedTable:
    """Columns of numbers and their times.

    Attributes
    ----------
    source : str
    time : ndarray, shape (N,)
        Seconds, growing.
    time_column : str
    columns : dict of str to ndarray of shape (N,)
        The others.
    """

    source: str
    time: Array
    time_column: str
    columns: dict[str, Array]

    def column(self, name: str) -> Array:
        """A column by its name; InputError where there is none."""
        if name not in self.columns:
            raise InputError(f"no column '{name}'", where=self.source, hint=nearest_match(name, self.columns))
        return self.columns[name]


def timed_table(path: Path, time_column: str | None, *, whole: bool = False) -> TimedTable:
    """The numbers in a file.

    Parameters
    ----------
    path : Path
    time_column : str, optional
        Guessed by name and values where it is not given.
    whole : bool
        Whether rows and cells must not be missing: between two samples of a drive nothing says what it did.

    Raises
    ------
    InputError
        If the file cannot be read, has no time that grows, or has gaps and must not.
    """
    layout = layout_of(path)
    if layout.experiments:
        raise InputError(
            f"this file holds {len(layout.experiments)} experiments", where=str(path), hint="join one at a time"
        )
    name = time_column if time_column is not None else time_of(layout) or _named_time(layout)
    if name is None or name not in layout.columns:
        said = "no column looks like the time" if time_column is None else f"no column '{time_column}'"
        raise InputError(said, where=str(path), hint=f"name it; there are {', '.join(layout.columns)}")
    unit = unit_in_header(name)[1]
    factor = Conversion(unit=unit).factor if unit is not None and is_unit(unit, "[time]") else 1.0
    time = factor * layout.columns[name]
    if len(time) < FEWEST_ROWS:
        raise InputError(f"{len(time)} rows", where=str(path), hint=f"at least {FEWEST_ROWS} are needed")
    if not np.all(np.isfinite(time)) or np.any(np.diff(time) <= 0.0):
        row = int(np.argmax(~np.isfinite(time) | np.append(False, np.diff(time) <= 0.0)))
        raise InputError(
            f"the time column '{name}' does not grow", where=f"{path}, row {row + 2}", hint="sort the rows by time"
        )
    if whole:
        _refuse_gaps(path, time, layout)
    columns = {n: values for n, values in layout.columns.items() if n != name and len(values) == len(time)}
    if not columns:
        raise InputError("there is no column beside the time", where=str(path), hint="a table needs one at least")
    return TimedTable(str(path), time, name, columns)


def _named_time(layout: Layout) -> str | None:
    """A column that is called like a time, although it does not grow like one."""
    return next((name for name in layout.columns if says(name, "time")), None)


def _refuse_gaps(path: Path, time: Array, layout: Layout) -> None:
    """Refuse rows and cells that are missing."""
    steps = np.diff(time)
    far = int(np.argmax(steps))
    if steps[far] > LARGEST_STEP * float(np.median(steps)):
        raise InputError(
            f"{steps[far]:.4g} s are missing after t = {time[far]:.9g} s",
            where=f"{path}, row {far + 2}",
            hint="nothing says what the drive did then: cut the table there",
        )
    for name, values in layout.columns.items():
        blank = np.flatnonzero(~np.isfinite(values))
        if len(blank):
            raise InputError(
                f"{len(blank)} cells of '{name}' hold no number",
                where=f"{path}, row {blank[0] + 2}",
                hint="fill them, or leave the column out",
            )
