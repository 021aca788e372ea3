"""Diagnoses of concealed recordings through the command's contract, by a process that can see nothing else."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import pandas as pd

from camid.proof.sealed_files import DIAGNOSIS, FAILURE, IMPROVED, RECORDING, SIMULATION

OUTPUT = "diagnosis"
# Of a recording whose diagnosis only makes the process import and load what it needs.
WARM_UP_LINES = 301
NO_TIME_LIMIT = ["--time-limit", "0"]  # the same answer on any machine
WORTH_TIMING_ALONE = 5.0  # seconds beside other work
NO_REPORT = "--no-report"  # nobody reads hundreds of them, and they say no more than diagnosis.json
ONE_THREAD_EACH = {
    f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "VECLIB_MAXIMUM", "NUMBA")
}


class ForbiddenReadError(PermissionError):
    """A diagnosis opened a file that it must not see."""


def diagnose_all(indices: list[int], recordings: Path, diagnoses: Path) -> pd.DataFrame:
    """Diagnose recordings, each in its own folder that holds only its two files.

    The folders lie outside the working copy, and their files have names that reveal nothing, digits of their digests,
    so that a second run says the same byte for byte. One child process diagnoses all of them through ``camid diagnose``
    with the folder as its working directory. It is refused every file of the working copy but the package itself.

    Parameters
    ----------
    indices : list of int
    recordings : path
        Folder with one folder per recording.
    diagnoses : path
        Gets diagnosis.json and improved.yaml, or failure.txt if the command failed, in one folder per recording.

    Returns
    -------
    DataFrame
        ``index``, ``seconds``: run time of the command in the warm process.

    Raises
    ------
    ForbiddenReadError
        If a diagnosis opened a file that it must not see.
    ValueError
        If the folder for temporary files lies in the working copy.
    RuntimeError
        If the child process died.
    """
    temporary = Path(tempfile.gettempdir()).resolve()
    if temporary.is_relative_to(Path.cwd().resolve()):
        raise ValueError(f"the folder for temporary files, {temporary}, lies in the working copy; set TMPDIR elsewhere")
    run_times = []
    with Worker(Path.cwd().resolve()) as worker:
        for position, index in enumerate(indices):
            source = recordings / str(index)
            if position == 0:  # imports and the loading of compiled code are not part of the run time
                _diagnose(worker, source, None)
            seconds = _diagnose(worker, source, diagnoses / str(index))
            run_times.append({"index": index, "seconds": seconds})
    return pd.DataFrame(run_times, columns=["index", "seconds"])


def timed_alone(run_times: pd.DataFrame, recordings: Path, diagnoses: Path) -> pd.DataFrame:
    """Time again, with nothing beside it, what took long beside something else.

    Parameters
    ----------
    run_times : DataFrame
        As :func:`diagnose_all` returns it.
    recordings, diagnoses : path
        As for that.

    Returns
    -------
    DataFrame
        ``index``, ``seconds`` of those that took longer than `WORTH_TIMING_ALONE`.

    Raises
    ------
    ValueError
        If a diagnosis says something else than before.
    """
    slow = run_times[run_times["seconds"] > WORTH_TIMING_ALONE]["index"].tolist()
    if not slow:
        return run_times.iloc[:0]
    with tempfile.TemporaryDirectory() as name:
        found = diagnose_all(slow, recordings, Path(name))
        for index in slow:
            if _improved(diagnoses, index) != _improved(Path(name), index):
                raise ValueError(f"the diagnosis of recording {index} says something else when it is made again")
    return found


def _improved(diagnoses: Path, index: int) -> bytes:
    """The improved simulation of a recording; empty where its diagnosis failed."""
    path = diagnoses / str(index) / IMPROVED
    return path.read_bytes() if path.exists() else b""


def with_times_alone(run_times: pd.DataFrame, alone: pd.DataFrame) -> pd.DataFrame:
    """Run times, those that were taken again in the place of the first ones."""
    again = run_times["index"].map(alone.set_index("index")["seconds"])
    return run_times.assign(seconds=again.fillna(run_times["seconds"]))


def _diagnose(worker: Worker, source: Path, target: Path | None) -> float:
    """Seconds that one diagnosis took; its files are copied to ``target``, or it only warms the process up."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        names = {}
        for file in (source / RECORDING, source / SIMULATION):
            content = file.read_bytes()
            if target is None and file.name == RECORDING:
                content = b"".join(content.splitlines(keepends=True)[:WARM_UP_LINES])
            names[file.name] = hashlib.sha256(content).hexdigest()[:16] + file.suffix
            (folder / names[file.name]).write_bytes(content)
        arguments = ["diagnose", names[RECORDING], "--simulation", names[SIMULATION], "--output", OUTPUT, NO_REPORT]
        arguments += NO_TIME_LIMIT
        answer = worker.run(folder, arguments)
        if answer["forbidden"]:
            raise ForbiddenReadError(f"the diagnosis in {source} opened {', '.join(answer['forbidden'])}")
        if target is not None:
            target.mkdir(parents=True, exist_ok=True)
            if answer["code"] == 0:
                for result in (DIAGNOSIS, IMPROVED):
                    shutil.copyfile(folder / OUTPUT / result, target / result)
            else:
                (target / FAILURE).write_text(f"exit code {answer['code']}\n{answer['printed']}", encoding="utf-8")
        return float(answer["seconds"])


class Worker:
    """The child process, which runs one command after the other."""

    def __init__(self, working_copy: Path) -> None:
        environment = {k: v for k, v in os.environ.items() if not k.startswith(("CAMID", "SNAKEMAKE"))}
        # -P: the folder in which it is started is not a place to import from.
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", __name__, str(working_copy)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            cwd=tempfile.gettempdir(),
            env={**environment, **ONE_THREAD_EACH, "MPLBACKEND": "Agg"},
        )

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.stdin.close()  # type: ignore[union-attr]
        self._process.stdout.close()  # type: ignore[union-attr]
        self._process.wait()

    def run(self, folder: Path, arguments: list[str]) -> dict[str, Any]:
        """Run a command in a folder: ``code``, ``seconds``, ``printed``, ``forbidden``."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps({"folder": str(folder), "arguments": arguments}) + "\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"the process that diagnoses died with exit code {self._process.wait()}")
        return dict(json.loads(line))


def serve(working_copy: str) -> None:
    """Run the commands that standard input asks for, one per line, and answer on standard output.

    Every opening of a file below the working copy, but of the package and of Python's own environment, is refused and
    reported. The hook (PEP 578) sees what Python opens; it is a guard against mistakes, not a prison.
    """
    import camid

    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # whatever is printed must not be taken for an answer
    allowed = [os.path.realpath(p) for p in (Path(camid.__file__).parent, sys.prefix, sys.base_prefix)]
    forbidden: list[str] = []

    def refuse(event: str, arguments: tuple[Any, ...]) -> None:
        if event != "open" or not isinstance(arguments[0], str | bytes | os.PathLike):
            return
        path = os.path.realpath(os.fsdecode(arguments[0]))
        if _below(path, working_copy) and not any(_below(path, place) for place in allowed):
            forbidden.append(path)
            raise ForbiddenReadError(f"{path} is concealed")

    sys.addaudithook(refuse)
    for line in sys.stdin:
        asked = json.loads(line)
        forbidden.clear()
        os.chdir(asked["folder"])
        answer = _run_command(asked["arguments"])
        os.chdir(tempfile.gettempdir())  # the folder is about to be removed
        answers.write(json.dumps({**answer, "forbidden": forbidden}) + "\n")
        answers.flush()


def _below(path: str, folder: str) -> bool:
    return path == folder or path.startswith(folder + os.sep)


def _run_command(arguments: list[str]) -> dict[str, Any]:
    """Exit code, run time and error output of the command line, run in this process."""
    import io
    import traceback
    from contextlib import redirect_stderr, redirect_stdout

    printed = io.StringIO()
    start = time.perf_counter()
    with redirect_stdout(io.StringIO()), redirect_stderr(printed):
        try:
            from camid.cli import main

            code = main(arguments)
        except Exception:  # a crash is a result, too: it counts against the tool
            printed.write(traceback.format_exc())
            code = 1
    return {"code": code, "seconds": time.perf_counter() - start, "printed": printed.getvalue()}


if __name__ == "__main__":
    serve(sys.argv[1])
