"""Tables from the sheets of a spreadsheet: Excel (.xlsx, .xlsm, .xlsb, .xls) and OpenDocument (.ods)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path
from typing import Any

from camid.errors import InputError, nearest_match, need
from camid.recording.options import Reading
from camid.recording.reader_process import read_apart
from camid.recording.table import Table
from camid.recording.units import is_unit, with_bracketed_unit

Rows = list[list[Any]]


def read_workbook(path: Path) -> dict[str, Rows]:
    """Cells of each sheet that is not empty, by its name; an empty cell is an empty text."""
    need("reading a spreadsheet", "formats", "python_calamine", hint="or save the sheet as CSV")
    sheets = read_apart("spreadsheet", path)
    return {n: rows for n, rows in sheets.items() if any(_filled(row) for row in rows)}


def cells_of(path: Path) -> dict[str, Rows]:
    """Cells of each sheet, by its name, in this process."""
    from python_calamine import CalamineWorkbook

    workbook = CalamineWorkbook.from_path(str(path))
    return {n: workbook.get_sheet_by_name(n).to_python(skip_empty_area=False) for n in workbook.sheet_names}


def tables_of_sheets(sheets: dict[str, Rows], name: str, wanted: Sequence[str], reading: Reading) -> list[Table]:
    """The table of a sheet, or of each of them.

    Parameters
    ----------
    sheets : dict of str to list of list
        Cells by the names of the sheets.
    name : str
        For messages.
    wanted : sequence of str
        Columns that will be asked for.
    reading : Reading
        ``group`` names a sheet, ``/`` stands for all of them, each an experiment. Without it the only sheet that has
        the columns is read.

    Raises
    ------
    InputError
        If there is no such sheet, several have the columns, or a sheet holds no table.
    """
    if not sheets:
        raise InputError("the file is empty", where=name, hint="it needs a header line and rows")
    group = reading.group
    if group is not None and group.strip("/") in sheets:
        only = group.strip("/")
        return [_table(sheets[only], f"{name}, sheet {only}", reading)]
    if group is not None and group != "/":
        raise InputError(
            f"no sheet '{group}'", where=f"{name} ({reading.where}.group)", hint=nearest_match(group, sheets)
        )
    tables = {}
    for sheet, rows in sheets.items():
        if len(sheets) == 1 or _header(rows, reading) is not None:  # a sheet of remarks is none of the recording
            tables[sheet] = _table(rows, f"{name}, sheet {sheet}", reading)
    fitting = {s: t for s, t in tables.items() if all(t.find(c) is not None for c in wanted)}
    if group == "/":
        return [replace(t, experiment=s) for s, t in fitting.items() or tables.items()]
    if len(fitting) > 1:
        listed = ", ".join(fitting)
        hint = f"say group: {next(iter(fitting))} under recording, or group: / for each as an experiment"
        raise InputError(f"the sheets {listed} all have these columns", where=name, hint=hint)
    chosen = next(iter(fitting or tables), None)
    if chosen is None:
        raise InputError("no sheet holds a table of numbers", where=name, hint="it needs a header line and rows")
    table = tables[chosen]
    notes = (f"the sheet '{chosen}' of {len(sheets)} is read (group: {chosen} under recording says so)",)
    return [table if len(sheets) == 1 else _noted(table, notes, ", ".join(tables))]


def _noted(table: Table, notes: tuple[str, ...], sheets: str) -> Table:
    return replace(table, notes=notes, hint=f" (sheets: {sheets}; say group: under recording)")


def _filled(row: Sequence[Any]) -> list[int]:
    """Positions of the cells that are not empty."""
    return [i for i, cell in enumerate(row) if not (isinstance(cell, str) and not cell.strip())]


def _is_value(cell: Any) -> bool:
    """Whether a cell holds a number or a date."""
    return not isinstance(cell, str | bool)


def _header(rows: Rows, reading: Reading) -> tuple[int, int] | None:
    """Row of the names (−1: there is none) and first row of numbers; None if there are no numbers."""
    first = next(
        (i for i, row in enumerate(rows) if (filled := _filled(row)) and sum(_is_value(row[j]) for j in filled) > 1),
        next((i for i, row in enumerate(rows) if (filled := _filled(row)) and _is_value(row[filled[0]])), None),
    )
    if first is None:
        return None
    if not reading.header:
        return -1, first
    above = [i for i in range(first) if _filled(rows[i])]
    if len(above) > 1 and _are_units(rows[above[-1]]):
        names, units = rows[above[-2]], rows[above[-1]]
        if len(_filled(names)) >= len(_filled(units)):
            return above[-2], first
    return (above[-1] if above else -1), first


def _are_units(row: Sequence[Any]) -> bool:
    texts = [str(row[i]).strip("[]() ") for i in _filled(row)]
    return bool(texts) and all(is_unit(text) for text in texts if text != "-")


def _table(rows: Rows, name: str, reading: Reading) -> Table:
    """Table of a sheet: the names are in the last row of text above the numbers."""
    import pandas as pd

    place = _header(rows, reading)
    if place is None:
        raise InputError("there are no numbers in this sheet", where=name, hint="it needs a header line and rows")
    names_row, first = place
    width = max(len(row) for row in rows)
    if not reading.header:
        names = list(reading.columns)
    elif names_row < 0:
        raise InputError(
            "the first row holds numbers, not names",
            where=f"{name}, row {first + 1}",
            hint="say header: false and columns: [names in order] under recording in the simulation",
        )
    else:
        names = [str(cell).strip() for cell in rows[names_row]]
        units = rows[first - 1] if first - 1 > names_row and _are_units(rows[first - 1]) else []
        given = [str(u).strip("[]() ") for u in units]
        names = [f"{n} [{u}]" if n and is_unit(u) else n for n, u in zip_longest(names, given, fillvalue="")]
        names = [with_bracketed_unit(n) for n in names]
    names += [""] * (width - len(names))
    repeated = sorted({n for n in names if n and names.count(n) > 1})
    if repeated:
        raise InputError(f"two columns are named '{repeated[0]}'", where=name, hint="rename one")
    last = max(i for i, row in enumerate(rows) if _filled(row)) + 1
    body = rows[first:last]
    columns = {}
    for j, column in enumerate(names):
        if column:
            cells = [row[j] if j < len(row) else "" for row in body]
            columns[column] = pd.Series(cells).infer_objects()
    return Table(columns, name, lambda row: f"row {row + first + 1}")
