"""``camid.track``: positions of a marker in a video."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import os

    from camid.tracking.result import Track


def track(
    video: str | os.PathLike[str],
    *,
    colour: str | None = None,
    bright: bool = False,
    dark: bool = False,
    region: tuple[int, int, int, int] | None = None,
    method: str = "grey-level",
    scale: float | None = None,
    unit: str | None = None,
    origin: tuple[float, float] = (0.0, 0.0),
    upwards: bool = False,
    frame_rate: float | None = None,
    start: float | None = None,
    end: float | None = None,
    longest_gap: int = 30,
    allow_truncated: bool = False,
    threads: int = 1,
    preview: str | os.PathLike[str] | None = None,
    progress: Callable[[str], None] | None = None,
) -> Track:
    """Measure the positions of a marker in a video.

    Parameters
    ----------
    video : path
        A file that FFmpeg decodes, or a folder of PNG images with a number in their names.
    colour : str, optional
        The marker is of this hue: a CSS name or ``#rrggbb``.
    bright, dark : bool
        It is the brightest or the darkest thing. Without a choice it is what moves.
    region : (int, int, int, int), optional
        x, y of the upper left corner, width and height in px: where the marker is in the first frame.
    method : {"grey-level", "gradient"}
        Whose position ``x`` and ``y`` are. The grey-level centroid is the mean of the position over the exposure,
        which is what the camera of a simulation means; the gradient centroid is the paper's.
    scale : float, optional
        Units of length per pixel; with ``unit``.
    unit : str, optional
        Of length, e.g. ``m``.
    origin : (float, float)
        x, y in px of the point that becomes 0, 0; the centre of the upper left pixel by default.
    upwards : bool
        Whether y points up; in the image it points down.
    frame_rate : float, optional
        Frames per second, for what has no time stamps.
    start, end : float, optional
        Seconds: which part of the clip is used.
    longest_gap : int
        Consecutive frames that may be without the marker.
    allow_truncated : bool
        Take what can be read of a file that ends in the middle.
    threads : int
        Threads that decode.
    preview : path, optional
        Where a picture of the result goes (PNG).
    progress : callable, optional
        Called with a sentence about the current step.

    Returns
    -------
    Track
        ``table`` is the recording.

    Raises
    ------
    InputError
        If the options contradict each other, the video cannot be read, or the marker is nowhere, one of several,
        lost, or leaves the image.
    """
    from pathlib import Path

    from camid.tracking.options import Options
    from camid.tracking.track import track_video

    options = Options(
        colour=colour,
        bright=bright,
        dark=dark,
        region=region,
        method=method,
        scale=scale,
        unit=unit,
        origin=origin,
        upwards=upwards,
        frame_rate=frame_rate,
        start=start,
        end=end,
        longest_gap=longest_gap,
        allow_truncated=allow_truncated,
        threads=threads,
    )
    return track_video(Path(video), options, preview=None if preview is None else Path(preview), progress=progress)
