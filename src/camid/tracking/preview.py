"""One picture by which a person sees whether the tracking is right."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.tracking.follow import Position
from camid.tracking.options import Options
from camid.tracking.picture import Picture
from camid.tracking.result import Track
from camid.writing import write_whole

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

FRAMES = 4
WIDTH = 10.0  # inches
MARGIN = 1.1  # inches that titles and labels take, beside the frames and the panels
PANEL = 1.7  # inches, height of x(t) and of y(t)
SMALL_PANEL = 0.55  # height of the standard deviations' panel beside the others'


def save_preview(
    track: Track, options: Options, path: str | os.PathLike[str], progress: Callable[[str], None] | None = None
) -> None:
    """Draw some frames with path, region and marker, and x(t) and y(t) with their standard deviations.

    The clip is decoded once more, up to the last frame that is shown.

    Parameters
    ----------
    track : Track
    options : Options
        With which it was made.
    path : path
        PNG.
    """
    if progress is not None:
        progress("drawing the preview")
    rows = sorted({round(k) for k in np.linspace(0, len(track.positions) - 1, FRAMES)})
    images = _images(track, options, [track.positions[k].frame for k in rows])

    from matplotlib import pyplot as plt

    from camid import plotting as style

    style.apply()
    plt.rcParams.update({"font.size": 9.0, "axes.titlesize": 9.0, "axes.labelsize": 9.0})
    height = WIDTH / len(rows) * track.shape[0] / track.shape[1]
    courses = PANEL * (2.0 + SMALL_PANEL)
    figure = plt.figure(figsize=(WIDTH, height + courses + MARGIN))
    upper, lower = np.asarray(figure.subfigures(2, 1, height_ratios=[height + 0.45, courses + MARGIN - 0.45]))
    names = "abcdefgh"[: len(rows)]
    for axes, row, image, name in zip(np.ravel(upper.subplots(1, len(rows))), rows, images, names, strict=True):
        _draw_frame(axes, track, image, track.positions[row], name)
    panels = lower.subplots(3, 1, sharex=True, height_ratios=[1.0, 1.0, SMALL_PANEL])
    for axes, column, colour in zip(panels[:2], "xy", (style.BLUE, style.VERMILION), strict=True):
        _draw_course(axes, track, column, colour)
        for row, name in zip(rows, names, strict=True):
            time = track.table["t"].iloc[row]
            axes.axvline(time, color=style.GREY, linewidth=0.6, linestyle=":")
            if column == "x":
                axes.annotate(
                    name,
                    (time, 1.0),
                    (0, 2),
                    xycoords=("data", "axes fraction"),
                    textcoords="offset points",
                    ha="center",
                )
    _draw_deviations(panels[2], track, (style.BLUE, style.VERMILION))
    panels[-1].set_xlabel("time in s")
    lower.align_ylabels(panels)
    try:
        write_whole(
            path, lambda temporary: figure.savefig(temporary, dpi=150, format="png", metadata={"Software": None})
        )
    finally:
        plt.close(figure)


def _images(track: Track, options: Options, wanted: list[int]) -> list[NDArray[np.uint8]]:
    found = {}
    for frame in options.source(Path(track.source)).frames(options.start, options.end):
        if frame.number in wanted:
            found[frame.number] = rgb_image(frame.picture)
            if len(found) == len(wanted):
                break
    return [found[number] for number in wanted]


def rgb_image(picture: Picture) -> NDArray[np.uint8]:
    """The picture for a screen, shape (height, width, 3)."""
    if picture.keep is not None:
        return np.asarray(picture.keep.to_ndarray(format="rgb24"), np.uint8)
    scale = 255.0 / picture.full_scale
    planes = picture.planes if picture.has_colour else 3 * picture.planes
    return np.stack([np.round(scale * plane.astype(np.float32)) for plane in planes], axis=-1).astype(np.uint8)


def _draw_frame(axes: Axes, track: Track, image: NDArray[np.uint8], position: Position, name: str) -> None:
    from matplotlib.patches import Rectangle

    # White on black is seen on any picture, whatever one's eyes.
    def twice(draw: Callable[..., Any], *values: Any, width: float, colour: str, **how: Any) -> None:
        draw(*values, color="black", linewidth=width + 1.6, **how)
        draw(*values, color=colour, linewidth=width, **how)

    def outline(x: float, y: float, w: float, h: float, *, color: str, linewidth: float) -> None:
        axes.add_patch(Rectangle((x, y), w, h, fill=False, edgecolor=color, linewidth=linewidth))

    height, width = track.shape
    axes.imshow(image, extent=(-0.5, width - 0.5, height - 0.5, -0.5), interpolation="bilinear")
    points = np.array([p.gradient if track.method == "gradient" else p.grey_level for p in track.positions])
    twice(axes.plot, points[:, 0], points[:, 1], width=0.8, colour="#56B4E9")
    twice(outline, *position.region, width=1.0, colour="white")
    x, y = position.gradient if track.method == "gradient" else position.grey_level
    twice(axes.plot, [x], [y], width=1.0, colour="#F0E442", marker="+", markersize=9.0, markeredgewidth=None)
    axes.set_xlim(-0.5, width - 0.5)
    axes.set_ylim(height - 0.5, -0.5)
    axes.set_axis_off()
    axes.set_title(f"{name}: t = {position.time:.3f} s, frame {position.frame}")


def _draw_course(axes: Axes, track: Track, column: str, colour: str) -> None:
    table = track.table
    time, value, std = (table[c].to_numpy() for c in ("t", column, f"{column}_std"))
    # A line over frames without a row would show what was not measured.
    gaps = np.flatnonzero(np.diff(time) > 1.5 * track.clock.period) + 1
    for part in np.split(np.arange(len(time)), gaps):
        axes.plot(time[part], value[part], color=colour, marker=".", markersize=2.5, linewidth=0.8)
        axes.fill_between(
            time[part], (value - 2.0 * std)[part], (value + 2.0 * std)[part], color=colour, alpha=0.3, lw=0
        )
    repeated = table["repeated"].to_numpy() == 1
    if repeated.any():
        axes.plot(
            time[repeated], value[repeated], "s", color="black", markersize=4.0, fillstyle="none", label="repeated"
        )
        axes.legend(loc="upper right")
    downwards = column == "y" and not _points_up(table, track)
    axes.set_ylabel(f"{column} in {track.unit}" + (", down" if downwards else ""))
    if downwards:
        axes.invert_yaxis()
    axes.margins(x=0.01)


def _draw_deviations(axes: Axes, track: Track, colours: tuple[str, str]) -> None:
    """Standard deviations on a panel of their own: beside the path they are narrower than the line."""
    for column, colour, line in zip("xy", colours, ("-", "--"), strict=True):
        table = track.table
        axes.plot(table["t"], table[f"{column}_std"], line, color=colour, linewidth=0.9, label=f"{column}_std")
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel(f"std in {track.unit}")
    scattered = ", ".join(f"{c} {v:.2g} {track.unit}" for c, v in track.scatter.items() if v is not None)
    axes.set_title(f"standard deviation from the noise of the pixels (scatter from frame to frame: {scattered or '–'})")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), handlelength=1.6, borderaxespad=0.2)


def _points_up(table: pd.DataFrame, track: Track) -> bool:
    """Whether y grows upwards in the recording; in an image it grows downwards."""
    pixels = np.array([p.gradient[1] if track.method == "gradient" else p.grey_level[1] for p in track.positions])
    return bool(np.polyfit(pixels, table["y"].to_numpy(), 1)[0] < 0.0)
