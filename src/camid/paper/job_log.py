"""Logs of workflow jobs."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import TextIO

from camid.errors import InputError


class _Both:
    """Text stream that writes to two."""

    def __init__(self, first: TextIO, second: TextIO) -> None:
        self._streams = (first, second)

    def write(self, text: str) -> int:
        """Write to both."""
        for stream in self._streams:
            stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Flush both."""
        for stream in self._streams:
            stream.flush()


@contextmanager
def logged(path: str | Path, *, also_print: bool = False) -> Iterator[None]:
    """Send what a job prints to its log; an error goes there whole and to the terminal in one line.

    Parameters
    ----------
    path : path
    also_print : bool
        Whether the output is meant for the reader at the terminal, too.

    Raises
    ------
    SystemExit
        In place of any error, with a line that names it and the log.
    """
    terminal = sys.stdout
    with Path(path).open("w", encoding="utf-8") as log:
        out = _Both(terminal, log) if also_print else log
        try:
            with redirect_stdout(out), redirect_stderr(log):
                yield
        except InputError as error:
            log.write(f"{error}\n")
            sys.exit(f"camid: error: {error}")
        except Exception as error:
            log.write(traceback.format_exc())
            sys.exit(f"camid: {type(error).__name__}: {error} (whole story in {path})")
