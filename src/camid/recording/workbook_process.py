"""Reading a spreadsheet in a process of its own, whose memory and time are limited.

A sheet of one cell in its last row and column takes two kilobytes, and its area 400 GB: the reader, which is compiled,
ends its process when there are none. ``python -m camid.recording.workbook_process FILE`` is that process.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

# Bytes of address space, and seconds.
MOST_MEMORY, MOST_TIME = 4 * 2**30, 300.0
NO_SPREADSHEET = 3


def read_cells(path: Path) -> dict[str, list[list[Any]]]:
    """Cells of each sheet, by its name.

    Raises
    ------
    ValueError
        If the file is no spreadsheet, or reading it takes more memory or time than there may be.
    """
    # A list of arguments and no shell: a name is a name, whatever is in it.
    command = [sys.executable, "-m", __spec__.name, str(path.resolve())]
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=MOST_TIME, check=False)
    except subprocess.TimeoutExpired:
        raise ValueError(f"it takes more than {MOST_TIME:g} s") from None
    if done.returncode == NO_SPREADSHEET:
        raise ValueError(done.stderr.decode("utf-8", "replace").strip())
    if done.returncode != 0:
        raise ValueError("its area of cells does not fit into memory")
    cells: dict[str, list[list[Any]]] = pickle.loads(done.stdout)
    return cells


def main(path: str) -> int:
    """Write the cells of a spreadsheet to the output stream, pickled."""
    import resource

    with suppress(OSError, ValueError):  # a system that does not know this limit, or has a lower one
        resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    from python_calamine import CalamineWorkbook

    try:
        workbook = CalamineWorkbook.from_path(path)
        cells = {n: workbook.get_sheet_by_name(n).to_python(skip_empty_area=False) for n in workbook.sheet_names}
    except MemoryError:
        return 1
    except Exception as error:
        sys.stderr.write(" ".join(str(error).split()) or type(error).__name__)
        return NO_SPREADSHEET
    pickle.dump(cells, sys.stdout.buffer)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
