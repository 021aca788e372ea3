"""Figure of the benchmark: time of a fit against its error, one marker per tool."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from benchmarks.identification import FEW_FITS
from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.transforms import BboxBase

PERIOD = 0.1  # s
FONT_SIZE = 7.0
# One marker shape per tool, so that tools can be told apart without colour; each marker also has a label.
MARKERS = {
    "camid": ("o", style.BLUE),
    "scipy": ("s", style.VERMILION),
    "pysib": ("^", style.GREEN),
    "SIPPY": ("v", style.ORANGE),
    "nfoursid": ("x", style.BLACK),
    "llsi": ("P", style.GREY),
    "jax-sysid": ("X", style.GREEN),
    "sysidentpy": ("*", style.VERMILION),
}
# Where a label may go, in points from its marker, best first: offset and horizontal alignment.
PLACES = [
    (dx, dy, side)
    for reach, rise in ((7, 0), (7, 7), (12, 12), (20, 10), (16, 18), (26, 16), (16, 26))
    for dy in ({0} if rise == 0 else (rise, -rise))
    for dx, side in ((reach, "left"), (-reach, "right"))
]

# Points at which the line from a marker to its label is checked for obstacles, as shares of its length.
WAY = np.linspace(0.3, 1.0, 8)


def labels(part: pd.DataFrame) -> list[str]:
    """Name of each tool with its start, its number of fits where that is small, and its gross failures."""
    result = []
    for _, row in part.iterrows():
        notes = ["warm start"] if row["start"] == "nominal" else []
        if row["fits"] < FEW_FITS:
            notes.append(f"{row['fits']:.0f} fits only")
        if row["gross_failures"]:
            notes.append(f"{row['gross_failures']:.0f} of {row['fits']:.0f} failed")
        result.append(row["tool"] + (f" ({', '.join(notes)})" if notes else ""))
    return result


def contains(outer: BboxBase, inner: BboxBase) -> bool:
    """Whether a box lies inside another."""
    return bool(outer.x0 <= inner.x0 and inner.x1 <= outer.x1 and outer.y0 <= inner.y0 and inner.y1 <= outer.y1)


def place_labels(axes: Axes, texts: list[str], points: list[tuple[float, float]]) -> None:
    """Write each label beside its point, where it touches no marker, no label, no border and, if possible, no bound."""
    from matplotlib.transforms import Bbox  # noqa: PLC0415

    figure = axes.figure
    figure.draw_without_rendering()
    pixels = figure.dpi / 72.0
    half = 4.5 * pixels  # half a marker
    centres = axes.transData.transform(points)
    markers = [Bbox.from_extents(x - half, y - half, x + half, y + half) for x, y in centres]
    taken = list(markers)
    frame = axes.bbox
    bound = axes.transData.transform((1.0, points[0][1]))[0]
    line = Bbox.from_extents(bound - 2.0, axes.bbox.y0, bound + 2.0, axes.bbox.y1)
    written: list[Bbox] = []  # labels, and points on the lines to them
    ways: list[tuple[float, float]] = []
    for i, (text, point) in enumerate(zip(texts, points, strict=True)):
        others = markers[:i] + markers[i + 1 :]
        label = axes.annotate(
            text, point, xytext=(0, 0), textcoords="offset points", va="center", fontsize=FONT_SIZE, zorder=4.0
        )
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.5})
        for obstacles, (dx, dy, side) in [(o, place) for o in ([*taken, line], taken) for place in PLACES]:
            label.set(position=(dx, dy), horizontalalignment=side)
            box = label.get_window_extent()
            way = centres[i] + pixels * np.multiply.outer(WAY, (dx, dy))
            crossed = any(other.contains(*step) for other in [*others, *written] for step in way)
            covered = any(box.contains(*step) for step in ways)
            if contains(frame, box) and box.count_overlaps(obstacles) == 0 and not (dy and crossed) and not covered:
                break
        taken.append(box)
        written.append(box)
        if dy != 0:  # a line back to the marker, since another marker may be as near
            ways.extend(way)
            axes.annotate(
                "",
                point,
                xytext=(dx, dy),
                textcoords="offset points",
                arrowprops={"arrowstyle": "-", "linewidth": 0.6, "color": style.BLACK, "shrinkA": 0.0, "shrinkB": 0.0},
                zorder=3.5,  # to the middle of the marker, over those that it passes
            )


def draw(table: pd.DataFrame, period: float = PERIOD) -> Figure:
    """Draw the tools that gave a result at one sampling period.

    Parameters
    ----------
    table : DataFrame
        Of `benchmarks.identification`.
    period : float
        Seconds.
    """
    style.apply()
    import matplotlib.pyplot as plt  # noqa: PLC0415 - after the choice of the backend

    part = table[(table["period"] == period) & np.isfinite(table["milliseconds"]) & np.isfinite(table["to_bound"])]
    figure, axes = plt.subplots(figsize=(style.PAGE_WIDTH, 4.8))
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.axvline(1.0, color=style.BLACK, linewidth=0.8, linestyle=(0, (4, 2)), zorder=1.0)
    points = list(zip(part["to_bound"], part["milliseconds"], strict=True))
    for (x, y), tool, start in zip(points, part["tool"], part["start"], strict=True):
        marker, colour = MARKERS.get(str(tool).split()[0], ("o", style.BLACK))
        face = "white" if start == "nominal" else colour
        axes.plot(x, y, marker=marker, color=colour, markerfacecolor=face, markersize=6.5, linestyle="none", zorder=3.0)
    axes.margins(x=0.2, y=0.1)
    ticks = [0.5, 0.7, 1, 1.5, 2, 3, 5, 10]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    axes.set_xlabel("Root mean square error of $b_0$, $a_1$ and $a_0$, divided by the Cramér–Rao bound (dashed)")
    axes.set_ylabel("Median time of a fit in ms")
    place_labels(axes, labels(part), points)
    return figure


def save(table: pd.DataFrame, path: Path) -> None:
    """Write the figure."""
    import matplotlib.pyplot as plt  # noqa: PLC0415

    figure = draw(table)
    figure.savefig(path, format="png", dpi=200.0, metadata={"Software": None})
    plt.close(figure)
