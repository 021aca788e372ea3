"""Files that are written whole or not at all, and numbers that JSON knows."""

from __future__ import annotations

import os
import tempfile
from cmath import isfinite
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camid.errors import InputError, need

if TYPE_CHECKING:
    import pandas as pd

PARQUET = {".parquet", ".pq"}


def write_table(table: pd.DataFrame, path: str | os.PathLike[str]) -> None:
    """Write CSV or Parquet, whole or not at all."""

    def write(temporary: Path) -> None:
        if Path(path).suffix.lower() in PARQUET:
            table.to_parquet(temporary, index=False)
        else:
            table.to_csv(temporary, index=False, na_rep="nan")  # no blanks

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


def check_folder(folder: Path, names: Sequence[str], inputs: Sequence[Path] = ()) -> None:
    """Refuse, before the work is done, a folder that results cannot go to.

    Parameters
    ----------
    folder : Path
    names : sequence of str
        Of the files that may be written into it.
    inputs : sequence of Path
        What the results are made from, and what they may not overwrite.

    Raises
    ------
    InputError
        If it is a file or cannot be written to, its parent does not exist, or one of the results would overwrite an
        input or is called like a folder.
    """
    parent = folder.resolve().parent
    if folder.exists() and not folder.is_dir():
        raise InputError("this is a file", where=str(folder), hint="name a folder for the results")
    if not parent.is_dir():
        raise InputError("no such folder", where=str(parent), hint="make it, or write elsewhere")
    if not os.access(folder if folder.exists() else parent, os.W_OK | os.X_OK):
        raise InputError("no permission to write here", where=str(folder), hint="write elsewhere")
    for target in (folder / name for name in names):
        for path in inputs:
            if target.exists() and path.exists() and target.samefile(path):
                raise InputError(
                    f"{target.name} would overwrite what it is made from", where=str(path), hint="name another folder"
                )
        if folder.exists():
            check_writable(target)


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
