"""Columns from files that hold named variables in groups: MAT and HDF5."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from camid.errors import InputError, nearest_match, need
from camid.recording.options import Reading
from camid.recording.reader_process import read_apart
from camid.recording.size_limits import refuse_hdf5, refuse_unpacking_mat
from camid.recording.table import Table
from camid.recording.units import is_unit

# Columns of one variable; more are a picture or a cube of data.
MOST_COLUMNS = 1000
# Kinds of numpy that are not real numbers.
KINDS = {"b": "made of truth values", "c": "complex", "S": "text", "U": "text", "O": "text", "T": "text"}


def read_mat(path: Path) -> dict[str, Any]:
    """Variables of a MAT file of version 4, 5 to 7.2, or 7.3; structures are dictionaries."""
    need("reading a MAT file", "formats", "pymatreader", "h5py")
    return dict(read_apart("MAT", path))


def variables_of(path: Path) -> dict[str, Any]:
    """Variables of a MAT file, read in this process.

    Raises
    ------
    InputError
        If what is packed in it is too large, or leads elsewhere.
    """
    import h5py
    import pymatreader

    if h5py.is_hdf5(path):
        with h5py.File(path, "r") as file:
            refuse_hdf5(file, str(path))
    else:
        refuse_unpacking_mat(path)
    with warnings.catch_warnings():  # what it cannot read turns up as a variable that is not a column
        warnings.simplefilter("ignore")
        tree = pymatreader.read_mat(path)
        kinds = {name: kind for name, _, kind in pymatreader.whosmat(path)}
    # It returns truth values as integers, and only the list of variables tells them from numbers.
    logical = {k: np.asarray(v, bool) for k, v in tree.items() if kinds.get(k) == "logical"}
    return {k: v for k, v in (tree | logical).items() if not k.startswith("__")}


def read_hdf5(path: Path) -> dict[str, Any]:
    """Datasets of an HDF5 file, read at once; groups are dictionaries, and so are compound datasets."""
    need("reading an HDF5 file", "formats", "h5py")
    return dict(read_apart("HDF5", path))


def datasets_of(path: Path) -> dict[str, Any]:
    """Datasets of an HDF5 file, read in this process.

    Raises
    ------
    InputError
        If what is packed in it is too large, or leads elsewhere.
    """
    import h5py

    def unit(node: Any) -> str:
        """The unit that a dataset's attributes give, in brackets as in a header."""
        if not isinstance(node, h5py.Dataset):
            return ""
        given = next((node.attrs[k] for k in ("unit", "units", "Unit", "Units") if k in node.attrs), "")
        text = given.decode("utf-8", "replace") if isinstance(given, bytes) else str(given)
        return f" [{text.strip()}]" if is_unit(text.strip()) else ""

    def content(node: Any) -> Any:
        if isinstance(node, h5py.Group):
            return {f"{name}{unit(node[name])}": content(node[name]) for name in node}
        if not isinstance(node, h5py.Dataset) or node.shape is None:
            return None
        values = node[()]
        fields = getattr(getattr(values, "dtype", None), "names", None)
        return values if fields is None else {str(n): values[n] for n in fields}

    with h5py.File(path, "r") as file:
        refuse_hdf5(file, str(path))
        return dict(content(file))


def tables_of(tree: Mapping[str, Any], name: str, wanted: Sequence[str], reading: Reading) -> list[Table]:
    """The table of a group, or one of each of the groups in it, in the natural order of their names.

    A group also has the columns of the groups around it, and those of the groups in it as ``group/column``.

    Parameters
    ----------
    tree : mapping
        Variables, groups as mappings.
    name : str
        For messages.
    wanted : sequence of str
        Columns that will be asked for.
    reading : Reading

    Raises
    ------
    InputError
        If there is no such group, or nothing in it is a column.
    """
    node: Any = tree
    around: dict[str, Any] = {}
    if reading.group is not None:
        for outer, inner in _path(tree, reading.group, name, reading):
            around |= _columns(outer)[0]
            node = inner
        name = name if node is tree else f"{name}, {reading.group}"
    whole = _table(node, name, around)
    groups = {n: v for n, v in _groups(node).items() if _columns(v)[0]}
    cells = [n for n in groups if re.fullmatch(r"\[\d+\]", n)]
    found = all(whole.find(column) is not None for column in wanted)
    if reading.group is None and not found and cells:
        tables = _experiments(node, {n: groups[n] for n in cells}, name, {})
        if all(t.find(column) is not None for t in tables for column in wanted):
            said = f"each of the {len(cells)} cells is read as an experiment (group: / under recording says so)"
            return [replace(tables[0], notes=(said, *tables[0].notes)), *tables[1:]]
    if groups and reading.group is not None and not found:
        tables = _experiments(node, groups, name, around)
        if len(tables) > 1 or all(tables[0].find(column) is not None for column in wanted):
            around |= _columns(node)[0]
            own = _columns(groups[str(tables[0].experiment)])[0]
            return [replace(tables[0], notes=_from_around(wanted, own, around)), *tables[1:]]
    inside = f" (groups: {', '.join(sorted(groups))}; say group: under recording)" if groups else ""
    if not whole.columns or not (found or _columns(node)[0]):
        raise InputError(
            "nothing here is a column of numbers",
            where=name,
            hint=f"it takes vectors of real numbers{inside}",
        )
    return [replace(whole, hint=inside, notes=_from_around(wanted, _columns(node)[0], around))]


def _from_around(wanted: Sequence[str], own: Mapping[str, Any], around: Mapping[str, Any]) -> tuple[str, ...]:
    """A sentence for each column that is not in a group but in one around it."""
    return tuple(f"column '{c}' is that of the group around it" for c in wanted if c not in own and c in around)


def layouts(tree: Mapping[str, Any], name: str) -> list[tuple[str | None, list[Table]]]:
    """Groups that may be recordings, likeliest first: the name to give as ``group``, and the tables in each.

    Groups in one group that have the same columns are experiments. Groups inside of others come after these.
    """
    found: list[tuple[str | None, list[Table]]] = []
    waiting: list[tuple[str | None, Mapping[str, Any]]] = [(None, tree)]
    for path, node in waiting:
        if _columns(node)[0]:
            found.append((path, [_table(node, name, {})]))
        groups = _groups(node)
        of_columns = {n: v for n, v in groups.items() if _columns(v)[0]}
        if len(of_columns) > 1 and len({tuple(_columns(v)[0]) for v in of_columns.values()}) == 1:
            found.append((path or "/", _experiments(node, of_columns, name, {})))
        waiting += [(n if path is None else f"{path}/{n}", v) for n, v in groups.items()]
    return found


def _experiments(
    node: Mapping[str, Any], groups: Mapping[str, Any], name: str, around: Mapping[str, Any]
) -> list[Table]:
    """A table of each of the groups in a group."""
    order = sorted(groups, key=lambda n: [(int(p) if p.isdigit() else 0, p) for p in re.split(r"(\d+)", n)])
    around = {**around, **_columns(node)[0]}
    return [replace(_table(groups[n], f"{name}/{n}", around), experiment=n) for n in order]


def _table(node: Mapping[str, Any], name: str, around: Mapping[str, Any]) -> Table:
    """Columns of a group, of the groups in it, and of those around it."""
    own, refused = _columns(node)
    inner = {n: c for n, c in _nested(node).items() if n not in own}
    outer = {n: c for n, c in around.items() if n not in own and n not in inner and n not in refused}
    single = {n: float(v) for n, v in node.items() if isinstance(v, int | float | np.number)}
    return Table({**own, **inner, **outer}, name, refused=refused, single=single)


def _nested(node: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Columns of the groups in a group, and in those, named by their path."""
    found: dict[str, Any] = {}
    for name, group in _groups(node).items():
        columns, _ = _columns(group)
        found |= {f"{prefix}{name}/{n}": c for n, c in columns.items()}
        found |= _nested(group, f"{prefix}{name}/")
    return found


def _path(
    tree: Mapping[str, Any], group: str, name: str, reading: Reading
) -> Iterator[tuple[Mapping[str, Any], Mapping[str, Any]]]:
    """The groups from the file to one in it, each with the next; ``/`` is the file itself."""
    node: Any = tree
    parts = [group] if group in tree else [p for p in re.split(r"[/.]", group) if p]
    for part in parts:
        inside = _groups(node)
        if part not in inside:
            known = nearest_match(part, inside) if inside else "there are no groups here"
            problem = f"'{group}' is a variable and no group" if part in node else f"no group '{group}'"
            raise InputError(problem, where=f"{name} ({reading.where}.group)", hint=known)
        yield node, inside[part]
        node = inside[part]
    if not parts:
        yield {}, tree


def _groups(node: Mapping[str, Any]) -> dict[str, Any]:
    """Groups in a group.

    The elements of a cell array of structures are groups in a group of its name. The cells of one number in all cell
    arrays of vectors or matrices, and an array of structures, are one group, ``[0]``, ``[1]``, …
    """
    found = {str(n): v for n, v in node.items() if isinstance(v, Mapping)}
    lists = {str(n): v for n, v in node.items() if isinstance(v, list)}
    for name, cells in lists.items():
        if any(isinstance(cell, Mapping) for cell in cells):
            found[name] = {f"[{i}]": cell for i, cell in enumerate(cells) if isinstance(cell, Mapping)}
    arrays = {n: v for n, v in lists.items() if any(isinstance(e, np.ndarray | list) for e in v)}
    for i in range(max((len(v) for v in arrays.values()), default=0)):
        cells_of_one_number: dict[str, Any] = {}
        for name, cells in arrays.items():
            cell = cells[i] if i < len(cells) else None
            if isinstance(cell, list):  # a cell array of several columns
                cells_of_one_number |= {f"{name}[{j}]": inner for j, inner in enumerate(cell)}
            elif cell is not None:
                cells_of_one_number[name] = cell
        found[f"[{i}]"] = cells_of_one_number
    return found


def _columns(node: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """Vectors of a group; matrices as ``name[0]``, ``name[1]``, …; and why the other variables are not columns."""
    columns: dict[str, Any] = {}
    refused: dict[str, str] = {}
    for name, value in sorted(node.items()):  # the reader of MAT files 7.3 has them in any order
        if isinstance(value, Mapping):
            refused[name] = "a group"
            continue
        array = np.squeeze(value) if isinstance(value, np.ndarray) else None
        reason = _reason(value, array)
        if reason is not None or array is None:
            refused[name] = reason or "no array"
        elif array.ndim == 1:
            columns[name] = array
        else:
            table = array if array.shape[0] >= array.shape[1] else array.T
            count = table.shape[1]
            columns |= {f"{name}[{i}]": table[:, i] for i in range(count)}
            listed = f"{name}[0] (the first), {name}[1]{', …' if count > 2 else ' (the last)'}"
            refused[name] = f"a matrix of {count} columns, which are counted from 0: name one of them, {listed}"
    return columns, refused


def _reason(value: Any, array: Any) -> str | None:
    """Why a variable is not a column; None if it is one."""
    if array is None:
        named = {str: "text", bytes: "text", list: "a cell array", bool: "a truth value"}
        return named.get(type(value), "a single value" if np.isscalar(value) else "of a kind that is not read")
    if array.dtype.kind not in "fiu":
        return KINDS.get(array.dtype.kind, f"of the kind {array.dtype}")
    if array.ndim == 0 or array.size == 0:
        return "empty" if array.size == 0 else "a single value"
    if array.ndim > 2 or (array.ndim == 2 and min(array.shape) > MOST_COLUMNS):
        return f"an array of {' × '.join(str(n) for n in array.shape)}"
    return None
