"""One Snakemake at a time in a working copy, and no trace of one that was killed or of a clock that was set back.

Snakemake's own lock is a file that outlives a kill, and it is looked at before it is written, so that of two that start
at once both may go on. The locks here belong to the process: the system removes them with it.
"""

from __future__ import annotations

import fcntl
import os
import shutil
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import IO

# What rules read and write: results, and files of the sources that are inputs.
OF_THE_RULES = ("results", "paper_figs", "config", "src", "workflow")
# Of Snakemake, the names of its lock files in it.
LOCKS = "locks"


class WorkingCopy:
    """The folder in which this Snakemake runs.

    Parameters
    ----------
    folder : path
        Snakemake's own, ``.snakemake``.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(exist_ok=True)
        self._folder = folder
        # Both are held until this process ends, however it ends.
        self._there: IO[str] | None = None
        self._at_work: IO[str] | None = None

    def enter(self) -> bool:
        """Say that a Snakemake is here; remove the locks of a killed one if there is no other. Whether it was alone."""
        self._there = (self._folder / "camid_there.lock").open("a")
        alone = _taken(self._there, fcntl.LOCK_EX)
        if alone:
            shutil.rmtree(self._folder / LOCKS, ignore_errors=True)
        with suppress(OSError):
            fcntl.flock(self._there, fcntl.LOCK_SH)
        return alone

    def begin_work(self) -> bool:
        """Whether no other Snakemake computes here; from now on, this one does."""
        self._at_work = (self._folder / "camid_at_work.lock").open("a")
        return _taken(self._at_work, fcntl.LOCK_EX)


def _taken(file: IO[str], kind: int) -> bool:
    """Whether a lock could be had; where the file system knows no locks, it counts as had."""
    try:
        fcntl.flock(file, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


def settle_times(root: Path) -> int:
    """Give files from the future, which a clock that was set back leaves, times that lie just behind, in their order.

    Snakemake refuses every result that is older than what it was made from. Returns the number of files.
    """
    now = time.time_ns()
    ahead = sorted((status.st_mtime_ns, path) for path, status in _files(root) if status.st_mtime_ns > now)
    for place, (_, path) in enumerate(ahead):
        stamp = now - 1000 * (len(ahead) - place)
        with suppress(OSError):  # somebody else's file, or removed since
            os.utime(path, ns=(stamp, stamp), follow_symlinks=False)
    return len(ahead)


def _files(root: Path) -> Iterator[tuple[str, os.stat_result]]:
    waiting = [str(root / name) for name in OF_THE_RULES]
    while waiting:
        folder = waiting.pop()
        with suppress(OSError), os.scandir(folder) as entries:
            for entry in entries:
                yield entry.path, entry.stat(follow_symlinks=False)
                if entry.is_dir(follow_symlinks=False):
                    waiting.append(entry.path)
