"""Tables of numbers on a clock of their own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camid.draft.layout import layout_of
from camid.draft.roles import time_of
from camid.errors import InputError, nearest_match

Array = NDArray[np.float64]

FEWEST_ROWS = 40


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


def timed_table(path: Path, time_column: str | None) -> TimedTable:
    """The numbers in a file.

    Parameters
    ----------
    path : Path
    time_column : str, optional
        Guessed by name and values where it is not given.

    Raises
    ------
    InputError
        If the file cannot be read, or has no time that grows.
    """
    layout = layout_of(path)
    if layout.experiments:
        raise InputError(
            f"this file holds {len(layout.experiments)} experiments", where=str(path), hint="join one at a time"
        )
    name = time_column if time_column is not None else time_of(layout)
    if name is None or name not in layout.columns:
        said = "no column looks like the time" if time_column is None else f"no column '{time_column}'"
        raise InputError(said, where=str(path), hint=f"name it; there are {', '.join(layout.columns)}")
    time = layout.columns[name]
    if len(time) < FEWEST_ROWS:
        raise InputError(f"{len(time)} rows", where=str(path), hint=f"at least {FEWEST_ROWS} are needed")
    if not np.all(np.isfinite(time)) or np.any(np.diff(time) <= 0.0):
        row = int(np.argmax(~np.isfinite(time) | np.append(False, np.diff(time) <= 0.0)))
        raise InputError(
            f"the time column '{name}' does not grow", where=f"{path}, row {row + 2}", hint="sort the rows by time"
        )
    columns = {n: values for n, values in layout.columns.items() if n != name and len(values) == len(time)}
    if not columns:
        raise InputError("there is no column beside the time", where=str(path), hint="a table needs one at least")
    return TimedTable(str(path), time, name, columns)
