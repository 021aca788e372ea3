"""The rows of two tables on one grid: that of the drive, whose input is held between its samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.recording.nature import nature_of

Array = NDArray[np.float64]

# Frames are taken one by one where their times differ from a regular grid by less than this, in periods, and where they
# slip by at most so many rows over the recording.
UNEVEN = 0.02
MOST_SLIPPED = 2.0
# Frames that are farther apart, in periods, have a gap between them, over which nothing is interpolated.
LARGEST_STEP = 1.5
# Share of a frame by which rows may be shorter.
SLACK = 0.01
FEWEST_ROWS = 40
# Of the times that are written, in seconds: below the jitter of any clock.
DECIMALS = 9
# Share of the power of a held signal that changes within a row, above which it is said.
SAID = 1e-3


@dataclass(frozen=True)
class Rows:
    """Both tables on one grid.

    A frame that is delivered at D stands in the row at t where D = start + (1 + skew) (t − start) − latency.

    Attributes
    ----------
    columns : dict of str to ndarray
        The time of the drive first; NaN where there is no frame.
    period, start : float
        Seconds; the time of the first row.
    latency, skew : float
        Seconds from the time stamp of a frame to its row, and what the rate of the frames adds to it.
    remarks : tuple of str
        What was done.
    """

    columns: dict[str, Array]
    period: float
    start: float
    latency: float
    skew: float
    remarks: tuple[str, ...]


@dataclass(frozen=True)
class DriveRows:
    """The drive's table on a grid with about the period of the frames.

    Attributes
    ----------
    time : ndarray, shape (K,)
        Of the drive, in seconds.
    period : float
        Seconds.
    columns : dict of str to ndarray of shape (K,)
    remarks : tuple of str
        What was done.
    """

    time: Array
    period: float
    columns: dict[str, Array]
    remarks: tuple[str, ...]


def drive_rows(time: Array, drive: Mapping[str, Array], frame: float) -> DriveRows:
    """Rows that start with samples of the drive, so that a held input is held in them.

    Parameters
    ----------
    time : ndarray, shape (M,)
    drive : dict of str to ndarray of shape (M,)
    frame : float
        Seconds between frames on the clock of the drive.
    """
    # The median of steps whose digits are rounded would be off by milliseconds at the end.
    step = float(time[-1] - time[0]) / (len(time) - 1)
    # No shorter than a frame, which an exposure may take the whole of.
    per_row = max(int(np.ceil(frame / step - SLACK)), 1)
    parts = max(int(step / frame + SLACK), 1) if per_row == 1 else 1
    period = step * per_row / parts
    first = time[_phase(time, drive, per_row) if per_row > 1 else 0]
    grid = first + period * np.arange(int((time[-1] - first) / period + 1e-9) + 1)
    remarks: list[str] = []
    columns = {name: _of_drive(name, time, values, grid, period, remarks) for name, values in drive.items()}
    return DriveRows(grid, period, columns, tuple(remarks))


def joined_rows(
    drive_time: Array,
    drive: Mapping[str, Array],
    frames: Array,
    clip: Mapping[str, Array],
    time_column: str,
) -> Rows:
    """Rows of the drive, with the frames that belong to them.

    Frames that come nearly as regularly as the rows are taken one by one, and their other rate is a skew: what is
    interpolated between them has errors that go with the time where their phase does, and noise that is not white.

    Parameters
    ----------
    drive_time : ndarray, shape (M,)
    drive : dict of str to ndarray of shape (M,)
    frames : ndarray, shape (N,)
        Times of the frames on the clock of the drive.
    clip : dict of str to ndarray of shape (N,)
    time_column : str
        What the time is called.

    Raises
    ------
    ValueError
        If the two overlap in too few rows.
    """
    frame = float(np.median(np.diff(frames)))
    frame = float(frames[-1] - frames[0]) / max(round(float(frames[-1] - frames[0]) / frame), 1)
    driven = drive_rows(drive_time, drive, frame)
    grid, period, count = driven.time, driven.period, len(driven.time)
    columns = {time_column: np.round(grid, DECIMALS), **driven.columns}
    remarks = list(driven.remarks)
    numbers = np.round((frames - frames[0]) / frame).astype(int)
    uneven = float(np.max(np.abs((frames - frames[0]) / frame - numbers)))
    slip = (frame / period - 1.0) * float(numbers[-1])
    one_by_one = uneven <= UNEVEN and abs(slip) <= MOST_SLIPPED
    if one_by_one:
        # Half a period at least after they were delivered, so that a latency that is fitted is free.
        first = int(np.ceil((frames[0] - grid[0]) / period + max(slip, 0.0) + 0.5 - 1e-9))
        inside = (first + numbers >= 0) & (first + numbers < count)
        for name, values in clip.items():
            columns[name] = np.full(count, np.nan)
            columns[name][first + numbers[inside]] = values[inside]
    else:
        for name, values in clip.items():
            columns[name] = _spline(frames, values, grid - 0.5 * period, frame)
        remarks.append("the columns of the clip are interpolated to the rows of the drive (cubic)")
    measured: NDArray[np.bool_] = np.any(np.isfinite([columns[name] for name in clip]), axis=0)
    if measured.sum() < FEWEST_ROWS:
        raise ValueError(f"the two tables overlap in {measured.sum()} rows; {FEWEST_ROWS} are needed")
    begin = int(np.argmax(measured))
    kept = slice(begin, count - int(np.argmax(measured[::-1])))
    start, latency, skew = float(grid[begin]), 0.5 * period, 0.0
    if one_by_one:
        skew = frame / period - 1.0
        latency = start - (float(frames[0]) + (begin - first) * frame)
    columns = {name: values[kept] for name, values in columns.items()}
    blanks = int(np.count_nonzero(~measured[kept]))
    if blanks:
        remarks.append(f"{blanks} rows have no frame and stay blank: say missing: leave-out under recording")
    return Rows(columns, period, start, latency, skew, tuple(remarks))


def _phase(time: Array, drive: Mapping[str, Array], per_row: int) -> int:
    """Sample of the drive at which a row starts, so that held signals change between rows and not within them."""
    changes = np.zeros(len(time))
    for values in drive.values():
        nature = nature_of(values)
        if nature is not None and nature.kind == "held":
            changes[1:] += (np.diff(values) / (float(np.std(values)) or 1.0)) ** 2
    by_phase = [float(np.sum(changes[phase::per_row])) for phase in range(per_row)]
    return int(np.argmax(by_phase))


def _of_drive(name: str, time: Array, values: Array, grid: Array, period: float, remarks: list[str]) -> Array:
    """A signal of the drive on the grid: the mean of what is held, or the value of what is not."""
    nature = nature_of(values)
    if nature is None or nature.kind != "held":
        return np.asarray(np.interp(grid, time, values))
    step = float(time[-1] - time[0]) / (len(time) - 1)
    edges = np.append(time, time[-1] + step)
    # Up to the rounding of the times, a row that starts with a sample holds nothing of the one before.
    integral = np.concatenate([[0.0], np.cumsum(values * np.diff(edges))])
    ends = np.interp(np.append(grid, grid[-1] + period), edges, integral)
    held = np.diff(ends) / np.minimum(period, np.maximum(edges[-1] - grid, 1e-12))
    within = grid + 0.5 * min(step, period)
    rounded = values[np.clip(np.searchsorted(time, within, side="right") - 1, 0, len(values) - 1)]
    same = np.abs(held - rounded) <= 1e-6 * (float(np.ptp(values)) or 1.0)
    lost = float(np.mean((held - rounded)[~same] ** 2)) * float(np.mean(~same)) if np.any(~same) else 0.0
    if lost > SAID * float(np.var(values)):
        remarks.append(f"'{name}' changes within rows and is averaged over each of them")
    return np.asarray(np.where(same, rounded, held))


def _known(frames: Array, times: Array, frame: float) -> NDArray[np.bool_]:
    """Whether times lie between frames that follow each other."""
    after = np.clip(np.searchsorted(frames, times), 1, len(frames) - 1)
    inside = (times >= frames[0]) & (times <= frames[-1])
    return np.asarray(inside & (frames[after] - frames[after - 1] <= LARGEST_STEP * frame))


def _spline(frames: Array, values: Array, times: Array, frame: float) -> Array:
    """Values at times by a cubic spline through what is known; NaN where nothing is near."""
    from scipy.interpolate import CubicSpline

    good = np.isfinite(values)
    if np.count_nonzero(good) < FEWEST_ROWS:
        return np.full(len(times), np.nan)
    known = _known(frames[good], times, frame)
    return np.asarray(np.where(known, CubicSpline(frames[good], values[good])(times), np.nan))
