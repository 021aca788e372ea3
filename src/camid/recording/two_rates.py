"""Recordings in which the frames have times of their own, between the samples of the input."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.input_log import InputLog
from camid.errors import InputError
from camid.recording.time_grid import LARGEST_STEP

Array = NDArray[np.float64]

# Steps of the frames back to where the log begins, above which it is another recording that it begins with.
MOST_ROWS_BEFORE = 1_000_000
# Frames that are delivered up to this many steps after the last sample of the log still saw what that holds.
AFTER_LOG = 1.0


@dataclass(frozen=True)
class FramesInLog:
    """What of the rows of a table holds a frame.

    Attributes
    ----------
    rows : ndarray of int, shape (N,)
        Rows with a frame that the log of the input covers.
    time : ndarray, shape (N,)
        Seconds: when those frames were delivered.
    notes : tuple of str
        What was left out.
    """

    rows: NDArray[np.intp]
    time: Array
    notes: tuple[str, ...]


def frames_in_log(frame_time: Array, time: Array, name: str, column: str) -> FramesInLog:
    """The frames whose times, shape (M,), are numbers, and which the log with these times, (M,), covers.

    Raises
    ------
    InputError
        If there are none.
    """
    given = np.flatnonzero(np.isfinite(frame_time))
    last = float(time[-1]) + AFTER_LOG * float(np.median(np.diff(time)))
    inside = given[(frame_time[given] >= time[0]) & (frame_time[given] <= last)]
    if not len(inside):
        raise InputError(
            f"none of the {len(given)} frames lies within the log of the input, from {time[0]:.6g} s to {last:.6g} s",
            where=f"{name}, column '{column}'",
            hint="both need the same clock: camid join brings them onto one",
        )
    lost = len(given) - len(inside)
    notes = (f"{lost} frames before or after the log of the input are left out",) if lost else ()
    return FramesInLog(inside, frame_time[inside], notes)


def input_logs(
    time: Array, values: Mapping[str, Array], holds: Mapping[str, str], *, gaps: str, where: Callable[[int], str]
) -> dict[str, InputLog]:
    """Inputs at the times of their own rows.

    Parameters
    ----------
    time : ndarray, shape (M,)
        Seconds, growing.
    values : dict of str to ndarray of shape (M,)
    holds : dict of str to {"zoh", "foh", "band-limited"}
    gaps : {"refuse", "hold"}
    where : callable
        Names the place of a row.

    Raises
    ------
    InputError
        If rows are missing and what the input did then is not said.
    """
    steps = np.diff(time)
    far = int(np.argmax(steps))
    typical = float(np.median(steps))
    if steps[far] > LARGEST_STEP * typical and gaps != "hold":
        raise InputError(
            f"a step of {steps[far]:.6g} s where the others have {typical:.6g} s: "
            "rows seem to be missing, and what the input did is unknown",
            where=where(far + 1),
            hint="cut the recording there, or say gaps: hold under recording if the input was held",
        )
    return {name: InputLog(time, values[name], hold) for name, hold in holds.items()}


def rows_before(first: float, begin: float, period: float) -> int:
    """Frames that would have been delivered between the start of a log and the first frame."""
    return min(max(int(np.ceil((first - begin) / period - 1e-9)), 0), MOST_ROWS_BEFORE)


def sum_of_logs(logs: Mapping[str, InputLog], columns: list[str]) -> InputLog:
    """The sum of inputs that were logged at the same times."""
    first = logs[columns[0]]
    return replace(first, values=np.sum([logs[c].values for c in columns], axis=0))
