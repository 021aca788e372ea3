"""Cells of a table as numbers, and as seconds where they are dates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

# Cells that hold nothing, as they look in a message.
EMPTY = {"", "nan", "<na>", "none", "nat"}


def as_floats(cells: pd.Series) -> Array:
    """Numbers, and NaN for everything else: truth values and dates are not numbers."""
    import pandas as pd
    from pandas.api import types

    if types.is_object_dtype(cells) or types.is_string_dtype(cells):
        cells = pd.to_numeric(cells.mask(cells.map(lambda cell: isinstance(cell, bool))), errors="coerce")
    if not types.is_numeric_dtype(cells) or types.is_bool_dtype(cells) or types.is_complex_dtype(cells):
        return np.full(len(cells), np.nan)
    return cells.to_numpy(dtype=float, na_value=np.nan)


def as_dates(cells: pd.Series) -> pd.Series | None:
    """Times that all cells hold as dates of ISO 8601 or of pandas, in nanoseconds; None if they hold anything else.

    Other orders of day and month are not guessed. A time of day without a date counts from midnight.
    """
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


def seconds_after(dates: pd.Series, first: int) -> Array:
    """Seconds of dates after the one at row ``first``, shape (len(dates),)."""
    return np.asarray((dates - dates.iloc[first]).astype("int64"), dtype=np.float64) * 1e-9
