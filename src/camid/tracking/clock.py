"""What the time stamps and the pictures say about frames that are missing or copied."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# A step longer than this many periods is a gap.
GAP = 1.5
# Steps within this share of the period are regular, and this share of them makes the clip regular.
REGULAR_STEP, REGULAR_SHARE = 0.1, 0.9
# A frame that differs from the one before by less than this share of the usual difference, while the marker's step is
# below this share of its steps before and after, is a copy that a lossy codec has encoded again.
COPY_DIFFERENCE, COPY_STEP = 0.5, 0.25
# More consecutive copies are a pause of the marker.
MOST_COPIES = 3
# The motion is certain if it is this many standard deviations.
CERTAIN_MULTIPLE = 5.0


@dataclass(frozen=True)
class Clock:
    """Time stamps of a clip.

    Attributes
    ----------
    frames : int
    period : float
        Median step in seconds.
    effective_rate : float
        Frames per second over the whole clip: number of steps over the time that they take.
    regular : bool
        Whether nine steps of ten are within 10 % of the period. Otherwise no frame can be called missing.
    gaps : list of (float, int)
        Time stamp before a gap, and how many frames are missing there.
    """

    frames: int
    period: float
    effective_rate: float
    regular: bool
    gaps: list[tuple[float, int]]

    @property
    def missing(self) -> int:
        """Number of frames that are missing between the time stamps."""
        return sum(count for _, count in self.gaps)


def clock_of(times: Array) -> Clock:
    """Judge time stamps.

    Parameters
    ----------
    times : ndarray, shape (frames,)
        Seconds, increasing; two or more.
    """
    steps = np.diff(times)
    period = float(np.median(steps))
    regular = bool(np.mean(np.abs(steps - period) <= REGULAR_STEP * period) >= REGULAR_SHARE)
    gaps = []
    if regular:
        gaps = [(float(times[k]), round(float(steps[k]) / period) - 1) for k in np.flatnonzero(steps > GAP * period)]
    return Clock(len(times), period, float(len(steps) / (times[-1] - times[0])), regular, gaps)


def scatter(time: Array, values: Array, period: float) -> float:
    """Standard deviation of what changes from frame to frame, from the fourth differences of the positions.

    A smooth motion vanishes in them, which leaves noise of every origin, the codec's errors included, and any motion
    that is fast for the frame rate. NaN where no five consecutive rows are without a gap.

    Parameters
    ----------
    time, values : ndarray, shape (N,)
    period : float
        Seconds between two frames.
    """
    if len(time) < 5:
        return float("nan")
    whole = time[4:] - time[:-4] < (4.0 + GAP - 1.0) * period
    differences = np.abs(np.diff(values, 4))[whole]
    # 1 + 16 + 36 + 16 + 1 = 70, and the median of a normal variable's absolute value is 0.6745 standard deviations.
    return float(np.median(differences)) / (0.674490 * np.sqrt(70.0)) if differences.size else float("nan")


def repeated_frames(difference: Array, x: Array, y: Array, deviation: Array) -> NDArray[np.int64]:
    """Frames that are copies of the one before: 1 for a copy, 0 for others.

    Bit for bit, or at the level of the codec: nearly no pixel has changed, and the marker stays still where it moves
    in the neighbouring frames. A lossy codec also stores a scene at rest as copies; these also count.

    Parameters
    ----------
    difference : ndarray, shape (N,)
        Mean absolute difference of the whole picture from that of the frame before; NaN for the first.
    x, y, deviation : ndarray, shape (N,)
        Position of the marker and its standard deviation in px.
    """
    copies = np.asarray(difference == 0.0)
    if len(x) < 4:
        return copies.astype(np.int64)
    step = np.vstack(([0.0, 0.0], np.diff(np.column_stack((x, y)), axis=0)))  # step[k] leads to frame k
    length = np.hypot(*step.T)
    alike = np.append(False, difference[1:] < COPY_DIFFERENCE * np.nanmedian(difference))
    edges = np.flatnonzero(np.diff(np.concatenate(([0], alike.astype(int), [0]))))
    for first, end in edges.reshape(-1, 2):  # frames first … end - 1 look like the one before
        before, after = first - 1, end
        if end - first > MOST_COPIES or before < 1 or after >= len(x):
            continue
        about = min(length[before], length[after])
        # After a copy the motion goes on in the same direction; where the marker turns round it does not.
        if step[before] @ step[after] > 0.0 and about > CERTAIN_MULTIPLE * deviation[first]:
            copies[first:end] |= length[first:end] < COPY_STEP * about
    return copies.astype(np.int64)
