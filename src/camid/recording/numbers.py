"""Numbers from the cells of a table, and the runs of equal values that tell its experiments apart."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError
from camid.recording.cells import EMPTY, Cells, as_dates, as_floats, seconds_after, series, some
from camid.recording.table import Table
from camid.recording.units import Conversion, is_unit, si_factor, unit_in_header

Array = NDArray[np.float64]
RowNumbers = NDArray[np.intp]


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
    cells = some(table.column(column), rows)
    values = as_floats(cells)
    wrong = np.flatnonzero(~np.isfinite(values))
    if wrong.size == 0:
        return np.ascontiguousarray(values)
    empty = _is_empty(some(cells, wrong))
    if wrong.size == len(values) and empty.all():
        raise InputError(f"column '{column}' is empty", where=name, hint="fill it, or name another column")
    if empty_allowed and empty.all():
        return np.ascontiguousarray(values)
    bad = int(wrong[np.argmin(empty)] if empty_allowed else wrong[0])
    cell = str(series(cells)[bad])
    if cell.strip().lower() not in EMPTY:
        cell = table.quoted(int(rows[bad]), column) or cell
    raise InputError(
        f"{'an empty cell or NaN' if cell.strip().lower() in EMPTY else repr(cell)} where a number should be",
        where=f"{name}, {table.where(int(rows[bad]))}, column '{column}'",
        hint=_hint(cell, leave_out=not empty_allowed),
    )


def numbers_or_nan(table: Table, column: str, rows: RowNumbers) -> Array:
    """Numbers of some rows of a column, shape (len(rows),); NaN where a cell holds none."""
    return as_floats(some(table.column(column), rows))


def times(table: Table, column: str, rows: RowNumbers, name: str, conversion: Conversion) -> tuple[Array, list[str]]:
    """Seconds of some rows of the time column, shape (len(rows),), and what was taken from the file to tell them.

    Dates are counted from the first row of the table. A unit in the header counts unless another is declared.

    Raises
    ------
    InputError
        With line and column of the first cell that holds neither a number nor a date of ISO 8601.
    """
    cells = table.column(column)
    dates = as_dates(some(cells, rows)) if np.isnan(as_floats(some(cells, rows[:1]))).all() else None
    if dates is None:
        conversion, notes = with_unit_of_header(table, column, conversion, dimension="[time]")
        return conversion(numbers(table, column, rows, name)), notes
    if conversion.unit is not None:
        raise InputError(
            f"column '{column}' holds dates, and a unit is declared",
            where=f"{conversion.where}.unit",
            hint="remove the unit: dates become seconds",
        )
    whole = as_dates(cells)
    if whole is not None:
        dates, first = whole.iloc[rows], seconds_after(whole, 0)[rows]
    else:  # rows that are not read may hold anything
        first = seconds_after(dates, 0)
    start = series(cells)[int(rows[0]) if whole is None else 0]
    return first, [f"column '{column}' holds dates: its times are seconds after {start}"]


def with_unit_of_header(
    table: Table, column: str, conversion: Conversion, *, dimension: str | None = None
) -> tuple[Conversion, list[str]]:
    """The conversion of a column with the unit in its header where none is declared, and a sentence that says so."""
    header = table.find(column)
    unit = None if header is None else unit_in_header(header)[1]
    if unit is not None and conversion.unit is not None:
        same = not is_unit(unit, dimension) or si_factor(unit, "") == si_factor(conversion.unit, conversion.where)
        said = f"column '{header}' is read in {conversion.unit}, as the simulation declares, and not as its header says"
        return conversion, [] if same else [said]
    if unit is None or (dimension is not None and not is_unit(unit, dimension)):
        return conversion, []
    if si_factor(unit, conversion.where) == (1.0, 0.0):
        return replace(conversion, unit=unit), []
    return replace(conversion, unit=unit), [f"column '{header}' is read in {unit}, as its header says"]


def _hint(cell: str, *, leave_out: bool) -> str:
    if re.fullmatch(r"\s*[-+]?\d*,\d+([eE][-+]?\d+)?\s*", cell):
        return "write all numbers with a decimal point, or all with a comma and say decimal: ',' under recording"
    if re.fullmatch(r"\s*[-+]?\d{1,3}((,\d{3})+(\.\d*)?|(\.\d{3})+(,\d*)?)\s*", cell):
        return "write the number without marks between the thousands"
    if re.search(r"\d\s*[;\t,]\s*[-+\d]", cell):
        return "separate the cells as in the other lines"
    if re.search(r"\d[./-]\d+[./-]\d|\d:\d", cell):
        return "write dates as ISO 8601 has them, 2026-05-31T13:45:00.250, or times in seconds"
    if cell.strip().lower() in EMPTY and leave_out:
        return "fill in the number, remove the row, or say missing: leave-out under recording for the output"
    return "fill in the number (with a decimal point) or remove the row"


def _is_empty(cells: Cells) -> NDArray[np.bool_]:
    return np.array([str(cell).strip().lower() in EMPTY for cell in cells], dtype=bool)


def common_rows(table: Table, roles: Mapping[str, str | None]) -> RowNumbers:
    """Numbers of the rows that the columns of a table have in common.

    Parameters
    ----------
    table : Table
        Where it is one of several runs side by side, the empty rows at its end, which are of longer runs, do not count.
    roles : mapping of str to {"time", "input", "output", "label"}
        The columns, and what each is.

    Raises
    ------
    InputError
        If there is no such column, or they differ in their length.
    """
    cells = {c: table.column(c, role) for c, role in roles.items()}
    lengths = {c: len(column) for c, column in cells.items()}
    first = next(iter(roles))
    for column, length in lengths.items():
        if length != lengths[first]:
            raise InputError(
                f"'{column}' has {length} values, and '{first}' has {lengths[first]}",
                where=table.name,
                hint="name columns of one length",
            )
    count = lengths[first]
    if table.aliases:
        filled = [np.flatnonzero(~_is_empty(cells[c])) for c in roles if c in table.aliases]
        count = max((int(rows[-1]) + 1 for rows in filled if rows.size), default=0)
    return np.arange(count)


def runs(table: Table, column: str, rows: RowNumbers) -> list[tuple[str, RowNumbers]]:
    """Runs of equal values in a column: their names and their rows.

    Raises
    ------
    InputError
        If a cell is empty.
    """
    labels = series(table.column(column))
    empty = np.flatnonzero(labels.isna().to_numpy())
    if empty.size:
        raise InputError(
            "an empty cell or NaN",
            where=f"{table.name}, {table.where(int(empty[0]))}, column '{column}'",
            hint="name the experiment of each row",
        )
    codes = labels.factorize()[0]
    parts = np.split(rows, np.flatnonzero(np.diff(codes)) + 1)
    names = [_label(labels.iloc[p[0]]) for p in parts if p.size]
    return [
        (n if names.count(n) == 1 else f"{n} from {table.where(int(p[0]))}", p)
        for n, p in zip(names, parts, strict=False)
    ]


def _label(value: Any) -> str:
    """Name of an experiment: a whole number without a point."""
    if isinstance(value, float):
        return f"{value:.0f}" if value.is_integer() else f"{value:g}"
    return str(value)
