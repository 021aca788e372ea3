"""Image formation and measurement with a rolling shutter: every row of the sensor has an exposure of its own.

A global shutter is that of :mod:`camid.images.forming`. Here row i is exposed over [t + iλ, t + iλ + τ] with the
line time λ, the time between the readouts of neighbouring rows. The subject is that of E. Laroche's follow-up paper,
"Dynamical models for position measurement with global shutter and rolling shutter cameras"; the equations are ours.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.images.forming import FrameFormat, Marker, Path, expose

Array = NDArray[np.float64]

# Instants of a row's exposure at which the path is looked at to see whether the marker comes near that row.
LOOKS = 62
# A fixed-point iteration shrinks the error by the rows that the marker moves in a line time; at 0.9 rows this many
# iterations reach rounding.
MOST_ITERATIONS = 400


def expose_rolling(
    path: Path, start: float, exposure: float, line_time: float, marker: Marker, frame: FrameFormat
) -> Array:
    """Form one image of which every row has its own exposure, before quantisation.

    Parameters
    ----------
    path : callable
        Times in s, shape (n,), to the position of the marker's centre, shape (n, 2), x and y in px; as in
        :func:`camid.images.forming.expose`.
    start, exposure : float
        Time at which the exposure of the row 0 begins and the duration of every row's exposure, in s.
    line_time : float
        How much later each row begins than the one above it, in s; below zero if the sensor is read from the bottom, 0
        for a global shutter.
    marker, frame : Marker, FrameFormat
        The disk, and the size and background of the image.

    Returns
    -------
    ndarray of float64, shape (height, width), or (height, width, 3) for a marker with three colour components
        Grey levels, not rounded; in error by less than 1e-3 of the intensity.

    Raises
    ------
    ValueError
        If the line time is not finite, the exposure is not positive, or the path gives another shape or a value that
        is not finite.
    """
    if not np.isfinite(line_time):
        raise ValueError(f"a line time of {line_time} s; it must be finite")
    image = np.full((frame.height, frame.width, *np.shape(marker.intensity)), frame.background, dtype=float)
    strip = FrameFormat(1, frame.width, frame.background)
    starts = start + line_time * np.arange(frame.height, dtype=float)
    for row in _rows_near(path, starts, exposure, 0.5 * marker.diameter):
        image[row] = expose(_seen_from(path, row), starts[row], exposure, marker, strip)[0]
    return image


def _seen_from(path: Path, row: int) -> Path:
    """The path in a frame whose row 0 is the given row."""
    return lambda time: path(time) - np.array([0.0, float(row)])


def _rows_near(path: Path, starts: Array, exposure: float, radius: float) -> list[int]:
    """Numbers of the rows that the marker may touch in their exposure."""
    times = np.add.outer(starts, exposure * np.linspace(0.0, 1.0, LOOKS))
    heights = np.asarray(path(times.ravel()), dtype=float)
    if heights.shape != (times.size, 2):
        return list(range(starts.size))  # `expose` says what is wrong with it
    heights = heights[:, 1].reshape(times.shape)
    reach = radius + 1.0 + np.abs(np.diff(heights, axis=1)).max(axis=1)
    rows = np.arange(starts.size)
    # Not a number is near, too.
    far = (heights.min(axis=1) > rows + reach) | (heights.max(axis=1) < rows - reach)
    return [int(row) for row in rows[~far]]


def time_in_row(path: Path, start: float, line_time: float) -> float:
    """Time t at which the marker's centre lies in the row whose exposure begins then: t = start + λ y(t).

    Parameters
    ----------
    path : callable
        Times in s to positions x, y in px.
    start, line_time : float
        Start of the exposure of row 0, and λ, in s.

    Returns
    -------
    float
        Seconds.

    Raises
    ------
    ValueError
        If the fixed-point iteration does not settle: the marker is about as fast as the shutter.
    """
    time = start
    for _ in range(MOST_ITERATIONS):
        following = start + line_time * float(path(np.array([time]))[0, 1])
        if abs(following - time) <= 1e-15 + 1e-12 * abs(line_time):
            return following
        time = following
    raise ValueError(f"the marker moves about one row in a line time of {line_time} s: no single time of its row")
