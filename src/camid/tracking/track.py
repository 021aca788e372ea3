"""The whole way from a video to a recording."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from camid.errors import InputError, need
from camid.tracking.clock import clock_of, repeated_frames
from camid.tracking.follow import Follower, Position, nowhere
from camid.tracking.options import PIXELS, Options
from camid.tracking.picture import Image, Picture
from camid.tracking.result import Track
from camid.writing import check_writable

if TYPE_CHECKING:
    import pandas as pd

    from camid.tracking.video import Source

FEWEST_ROWS = 3
# Frames between two messages of progress.
EVERY = 25


def track_video(
    path: Path, options: Options, *, preview: Path | None = None, progress: Callable[[str], None] | None = None
) -> Track:
    """Follow the marker through a video and draw the preview; see :func:`camid.track`."""
    need("tracking a video", "video")
    if preview is not None:
        check_writable(preview)
    result = track_marker(path, options, progress)
    if preview is not None:
        from camid.tracking.preview import save_preview

        save_preview(result, options, preview, progress)
    return result


def track_marker(path: Path, options: Options, progress: Callable[[str], None] | None = None) -> Track:
    """Follow the marker through a video."""
    source = options.source(path)
    try:
        appearance = options.appearance(source, progress)
        follower: Follower | None = None
        positions: list[Position] = []
        times: list[float] = []
        without: list[tuple[int, float]] = []
        differences: list[float] = []
        before: Picture | None = None
        shape = (0, 0)
        total = f" of {source.expected}" if source.expected else ""
        for frame in source.frames(options.start, options.end):
            picture = frame.picture
            if follower is None:
                shape = picture.shape
                region = options.first_region(shape, source.name)
                follower = Follower(appearance, options.method, source.name, region, options.longest_gap)
            elif picture.shape != shape:
                raise InputError(
                    f"the image is {picture.shape[1]} × {picture.shape[0]} px, {shape[1]} × {shape[0]} px before",
                    where=f"{source.name}, t = {frame.time:.6g} s (frame {frame.number})",
                    hint=f"end the clip there with --end {times[-1]:.6g}",
                )
            position = follower.step(frame)
            times.append(frame.time)
            if position is None:
                without.append((frame.number, frame.time))
            else:
                positions.append(position)
                differences.append(_difference(picture, before))
            before = picture
            if progress is not None and frame.number % EVERY == 0:
                progress(f"following {appearance.sentence}, frame {frame.number}{total}")
    except InputError as error:
        if error.where is None:
            raise InputError(error.problem, where=source.name, hint=error.hint) from None
        raise
    if follower is None:
        raise _no_frames(source, options)
    if not positions:
        raise nowhere(appearance, source.name, len(times))
    if len(positions) < FEWEST_ROWS:
        raise InputError(
            f"{len(positions)} frames with a marker", where=source.name, hint=f"a recording needs {FEWEST_ROWS}"
        )
    return Track(
        table=_table(positions, differences, options),
        positions=positions,
        source=source.name,
        marker=follower.appearance.sentence,
        method=options.method,
        unit=options.unit if options.scale is not None and options.unit is not None else PIXELS,
        shape=shape,
        clock=clock_of(np.array(times)),
        without_marker=without,
        notes=source.notes,
    )


def _difference(picture: Picture, before: Picture | None) -> float:
    """Mean absolute difference from the frame before, in grey levels."""
    import cv2

    if before is None:
        return float("nan")
    new, old = (_whole(p.first_plane) for p in (picture, before))
    return float(cv2.norm(new, old, cv2.NORM_L1)) / new.size


def _whole(plane: Image) -> Image:
    """A plane that OpenCV takes: one channel of a packed picture is copied."""
    return plane if plane.strides[1] == plane.itemsize else np.ascontiguousarray(plane)


def _no_frames(source: Source, options: Options) -> InputError:
    """The error for a clip, or a part of it, without frames; it says from when to when the clip lasts."""
    if options.start is None and options.end is None:
        return InputError("there are no frames", where=source.name, hint="check the file")
    all_times = [frame.time for frame in source.frames()]
    lasts = f"the clip lasts from {all_times[0]:.6g} s to {all_times[-1]:.6g} s" if all_times else "check the file"
    return InputError("there are no frames between --start and --end", where=source.name, hint=lasts)


def _table(positions: list[Position], differences: list[float], options: Options) -> pd.DataFrame:
    import pandas as pd

    grey, gradient = (np.array([getattr(p, name) for p in positions]) for name in ("grey_level", "gradient"))
    deviation = np.array([p.deviation for p in positions])
    chosen, other, name = (
        (gradient, grey, "grey_level") if options.method == "gradient" else (grey, gradient, "gradient")
    )
    mass = np.array([p.mass for p in positions])
    size = mass / np.median(mass)
    quality = np.min(
        [[p.contrast for p in positions], [p.alone for p in positions], np.minimum(size, 1.0 / size)], axis=0
    )
    repeated = repeated_frames(np.array(differences), chosen[:, 0], chosen[:, 1], np.hypot(*deviation.T))
    scale = np.array([1.0, -1.0 if options.upwards else 1.0]) * (options.scale or 1.0)
    chosen, other = ((p - np.array(options.origin)) * scale for p in (chosen, other))
    return pd.DataFrame(
        {
            "t": [p.time for p in positions],
            "x": chosen[:, 0],
            "y": chosen[:, 1],
            "x_std": deviation[:, 0] * abs(scale[0]),
            "y_std": deviation[:, 1] * abs(scale[1]),
            f"x_{name}": other[:, 0],
            f"y_{name}": other[:, 1],
            "quality": np.clip(quality, 0.0, 1.0),
            "repeated": repeated,
        }
    )
