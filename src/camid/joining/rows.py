"""The rows of two tables as one: the drive's samples as they were logged, and each frame in the row that it came in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.recording.nature import nature_of

Array = NDArray[np.float64]

FRAME_TIME = "frame_time"
# Of the times that are written, in seconds: below the jitter of any clock.
DECIMALS = 9
FEWEST_FRAMES = 40
# Parts that a sample of the drive is divided into at most, so that each row holds one frame.
MOST_PARTS = 64


@dataclass(frozen=True)
class JoinedRows:
    """Both tables in one.

    Attributes
    ----------
    columns : dict of str to ndarray, shape (K,)
        The time of the drive first, then its columns, the times of the frames and their columns; NaN where there is no
        frame.
    period : float
        Seconds between rows.
    frame_time : str
        Name of the column with the times of the frames.
    frames : int
        How many there are.
    remarks : tuple of str
        What was done.
    """

    columns: dict[str, Array]
    period: float
    frame_time: str
    frames: int
    remarks: tuple[str, ...]


def joined_rows(
    drive_time: Array,
    drive: Mapping[str, Array],
    frames: Array,
    clip: Mapping[str, Array],
    time_column: str,
) -> JoinedRows:
    """Rows of the drive, with the frames that were delivered in them.

    Neither is interpolated: a motion between frames and an input within a frame are those of the plant, which a fit
    knows and a table does not. Where several frames came within a sample of the drive, that is divided.

    Parameters
    ----------
    drive_time : ndarray, shape (M,)
    drive : dict of str to ndarray of shape (M,)
    frames : ndarray, shape (N,)
        When frames are delivered on the clock of the drive.
    clip : dict of str to ndarray of shape (N,)
    time_column : str
        What the time is called.

    Raises
    ------
    ValueError
        If the two overlap in too few frames, or frames follow each other far closer than samples.
    """
    seen = np.any(np.isfinite([*clip.values()]), axis=0)
    step = float(drive_time[-1] - drive_time[0]) / (len(drive_time) - 1)
    seen &= (frames >= drive_time[0]) & (frames <= drive_time[-1] + step)
    if np.count_nonzero(seen) < FEWEST_FRAMES:
        raise ValueError(f"the two tables overlap in {np.count_nonzero(seen)} frames; {FEWEST_FRAMES} are needed")
    delivered = frames[seen]
    parts, rows = _one_to_a_row(drive_time, delivered)
    time = _divided(drive_time, parts)
    name = FRAME_TIME
    while name in drive or name in clip or name == time_column:
        name += "_clip"
    columns = {time_column: np.round(time, DECIMALS)}
    for column, values in drive.items():
        nature = nature_of(values)
        held = nature is not None and nature.kind == "held"
        columns[column] = np.repeat(values, parts) if held else _divided(values, parts)
    for column, values in {name: np.round(delivered, DECIMALS), **{c: v[seen] for c, v in clip.items()}}.items():
        columns[column] = np.full(len(time), np.nan)
        columns[column][rows] = values
    remarks = (f"each sample of the drive takes {parts} rows, so that a row holds one frame",) if parts > 1 else ()
    return JoinedRows(columns, step / parts, name, len(rows), remarks)


def _one_to_a_row(drive_time: Array, delivered: Array) -> tuple[int, NDArray[np.intp]]:
    """Rows that each sample is divided into, and the row of each frame."""
    for parts in range(1, MOST_PARTS + 1):
        rows = np.searchsorted(_divided(drive_time, parts), delivered, side="right") - 1
        if len(np.unique(rows)) == len(rows):
            return parts, rows
    raise ValueError(f"more than {MOST_PARTS} frames would belong to one sample of the drive")


def _divided(values: Array, parts: int) -> Array:
    """Values on straight lines between the samples, of each the first of ``parts``; shape (parts M,)."""
    if parts == 1:
        return values
    following = np.append(values[1:], 2.0 * values[-1] - values[-2])
    return np.asarray((values[:, None] + (following - values)[:, None] * (np.arange(parts) / parts)).ravel())
