"""Work that a copy of this process does beside it: it has loaded all that this one has."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeVar

Result = TypeVar("Result")
Given = TypeVar("Given")


@contextmanager
def begun_in_a_copy(work: Callable[[Given], Result], given: Given) -> Iterator[Callable[[], Result]]:
    """Begin work in a copy of this process; what is yielded waits for its result.

    Where processes cannot be copied, or the copy ends without a result, the work is done here when it is asked for.

    Parameters
    ----------
    work : callable
        A function of a module.
    given : object
        What it is called with; it and the result are pickled.
    """
    if "fork" not in multiprocessing.get_all_start_methods():
        yield lambda: work(given)
        return
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("fork")) as copies:
        try:
            begun = copies.submit(work, given)
        except OSError:  # no right to start a process
            yield lambda: work(given)
            return

        def result() -> Result:
            try:
                return begun.result()
            except BrokenProcessPool:
                return work(given)

        yield result
