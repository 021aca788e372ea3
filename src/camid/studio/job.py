"""A command of camid in a process of its own: its progress, its warnings, its one line of error, and how to end it."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import camid
from camid.studio import progress

ERROR, WARNING = "camid: error: ", "camid: warning: "
# Of a line of output, in bytes: a summary in JSON is one text of many lines.
LONGEST_LINE = 1_000_000
# Seconds between asking and killing: compiled code listens at its end.
PATIENCE = 3.0
CANCELLED = "cancelled; no file is half-written"


@dataclass
class Job:
    """A command of camid, from its start to its end.

    Attributes
    ----------
    title : str
        What it does, for people.
    arguments : sequence of str
        Of ``python -m``.
    folder : Path
        Where it runs, so that messages name files without folders.
    step : str
        What it does now, in a sentence.
    warnings : list of str
    output : str
        What it printed.
    error : str or None
        The one line that says what is wrong.
    """

    title: str
    arguments: Sequence[str]
    folder: Path
    step: str = "starting"
    warnings: list[str] = field(default_factory=list)
    output: str = ""
    error: str | None = None
    _process: asyncio.subprocess.Process | None = None
    _cancelled: bool = False

    async def run(self, said: Callable[[], None] | None = None) -> bool:
        """Run to the end; whether it went well. ``said`` is called after each sentence of progress."""
        package = str(Path(camid.__file__).parent.parent)
        paths = [package, *filter(None, [os.environ.get("PYTHONPATH")])]
        changed = {
            "PYTHONPATH": os.pathsep.join(paths),
            progress.VARIABLE: progress.LINES,
            "MPLBACKEND": "agg",
            "PYTHONUTF8": "1",
        }
        self._process = await asyncio.create_subprocess_exec(
            sys.executable,
            "-P",  # the folder of uploaded files is no place to import from
            "-m",
            *self.arguments,
            cwd=self.folder,
            env={**os.environ, **changed},
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
            start_new_session=True,  # what it starts ends with it
            limit=LONGEST_LINE,
        )
        if self._cancelled:
            self.cancel()
        assert self._process.stdout is not None
        assert self._process.stderr is not None
        try:
            output, _ = await asyncio.gather(self._process.stdout.read(), self._listen(self._process.stderr, said))
            code = await self._process.wait()
        finally:
            # What the command started a moment before it ended may outlive it.
            if self._cancelled or self._process.returncode is None:
                self._end(signal.SIGKILL)
        self.output = output.decode("utf-8", errors="replace")
        if self._cancelled:
            self.error = CANCELLED
        elif code != 0 and self.error is None:
            self.error = f"{self.title} ended without an answer (exit code {code})"
        return self.error is None

    async def _listen(self, stream: asyncio.StreamReader, said: Callable[[], None] | None) -> None:
        """Sort what is written to the error stream by its first words."""
        while True:
            try:
                line = (await stream.readline()).decode("utf-8", errors="replace")
            except ValueError:  # longer than any sentence
                continue
            if not line:
                return
            text = line.rstrip("\n")
            if text.startswith(ERROR):
                self.error = text.removeprefix(ERROR)
            elif text.startswith(WARNING):
                self.warnings.append(text.removeprefix(WARNING))
            elif text.startswith(progress.PREFIX):
                self.step = text.removeprefix(progress.PREFIX)
                if said is not None:
                    said()

    def cancel(self) -> None:
        """End it as Ctrl-C does, so that nothing is left behind; what does not listen is killed."""
        self._cancelled = True
        self._end(signal.SIGINT)
        asyncio.get_running_loop().call_later(PATIENCE, self._kill)

    def _kill(self) -> None:
        if self._process is not None and self._process.returncode is None:
            self._end(signal.SIGKILL)

    def _end(self, sign: signal.Signals) -> None:
        """Send a signal to the command and to what it started."""
        if self._process is not None:
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self._process.pid, sign)
