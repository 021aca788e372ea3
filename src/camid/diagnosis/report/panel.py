"""Panels of the report and how they are drawn: axes with fixed margins, dots, bins and short inline SVG."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import StringIO
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

POINTS_PER_INCH = 72.0
PANEL, WIDE = (420.0, 262.0), (880.0, 250.0)  # points; the page shows a point as about a pixel
LARGEST_SCATTER, LARGEST_LINE = 900, 1200
BINS, LEAST_IN_BIN, MOST_LEVELS = 20, 5, 12
DIGITS_OF_COORDINATES = 2
FONTS = "'DejaVu Sans', Verdana, sans-serif"  # Verdana has the widths of DejaVu Sans, with which the panel was laid out


@dataclass(frozen=True)
class Panel:
    """A panel of the page.

    Attributes
    ----------
    title, caption : str
    svg : str
        Inline, without identifiers that could clash.
    wide : bool
        Whether it takes the whole width.
    located : bool
        Whether it shows the signal that the located mismatch depends on.
    """

    title: str
    caption: str
    svg: str
    wide: bool = False
    located: bool = False


@contextmanager
def look_of_the_project() -> Iterator[None]:
    """The project's look, without a trace in the caller's settings of matplotlib."""
    import matplotlib as mpl

    from camid import plotting as style

    with style.look():
        mpl.rcParams.update(
            {
                "font.size": 11.0,
                "axes.labelsize": 11.0,
                "xtick.labelsize": 10.0,
                "ytick.labelsize": 10.0,
                "legend.fontsize": 10.0,
                "figure.constrained_layout.use": False,
                "svg.fonttype": "none",
                "path.simplify_threshold": 0.3,
            }
        )
        yield


def new_panel(size: tuple[float, float] = PANEL, left: float = 66.0, top: float = 12.0) -> Axes:
    """Axes on a new figure, with margins in points."""
    from matplotlib.figure import Figure

    width, height = size
    figure = Figure(figsize=(width / POINTS_PER_INCH, height / POINTS_PER_INCH))
    bottom, right = 46.0, 14.0
    box = (left / width, bottom / height, 1.0 - (left + right) / width, 1.0 - (bottom + top) / height)
    return figure.add_axes(box)


def inline_svg(axes: Axes, label: str) -> str:
    """The figure as inline SVG: no header, no identifiers of groups, short coordinates."""
    from html import escape

    from matplotlib.backends.backend_svg import FigureCanvasSVG

    text = StringIO()
    FigureCanvasSVG(axes.get_figure(root=True)).print_svg(text)
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", svg, flags=re.DOTALL)
    svg = re.sub(r'<g id="[^"]*">', "<g>", svg).replace("'DejaVu Sans'", FONTS)
    view = re.search(r'viewBox="[^"]*"', svg)
    head = f'<svg role="img" aria-label="{escape(label)}" {view.group() if view else ""}>'
    svg = head + svg[svg.index(">") + 1 :].replace("xlink:href", "href")

    def shorten(match: re.Match[str]) -> str:
        return re.sub(r"-?\d+\.\d+", lambda m: f"{float(m.group()):.{DIGITS_OF_COORDINATES}f}", match.group())

    return re.sub(r'\b(?:d|x|y|width|height|transform)="[^"]*"', shorten, svg)


def thinned(time: Array, values: Array) -> tuple[Array, Array]:
    """Extremes of runs of rows, where there are more rows than a line can show."""
    size = -(-len(time) // (LARGEST_LINE // 2))
    if size <= 2:
        return time, values
    count = len(time) // size * size
    blocks = np.nan_to_num(values[:count]).reshape(-1, size)
    first = np.arange(len(blocks)) * size
    both = np.sort(np.stack([first + blocks.argmin(1), first + blocks.argmax(1)]), axis=0)
    rows = both.T.ravel()
    return time[rows], values[rows]


def range_of_nearly_all(*values: Array, share: float = 0.4) -> tuple[float, float]:
    """Range of nearly all values, so that a few outliers do not flatten the picture."""
    finite = np.concatenate([v[np.isfinite(v)] for v in values])
    if not finite.size:
        return -1.0, 1.0
    low, high = np.percentile(finite, [share, 100.0 - share])
    margin = 0.06 * (high - low) or max(abs(low), 1.0) * 0.1
    return float(low - margin), float(high + margin)


def draw_dots(axes: Axes, x: Array, y: Array, colour: str, size: float = 2.6) -> None:
    """Scatter as one path: every dot is a line of no length with round ends, which takes 30 bytes."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    rows = np.linspace(0, len(x) - 1, min(len(x), LARGEST_SCATTER)).astype(int)
    vertices = np.repeat(np.column_stack([x[rows], y[rows]]), 2, axis=0)
    path = Path(vertices, np.tile([Path.MOVETO, Path.LINETO], len(rows)))
    path.should_simplify = False
    patch = PathPatch(path, facecolor="none", edgecolor=colour, linewidth=size, capstyle="round", zorder=1.5)
    axes.add_artist(patch)
    patch.set_clip_path(axes.patch)


def quartiles_of_bins(x: Array, y: Array) -> tuple[Array, Array]:
    """Centres of bins of x, shape (B,), and quartiles of y in them, shape (B, 3); few levels are a bin each."""
    levels = np.unique(x)
    if len(levels) <= MOST_LEVELS:
        groups, index = levels, np.searchsorted(levels, x)
    else:
        low, high = np.percentile(x, [1.0, 99.0])
        edges = np.linspace(low, high, BINS + 1)
        groups, index = 0.5 * (edges[1:] + edges[:-1]), np.digitize(x, edges) - 1
    kept = [i for i in range(len(groups)) if np.count_nonzero(index == i) >= LEAST_IN_BIN]
    quartiles = np.array([np.percentile(y[index == i], [25.0, 50.0, 75.0]) for i in kept])
    return groups[kept], quartiles.reshape(-1, 3)


def legend_above(axes: Axes, columns: int) -> None:
    """The legend in a row above the axes."""
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, borderaxespad=0.1, handlelength=1.8)


def ticks_within_decade(low: float, high: float) -> tuple[float, ...]:
    """Where a logarithmic axis has ticks within a decade: more of them where it spans few decades."""
    return (1.0, 2.0, 5.0) if high < 200.0 * low else (1.0,)
