"""What the scripts of the workflow have in common: inputs, parameters and logs of a job."""

from __future__ import annotations

import fcntl
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from importlib import import_module
from pathlib import Path
from typing import Any, TextIO

from camid.errors import InputError


class _TwoStreams:
    """Text stream that writes to two others."""

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
    with _alone_at(Path(path)), Path(path).open("w", encoding="utf-8") as log:
        out = _TwoStreams(terminal, log) if also_print else log
        try:
            with redirect_stdout(out), redirect_stderr(log):
                yield
        except InputError as error:
            log.write(f"{error}\n")
            sys.exit(f"camid: error: {error}")
        except Exception as error:
            log.write(traceback.format_exc())
            sys.exit(f"camid: {type(error).__name__}: {error} (details in {path})")


@contextmanager
def _alone_at(log: Path) -> Iterator[None]:
    """Wait for the same job of a workflow that was killed: it may be at work still, and would write the same files."""
    with log.with_name(f".{log.name}.lock").open("a") as lock:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


# Inputs and parameters that only the workflow needs.
OF_THE_WORKFLOW = {"working_copy", "function", "code"}


def function_of(job: Any) -> Callable[..., Any]:
    """The function that the parameter ``function`` of a job names, ``module.function``."""
    module, _, name = job.params.function.rpartition(".")
    return getattr(import_module(module), name)


def parameters_of(job: Any) -> dict[str, Any]:
    """Parameters of a job by name, without those that say which code runs."""
    return {name: value for name, value in job.params.items() if name not in OF_THE_WORKFLOW}


def tables(job: Any) -> dict[str, Any]:
    """Inputs of a job by name, read: a DataFrame from Parquet or CSV, a dict of arrays from NPZ."""
    return {name: _read(Path(file)) for name, file in job.input.items() if name not in OF_THE_WORKFLOW}


def arguments(job: Any) -> dict[str, Any]:
    """Inputs and parameters of a job by name."""
    return {**tables(job), **parameters_of(job)}


def _read(file: Path) -> Any:
    import pandas as pd

    from camid.workflow.dataset_files import read_arrays, read_dataset

    if file.suffix == ".npz":
        return read_arrays(file)
    return read_dataset(file) if file.suffix == ".parquet" else pd.read_csv(file)
