"""Where a diagnosis comes from: the command, the files with their dates and hashes, and the versions that made it."""

from __future__ import annotations

import hashlib
import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

# First time stamps between these are seconds since 1970: from 2001 to 2100. A recording counts from its own start else.
CALENDAR = 1.0e9, 4.1e9
# What a date is of.
FIRST_STAMP, FILE_TIME = "its first time stamp", "time of the file"


@dataclass(frozen=True)
class RecordedFile:
    """A file that was diagnosed.

    Attributes
    ----------
    name : str
        As it was given.
    sha256 : str or None
        Of its content; None where it is no file, but a table in memory.
    date : str or None
        When it was made, in universal time.
    date_is : str
        What the date is of: :data:`FIRST_STAMP` or :data:`FILE_TIME`.
    """

    name: str
    sha256: str | None = None
    date: str | None = None
    date_is: str = ""


@dataclass(frozen=True)
class Provenance:
    """Where a diagnosis comes from.

    Attributes
    ----------
    command : str
        What was typed, or the call from Python.
    simulation : str
        Name of the simulation.
    recordings : list of RecordedFile
    versions : dict of str to str
        Of camid, Python, NumPy and SciPy.
    """

    command: str
    simulation: str
    recordings: list[RecordedFile] = field(default_factory=list)
    versions: dict[str, str] = field(default_factory=dict)


def recorded_file(source: Any, first_stamp: float | None = None) -> RecordedFile:
    """Hash and date of a recording.

    Parameters
    ----------
    source : path or table
    first_stamp : float, optional
        First entry of its time column in seconds: a date where it counts from 1970.
    """
    stamp = None
    if first_stamp is not None and CALENDAR[0] < first_stamp < CALENDAR[1]:
        stamp = _utc(first_stamp)
    is_path = isinstance(source, str | os.PathLike)
    path = Path(source) if is_path else None
    if path is None or not path.is_file():
        name = str(source) if is_path else f"a table in memory ({type(source).__name__})"
        return RecordedFile(name, None, stamp, FIRST_STAMP if stamp else "")
    with path.open("rb") as stream:
        digest = hashlib.file_digest(stream, "sha256").hexdigest()
    if stamp is not None:
        return RecordedFile(str(source), digest, stamp, FIRST_STAMP)
    return RecordedFile(str(source), digest, _utc(path.stat().st_mtime), FILE_TIME)


def _utc(seconds: float) -> str:
    return datetime.fromtimestamp(int(seconds), UTC).strftime("%Y-%m-%d %H:%M:%S UTC")


def versions() -> dict[str, str]:
    """Versions of what computes a diagnosis."""
    import numpy as np
    import scipy

    import camid

    return {
        "camid": camid.__version__,
        "Python": platform.python_version(),
        "NumPy": np.__version__,
        "SciPy": scipy.__version__,
    }


def provenance_of(sources: Sequence[Any], simulation: str, first_stamps: Sequence[float | None]) -> Provenance:
    """Of a call from Python.

    Parameters
    ----------
    sources : sequence of path or table
        The recordings.
    simulation : str
        What messages call the simulation.
    first_stamps : sequence of (float or None)
        First entry of the time column of each; None where it is not known.
    """
    files = [recorded_file(source, stamp) for source, stamp in zip(sources, first_stamps, strict=True)]
    names = [repr(f.name) if f.sha256 else "table" for f in files]
    recordings = names[0] if len(names) == 1 else f"[{', '.join(names)}]"
    return Provenance(f"camid.diagnose({recordings}, {simulation!r})", simulation, files, versions())
