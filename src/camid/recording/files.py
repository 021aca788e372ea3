"""Tables from files of any kind: text, Parquet, MAT, HDF5, spreadsheets; by their suffix, checked by their content."""

from __future__ import annotations

import gzip
import os
import sys
import zipfile
import zlib
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeGuard, cast

from camid.errors import InputError, need
from camid.recording.options import Reading
from camid.recording.size_limits import read_at_most, refuse_many_columns, refuse_no_file, refuse_size
from camid.recording.table import Table

if TYPE_CHECKING:
    import pandas as pd

SUFFIXES = {
    ".csv": "text",
    ".txt": "text",
    ".tsv": "text",
    ".dat": "text",
    ".parquet": "Parquet",
    ".pq": "Parquet",
    ".mat": "MAT",
    ".h5": "HDF5",
    ".hdf5": "HDF5",
    ".hdf": "HDF5",
}
VIDEOS = {".mp4", ".m4v", ".avi", ".mov", ".mkv", ".webm", ".mpg", ".mpeg", ".wmv"}
SPREADSHEETS = {".xls", ".xlsx", ".xlsm", ".xlsb", ".ods"}
# First bytes of the files of each kind.
SIGNATURES = {
    "Parquet": (b"PAR1",),
    "MAT": (b"MATLAB 5.0 MAT-file", b"MATLAB 7.3 MAT-file"),
    "HDF5": (b"\x89HDF\r\n\x1a\n",),
    "zip": (b"PK\x03\x04",),
    "gzip": (b"\x1f\x8b",),
    "Excel": (b"\xd0\xcf\x11\xe0",),
}
TEXT_KEYS = {"separator": None, "decimal": None, "header": True}


def read_tables(source: str | os.PathLike[str] | pd.DataFrame, wanted: Sequence[str], reading: Reading) -> list[Table]:
    """Tables of a file: one, or several where ``reading.group`` names a group that holds several.

    Parameters
    ----------
    source : path or DataFrame
    wanted : sequence of str
        Columns that will be asked for.
    reading : Reading

    Raises
    ------
    InputError
        If the file cannot be read, is not what its suffix says, or ``reading`` says what does not apply to it.
    """
    if _is_frame(source):
        _refuse_keys("a DataFrame", reading, *TEXT_KEYS, "group")
        return [_of_frame(source, "recording")]
    path, name = Path(cast("str | os.PathLike[str]", source)), str(source)
    kind, data = _kind(path, name)
    if kind == "text":
        _refuse_keys("a text file", reading, "group")
        return [_of_text(data if data is not None else _bytes_of(path, name), name, wanted, reading)]
    without = ["separator", "decimal"] if kind == "spreadsheet" else [*TEXT_KEYS]
    _refuse_keys(f"a {kind} file", reading, *without, *(["group"] if kind == "Parquet" else []))
    if kind == "Parquet":
        return [_of_frame(_whole(path, name, kind), name)]
    if kind == "spreadsheet":
        from camid.recording.sheets import tables_of_sheets

        return tables_of_sheets(_whole(path, name, kind), name, wanted, reading)
    from camid.recording.mat_hdf5 import tables_of

    return tables_of(_whole(path, name, kind), name, wanted, reading)


def _is_frame(source: str | os.PathLike[str] | pd.DataFrame) -> TypeGuard[pd.DataFrame]:
    """Whether a source is a table already; pandas is not imported to tell that a path is none."""
    pandas = sys.modules.get("pandas")
    return pandas is not None and isinstance(source, pandas.DataFrame)


def _whole(path: Path, name: str, kind: str) -> Any:
    """Content of a file that is not text; InputError where it cannot be read."""
    from camid.recording.mat_hdf5 import read_hdf5, read_mat
    from camid.recording.sheets import read_workbook

    try:
        if kind == "Parquet":
            import pandas as pd

            need("reading a Parquet file", "formats", "pyarrow")
            _refuse_large_parquet(path, name)
            return pd.read_parquet(path)
        return {"MAT": read_mat, "HDF5": read_hdf5, "spreadsheet": read_workbook}[kind](path)
    except InputError:
        raise
    except Exception as error:  # each reader has errors of its own kind for a damaged file, or no right to read
        detail = " ".join(str(error).split()) or type(error).__name__
        raise InputError(
            f"cannot be read as {kind} ({detail})",
            where=name,
            hint=f"is it whole, and is it a {kind}{'' if kind == 'spreadsheet' else ' file'}?",
        ) from None


def _refuse_large_parquet(path: Path, name: str) -> None:
    """Refuse by its footer what would not fit into memory: equal values take next to nothing in the file."""
    import pyarrow.parquet as pq

    footer = pq.read_metadata(path)
    refuse_many_columns(footer.num_columns, name)
    packed = sum(footer.row_group(i).total_byte_size for i in range(footer.num_row_groups))
    refuse_size(max(8 * footer.num_rows * footer.num_columns, packed), name)


def possible_readings(path: Path) -> list[tuple[Reading, list[Table]]]:
    """Ways to read a file of which nothing is known, and the tables that each finds, likeliest first.

    Raises
    ------
    InputError
        If the file cannot be read.
    """
    name = str(path)
    kind, data = _kind(path, name)
    if kind == "text":
        from camid.recording.text import names_needed

        count = names_needed(data if data is not None else _bytes_of(path, name), name)
        names = tuple(f"column{i + 1}" for i in range(count))
        reading = Reading(header=False, columns=names) if names else Reading()
        return [(reading, read_tables(path, (), reading))]
    if kind == "Parquet":
        return [(Reading(), read_tables(path, (), Reading()))]
    if kind == "spreadsheet":
        reading = Reading(group="/")
        tables = read_tables(path, (), reading)
        alone = [(Reading(group=t.experiment), [t]) for t in tables]
        if len(tables) == 1:
            return [(Reading(), tables)]
        return [(reading, tables), *alone] if len({tuple(t.columns) for t in tables}) == 1 else alone
    from camid.recording.mat_hdf5 import layouts

    return [(Reading(group=group), tables) for group, tables in layouts(_whole(path, name, kind), name)]


def _bytes_of(path: Path, name: str) -> bytes:
    refuse_size(path.stat().st_size, name)
    return path.read_bytes()


def _of_text(data: bytes, name: str, wanted: Sequence[str], reading: Reading) -> Table:
    from camid.recording.text import cell_of, line_of, read_text

    columns, text = read_text(data, name, wanted, reading)
    places = {column: i for i, column in enumerate(columns)}
    return Table(
        columns,
        name,
        lambda row: line_of(text, row, header=reading.header),
        written=lambda row, column: cell_of(text, row, places[column], header=reading.header),
    )


def _of_frame(frame: pd.DataFrame, name: str) -> Table:
    names = [str(c) for c in frame.columns]
    repeated = sorted(c for c, count in Counter(names).items() if count > 1)
    if repeated:
        raise InputError(f"two columns are named '{repeated[0]}'", where=name, hint="rename one")
    return Table({n: frame.iloc[:, i] for i, n in enumerate(names)}, name)


def _refuse_keys(what: str, reading: Reading, *keys: str) -> None:
    default = Reading()
    for key in keys:
        if getattr(reading, key) != getattr(default, key):
            raise InputError(
                f"{what} has no {key}", where=f"{reading.where}.{key}", hint="remove it, or name another recording"
            )


def _kind(path: Path, name: str) -> tuple[str, bytes | None]:
    """Kind of a file, and its content where it had to be unpacked."""
    if path.is_dir():
        raise InputError("this is a folder", where=name, hint="name a CSV, Parquet, MAT or HDF5 file, or a spreadsheet")
    if not path.exists():
        raise InputError("no such file", where=name, hint="check the path")
    refuse_no_file(path, name)
    suffix = path.suffix.lower()
    if suffix in VIDEOS:
        raise InputError("this is a video", where=name, hint="camid track makes a recording of it")
    try:
        with path.open("rb") as stream:
            head = stream.read(64)
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", where=name, hint="check its permissions") from None
    content = next((kind for kind, heads in SIGNATURES.items() if head.startswith(heads)), None)
    if content == "Excel" or (content == "zip" and _is_spreadsheet(path)):
        if suffix and suffix not in SPREADSHEETS:
            raise InputError(
                f"this is a spreadsheet, although its name ends in {suffix}", where=name, hint="rename it to .xlsx"
            )
        return "spreadsheet", None
    if suffix in SPREADSHEETS:
        raise InputError(
            f"this is no spreadsheet, although its name ends in {suffix}", where=name, hint="rename it, if it is whole"
        )
    if content in {"zip", "gzip"}:
        return "text", _unpacked(path, name, content)
    kind = SUFFIXES.get(suffix, content or "text")
    if content is not None and content != kind:
        right = next(s for s, k in SUFFIXES.items() if k == content)
        raise InputError(
            f"this is {'an' if content == 'HDF5' else 'a'} {content} file, although its name ends in {suffix}",
            where=name,
            hint=f"rename it to {right}",
        )
    return kind, None


def _is_spreadsheet(path: Path) -> bool:
    try:
        with zipfile.ZipFile(path) as archive:
            return any(n.startswith(("xl/", "[Content_Types]")) or n == "content.xml" for n in archive.namelist())
    except zipfile.BadZipFile:
        return False


def _unpacked(path: Path, name: str, kind: str) -> bytes:
    """The text file in an archive that holds one file."""
    inner = Path(path.stem)
    try:
        if kind == "gzip":
            with gzip.open(path) as stream:
                data = read_at_most(stream, name)  # type: ignore[arg-type]
        else:
            with zipfile.ZipFile(path) as archive:
                members = [m for m in archive.namelist() if not m.endswith("/")]
                if len(members) != 1:
                    raise InputError(
                        f"{len(members)} files in an archive", where=name, hint="unpack it, and name one of them"
                    )
                with archive.open(members[0]) as stream:
                    data, inner = read_at_most(stream, name), Path(members[0])
    except (OSError, EOFError, RuntimeError, zipfile.BadZipFile, zlib.error) as error:
        raise InputError(f"cannot be unpacked ({error})", where=name, hint="pack it again") from None
    if SUFFIXES.get(inner.suffix.lower(), "text") != "text" or any(data.startswith(h) for h in SIGNATURES.values()):
        raise InputError("what is packed is not a text file", where=name, hint="unpack it")
    return data
