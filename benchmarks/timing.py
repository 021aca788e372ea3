"""Timing of calls whose own printing must not reach the screen."""

from __future__ import annotations

import os
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

import numpy as np

Result = TypeVar("Result")


@contextmanager
def silence() -> Iterator[None]:
    """Send standard output, also that of compiled code, to nowhere, and leave out warnings."""
    sys.stdout.flush()
    kept = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            yield
            sys.stdout.flush()
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


def timed(call: Callable[[], Result]) -> tuple[Result, float]:
    """Result of a call and its wall time in seconds."""
    start = time.perf_counter()
    result = call()
    return result, time.perf_counter() - start


def alternate(calls: dict[str, Callable[[int], object]], rounds: int) -> dict[str, float]:
    """Median time in seconds of each call; all are called once per round, after a round that is not counted.

    The order rotates from round to round, so that no call always finds the data of the round in no cache yet.

    Parameters
    ----------
    calls : dict of callable
        Each takes the number of the round, from 0.
    rounds : int
        1 or more.
    """
    times: dict[str, list[float]] = {name: [] for name in calls}
    names = list(calls)
    for k in range(-1, rounds):
        first = k % len(names)
        for name in names[first:] + names[:first]:
            call = calls[name]
            start = time.perf_counter()
            call(max(k, 0))
            if k >= 0:
                times[name].append(time.perf_counter() - start)
    return {name: float(np.median(durations)) for name, durations in times.items()}
