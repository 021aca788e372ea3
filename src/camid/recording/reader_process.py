"""Reading a file by a compiled reader in a process of its own, whose memory and time are limited.

What these readers do with a file that was made to hurt is theirs: a sheet of one cell in its last row and column takes
two kilobytes, and its area 400 GB; a damaged MAT file ends the process that reads it; an HDF5 file may lead its library
in circles. ``python -P -m camid.recording.reader_process KIND FILE`` is that process.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any

from camid.errors import InputError
from camid.recording import size_limits

# Kind of file → module and function that reads it.
READERS = {
    "spreadsheet": ("camid.recording.sheets", "cells_of"),
    "MAT": ("camid.recording.mat_hdf5", "variables_of"),
    "HDF5": ("camid.recording.mat_hdf5", "datasets_of"),
}
# Bytes of address space, and seconds.
MOST_MEMORY, MOST_TIME = 8 * 2**30, 90.0
READ, UNREADABLE, TOO_LARGE = 0, 3, 4


def read_apart(kind: str, path: Path) -> Any:
    """What the reader of a kind of file makes of a file.

    Raises
    ------
    InputError
        If the reader refuses the file.
    ValueError
        If the file is none of that kind, or reading it takes more memory or time than there may be.
    """
    # A list of arguments and no shell: a name is a name, whatever is in it. With -P nothing is imported from the folder
    # in which the command is called.
    command = [sys.executable, "-P", "-m", __spec__.name, kind, str(path), str(size_limits.MOST_BYTES)]
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=MOST_TIME, check=False)
    except subprocess.TimeoutExpired:
        raise ValueError(f"it takes more than {MOST_TIME:g} s") from None
    if done.returncode == UNREADABLE:
        raise ValueError(done.stderr.decode("utf-8", "replace").strip())
    if done.returncode == TOO_LARGE:
        raise ValueError("it does not fit into memory")
    if done.returncode != READ:
        raise ValueError("its reader ends without an answer, as for want of memory")
    refused, content = pickle.loads(done.stdout)
    if refused:
        problem, where, hint = content
        raise InputError(problem, where=where, hint=hint)
    return content


def main(kind: str, path: str, most_bytes: str) -> int:
    """Write what the reader makes of a file of so much data at most to the output stream, pickled."""
    import resource

    size_limits.MOST_BYTES = int(most_bytes)

    with suppress(OSError, ValueError):  # a system that does not know this limit, or has a lower one
        resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    module, function = READERS[kind]
    try:
        content: tuple[bool, Any] = (False, getattr(import_module(module), function)(Path(path)))
    except MemoryError:
        return TOO_LARGE
    except InputError as error:
        content = (True, (error.problem, error.where, error.hint))
    except Exception as error:  # each reader has errors of its own kind
        sys.stderr.write(" ".join(str(error).split()) or type(error).__name__)
        return UNREADABLE
    pickle.dump(content, sys.stdout.buffer)
    return READ


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
