"""Files that are written whole or not at all, and numbers that JSON knows."""

from __future__ import annotations

import os
import tempfile
from cmath import isfinite
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camid.errors import InputError, need

if TYPE_CHECKING:
    import pandas as pd

PARQUET = {".parquet", ".pq"}
TABLES = {".csv", *PARQUET}
# Bytes at the beginning and the end of a file in which it says who wrote it.
NEAR_ENDS = 1 << 16


def write_table(table: pd.DataFrame, path: str | os.PathLike[str], missing: str = "nan") -> None:
    """Write CSV or Parquet, whole or not at all; ``missing`` is what a cell of a CSV without a number says."""

    def write(temporary: Path) -> None:
        if Path(path).suffix.lower() in PARQUET:
            table.to_parquet(temporary, index=False)
        else:
            table.to_csv(temporary, index=False, na_rep=missing)

    write_whole(path, write)


def check_writable(path: str | os.PathLike[str]) -> None:
    """Refuse what :func:`write_whole` could not write, before the work is done.

    Raises
    ------
    InputError
        If the folder does not exist, or the path is a folder, a device or a pipe.
    """
    target = Path(os.path.realpath(path))
    if target.is_dir():
        raise InputError("this is a folder", where=str(path), hint="name a file to write")
    if not target.parent.is_dir():
        raise InputError("no such folder", where=str(target.parent), hint="make it, or write somewhere else")
    if target.suffix.lower() in PARQUET:
        need("writing a Parquet file", "formats", "pyarrow", hint="or write CSV")
    if target.exists() and not target.is_file():
        raise InputError("this is a device or a pipe", where=str(path), hint="name a file to write")


def check_folder(folder: Path, marks: Mapping[str, str | None], inputs: Sequence[Path] = ()) -> None:
    """Refuse, before the work is done, a folder that results cannot go to.

    Parameters
    ----------
    folder : Path
    marks : mapping of str to str or None
        The files that may be written into it, or removed, and what each says that camid wrote. A file that cannot say
        it is taken for one of camid's where a file beside it is.
    inputs : sequence of Path
        What the results are made from, and what they may not overwrite.

    Raises
    ------
    InputError
        If it is a file or cannot be written to, its parent does not exist, or one of the results would overwrite an
        input or a file that camid did not write, or is called like a folder.
    """
    parent = folder.resolve().parent
    if folder.exists() and not folder.is_dir():
        raise InputError("this is a file", where=str(folder), hint="name a folder for the results")
    if not parent.is_dir():
        raise InputError("no such folder", where=str(parent), hint="make it, or write elsewhere")
    if not os.access(folder if folder.exists() else parent, os.W_OK | os.X_OK):
        raise InputError("no permission to write here", where=str(folder), hint="write elsewhere")
    for target in (folder / name for name in marks):
        for path in inputs:
            if target.exists() and path.exists() and target.samefile(path):
                raise InputError(
                    f"{target.name} would overwrite what it is made from", where=str(path), hint="name another folder"
                )
        if folder.exists():
            check_writable(target)
    _refuse_foreign(folder, marks)


def _refuse_foreign(folder: Path, marks: Mapping[str, str | None]) -> None:
    """Refuse to overwrite files that camid did not write."""
    there = {folder / name: mark for name, mark in marks.items() if (folder / name).is_file()}
    ours = {path for path, mark in there.items() if mark is not None and _says(path, mark)}
    for path, mark in there.items():
        if path not in ours and not (mark is None and ours) and path.stat().st_size:
            raise InputError(
                "camid did not write this file and would overwrite it",
                where=str(path),
                hint="move or remove it, or name another folder",
            )


def _says(path: Path, mark: str) -> bool:
    """Whether a mark stands near the beginning or the end of a file."""
    with path.open("rb") as stream:
        start = stream.read(NEAR_ENDS)
        stream.seek(max(path.stat().st_size - NEAR_ENDS, 0))
        return mark.encode() in start + b"\n" + stream.read(NEAR_ENDS)


def write_whole(path: str | os.PathLike[str], write: Callable[[Path], Any]) -> None:
    """Let ``write`` fill a temporary file beside ``path``, then rename it: nothing is ever half-written.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written to.
    """
    check_writable(path)
    target = Path(os.path.realpath(path))  # a link stays a link to the file that is written
    try:
        handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=".camid-", suffix=target.suffix)
    except OSError as error:
        raise InputError(f"cannot write ({error.strerror})", where=str(target.parent), hint="write elsewhere") from None
    os.close(handle)
    try:
        write(Path(temporary))
        with open(temporary, "rb") as written:  # before its name says that it is whole
            os.fsync(written.fileno())
        # A temporary file is private; what it becomes is as readable as any other new file.
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, target)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def without_infinities(value: Any) -> Any:
    """The same with None for infinities and NaN, which JSON does not know."""
    if isinstance(value, dict):
        return {k: without_infinities(v) for k, v in value.items()}
    if isinstance(value, list):
        return [without_infinities(v) for v in value]
    return value if not isinstance(value, float | complex) or (isfinite(value) and value.imag == 0.0) else None
