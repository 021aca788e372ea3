"""Draw the page in a process of its own: it loads the drawing library while the diagnosis is still at work.

Loading takes longer than most diagnoses, and one interpreter does one thing at a time. The process is started without
``multiprocessing``, which would import the caller's main module again.
"""

from __future__ import annotations

import gc
import importlib
import os
import pickle
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import IO, TYPE_CHECKING

import camid
from camid.side_by_side import cores

# It is started before anything that takes long to load.
if TYPE_CHECKING:
    from camid.diagnosis.diagnosis import Diagnosis


class PageDrawnBeside:
    """The page of a diagnosis that is not made yet.

    Where no other process can be started, or it ends without a page, the page is drawn in this one.

    Parameters
    ----------
    modules : str
        Whose objects the diagnosis will hold, to be loaded beforehand.
    """

    def __init__(self, *modules: str) -> None:
        self._modules = modules
        self._process: subprocess.Popen[bytes] | None = None
        self._diagnosis: Diagnosis | None = None

    def __enter__(self) -> PageDrawnBeside:
        if cores() < 2:
            return self
        package = str(Path(camid.__file__).parent.parent)
        paths = [package, *filter(None, [os.environ.get("PYTHONPATH")])]
        with suppress(OSError, ValueError):  # no right to start a process, or an interpreter without a name
            self._process = subprocess.Popen(
                # -P: the folder that the user stands in is no place to import from.
                [sys.executable, "-P", "-m", __name__, *self._modules],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            )
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.communicate()

    def begin(self, diagnosis: Diagnosis) -> None:
        """Begin to draw; :meth:`text` waits for the page."""
        self._diagnosis = diagnosis
        if self._process is not None:
            with suppress(OSError):
                pickle.dump(diagnosis, _pipe(self._process.stdin), pickle.HIGHEST_PROTOCOL)
                _pipe(self._process.stdin).flush()

    def text(self) -> str:
        """The page as text.

        Raises
        ------
        ValueError
            If no diagnosis was given to :meth:`begin`.
        """
        if self._diagnosis is None:
            raise ValueError("there is no diagnosis to draw yet")
        if self._process is not None:
            page = _pipe(self._process.stdout).read()
            if page and self._process.wait() == 0:
                return page.decode("utf-8", errors="surrogatepass")
        from camid.diagnosis.report.page import render

        return render(self._diagnosis)


def _pipe(stream: IO[bytes] | None) -> IO[bytes]:
    assert stream is not None
    return stream


def serve() -> None:
    """Load what drawing needs, wait for a diagnosis on standard input, and write its page to standard output."""
    from camid.diagnosis.report.page import load, render

    load()
    for module in sys.argv[1:]:
        importlib.import_module(module)
    page = render(pickle.load(sys.stdin.buffer), shared=True)
    sys.stdout.buffer.write(page.encode("utf-8", errors="surrogatepass"))
    gc.freeze()  # the page has come when this process has ended: it need not look through what it leaves behind


if __name__ == "__main__":
    serve()
