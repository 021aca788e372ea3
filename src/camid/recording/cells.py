"""Cells of a table as numbers, and as seconds where they are dates.

Cells are an array of floats, or a pandas Series where a file holds anything else: importing pandas takes longer than
reading a recording of numbers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias, Union

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]
Cells: TypeAlias = Union[Array, "pd.Series[Any]"]

# Cells that hold nothing, as they look in a message.
EMPTY = {"", "nan", "<na>", "none", "nat"}


def as_cells(column: Any) -> Cells:
    """Cells of a column, shape (n,): an array of floats where it holds real numbers alone, else a Series."""
    if isinstance(column, np.ndarray) and column.dtype.kind in "fiu":
        return column.astype(np.float64, copy=False)
    return series(column)


def series(column: Any) -> pd.Series[Any]:
    """A column as a Series whose rows are counted from zero."""
    import pandas as pd

    return pd.Series(column).reset_index(drop=True)


def some(cells: Cells, rows: NDArray[np.intp]) -> Cells:
    """Cells of some rows."""
    return cells[rows] if isinstance(cells, np.ndarray) else cells.iloc[rows]


def as_floats(cells: Cells) -> Array:
    """Numbers, and NaN for everything else: truth values and dates are not numbers."""
    if isinstance(cells, np.ndarray):
        return cells
    import pandas as pd
    from pandas.api import types

    if types.is_object_dtype(cells) or types.is_string_dtype(cells):
        cells = pd.to_numeric(cells.mask(cells.map(lambda cell: isinstance(cell, bool))), errors="coerce")
    if not types.is_numeric_dtype(cells) or types.is_bool_dtype(cells) or types.is_complex_dtype(cells):
        return np.full(len(cells), np.nan)
    return cells.to_numpy(dtype=float, na_value=np.nan)


def as_dates(cells: Cells) -> pd.Series[Any] | None:
    """Times that all cells hold as dates of ISO 8601 or of pandas, in nanoseconds; None if they hold anything else.

    Other orders of day and month are not guessed. A time of day without a date counts from midnight.
    """
    if isinstance(cells, np.ndarray):
        return None
    import pandas as pd
    from pandas.api import types

    if types.is_numeric_dtype(cells) or cells.empty:
        return None
    if types.is_timedelta64_dtype(cells):
        return cells.astype("timedelta64[ns]")
    try:
        dates = pd.to_datetime(cells, format="ISO8601", utc=True)
        return None if dates.isna().any() else dates.astype("datetime64[ns, UTC]")
    except (ValueError, TypeError, OverflowError):
        pass
    text = cells.astype(str).str.strip()
    if not text.str.fullmatch(r"\d{1,2}:\d{2}:\d{2}([.]\d+)?").all():
        return None
    return pd.to_timedelta(text).astype("timedelta64[ns]")


def seconds_after(dates: pd.Series[Any], first: int) -> Array:
    """Seconds of dates after the one at row ``first``, shape (len(dates),)."""
    return np.asarray((dates - dates.iloc[first]).astype("int64"), dtype=np.float64) / 1e9
