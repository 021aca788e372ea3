"""Numbers from the cells of a table, and the runs of equal values that tell its experiments apart."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError
from camid.recording.table import Table

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]
RowNumbers = NDArray[np.intp]

# Cells that hold nothing, as they look in a message.
EMPTY = {"", "nan", "<na>", "none", "nat"}


def numbers(table: Table, column: str, rows: RowNumbers, name: str, *, empty_allowed: bool = False) -> Array:
    """Numbers of some rows of a column, shape (len(rows),).

    Parameters
    ----------
    table : Table
    column : str
    rows : ndarray of int
    name : str
        For messages.
    empty_allowed : bool
        Whether empty cells become NaN instead of an error.

    Raises
    ------
    InputError
        With line and column of the first cell that holds no finite number.
    """
    cells = table.column(column).iloc[rows]
    values = _as_floats(cells)
    wrong = np.flatnonzero(~np.isfinite(values))
    if wrong.size == 0:
        return np.ascontiguousarray(values)
    empty = _is_empty(cells.iloc[wrong])
    if wrong.size == len(values) and empty.all():
        raise InputError(f"column '{column}' is empty", where=name, hint="fill it, or name another column")
    if empty_allowed and empty.all():
        return np.ascontiguousarray(values)
    bad = int(wrong[np.argmin(empty)] if empty_allowed else wrong[0])
    cell = str(cells.iloc[bad])
    raise InputError(
        f"{'an empty cell or NaN' if cell.strip().lower() in EMPTY else repr(cell)} where a number should be",
        where=f"{name}, {table.where(int(rows[bad]))}, column '{column}'",
        hint=_hint(cell, leave_out=not empty_allowed),
    )


def _hint(cell: str, *, leave_out: bool) -> str:
    if re.fullmatch(r"\s*[-+]?\d*,\d+([eE][-+]?\d+)?\s*", cell):
        return "write all numbers with a decimal point, or all with a comma and say decimal: ',' under recording"
    if re.fullmatch(r"\s*[-+]?\d{1,3}((,\d{3})+(\.\d*)?|(\.\d{3})+(,\d*)?)\s*", cell):
        return "write the number without marks between the thousands"
    if re.search(r"\d\s*[;\t,]\s*[-+\d]", cell):
        return "separate the cells as in the other lines"
    if cell.strip().lower() in EMPTY and leave_out:
        return "fill in the number, remove the row, or say missing: leave-out under recording for the output"
    return "fill in the number (with a decimal point) or remove the row"


def _is_empty(cells: pd.Series) -> NDArray[np.bool_]:
    return np.array([str(cell).strip().lower() in EMPTY for cell in cells], dtype=bool)


def _as_floats(values: pd.Series) -> Array:
    """Numbers, and NaN for everything else: truth values and dates are not numbers."""
    import pandas as pd
    from pandas.api import types

    if types.is_object_dtype(values) or types.is_string_dtype(values):
        values = pd.to_numeric(values.mask(values.map(lambda cell: isinstance(cell, bool))), errors="coerce")
    if not types.is_numeric_dtype(values) or types.is_bool_dtype(values) or types.is_complex_dtype(values):
        return np.full(len(values), np.nan)
    return values.to_numpy(dtype=float, na_value=np.nan)


def common_rows(table: Table, columns: list[str]) -> RowNumbers:
    """Numbers of the rows that the columns of a table have in common.

    Raises
    ------
    InputError
        If there is no such column, or they differ in their length.
    """
    lengths = {c: len(table.column(c)) for c in columns}
    first = columns[0]
    for column, length in lengths.items():
        if length != lengths[first]:
            raise InputError(
                f"'{column}' has {length} values, and '{first}' has {lengths[first]}",
                where=table.name,
                hint="name columns of one length",
            )
    return np.arange(lengths[first])


def runs(table: Table, column: str, rows: RowNumbers) -> list[tuple[str, RowNumbers]]:
    """Runs of equal values in a column: their names and their rows.

    Raises
    ------
    InputError
        If a cell is empty.
    """
    labels = table.column(column)
    empty = np.flatnonzero(labels.isna().to_numpy())
    if empty.size:
        raise InputError(
            "an empty cell or NaN",
            where=f"{table.name}, {table.where(int(empty[0]))}, column '{column}'",
            hint="name the experiment of each row",
        )
    codes = labels.factorize()[0]
    parts = np.split(rows, np.flatnonzero(np.diff(codes)) + 1)
    names = [f"{v:g}" if isinstance(v := labels.iloc[p[0]], float) else str(v) for p in parts if p.size]
    return [
        (n if names.count(n) == 1 else f"{n} from {table.where(int(p[0]))}", p)
        for n, p in zip(names, parts, strict=False)
    ]
