"""Panels of the report and how they are drawn: axes with margins that fit, dots, bins and short inline SVG.

Colours are variables of the page's style sheet, so that a panel is dark on a dark page and black on paper.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import StringIO
from math import floor, log10
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.number_text import SUPERSCRIPTS, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

POINTS_PER_INCH = 72.0
# Points; the page shows a point as about a pixel. What is wide on a desk is drawn once more for a telephone.
PANEL, WIDE, NARROW = (420.0, 262.0), (880.0, 250.0), (420.0, 270.0)
BOTTOM, RIGHT, GAP, EDGE = 46.0, 14.0, 12.0, 5.0
LARGEST_SCATTER, LARGEST_LINE = 900, 1200
BINS, LEAST_IN_BIN, MOST_LEVELS = 20, 5, 12
DIGITS_OF_COORDINATES = 2
# Powers of ten between which the numbers of an axis need none.
SMALL_POWER, LARGE_POWER = -3, 5
FONTS = "'DejaVu Sans', Verdana, sans-serif"  # Verdana has the widths of DejaVu Sans, with which the panel was laid out
DOTS, SHADE, REGION = "#B8B8B8", "#E3E3E3", "#F0E442"
# Colours of the drawings, and the variables of the style sheet that stand for them.
VARIABLES = {
    "#000000": "ink",
    "#ffffff": "page",
    "#0072b2": "blue",
    "#d55e00": "vermilion",
    "#009e73": "green",
    "#e69f00": "orange",
    "#7f7f7f": "grey",
    "#d9d9d9": "grid",
    "#b8b8b8": "dots",
    "#e3e3e3": "shade",
    "#f0e442": "region",
}


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
    narrow : str
        The same for a narrow screen, where it is wide.
    """

    title: str
    caption: str
    svg: str
    wide: bool = False
    located: bool = False
    narrow: str = ""


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
                "figure.facecolor": "none",
                "axes.facecolor": "none",
                "svg.fonttype": "none",
                "path.simplify_threshold": 0.3,
            }
        )
        yield


def new_panel(size: tuple[float, float] = PANEL, top: float = 12.0) -> Axes:
    """Axes on a new figure of this size in points, with room for a line above them."""
    return new_panels(size, (1.0,), top)[0]


def new_panels(size: tuple[float, float], heights: Sequence[float], top: float = 12.0) -> list[Axes]:
    """Axes one above the other, over one abscissa, with these relative heights."""
    from matplotlib.figure import Figure

    width, height = size
    figure = Figure(figsize=(width / POINTS_PER_INCH, height / POINTS_PER_INCH))
    room = height - top - BOTTOM - GAP * (len(heights) - 1)
    made: list[Axes] = []
    upper = height - top
    for share in heights:
        tall = room * share / sum(heights)
        box = (0.15, (upper - tall) / height, 0.85 - RIGHT / width, tall / height)
        made.append(figure.add_axes(box, sharex=made[0] if made else None))
        upper -= tall + GAP
    for axes in made[:-1]:
        axes.tick_params(labelbottom=False)
    return made


def wide_panel(draw: Callable[[tuple[float, float]], Axes], label: str) -> dict[str, Any]:
    """What a wide panel is made of: drawn for a desk, and once more for a telephone.

    Parameters
    ----------
    draw : callable
        Draws it in a size.
    label : str
        What it shows, for who does not see it.
    """
    return {
        "svg": inline_svg(draw(WIDE), label),
        "narrow": inline_svg(draw(NARROW), f"{label}, narrow"),
        "wide": True,
    }


def is_narrow(size: tuple[float, float]) -> bool:
    """Whether a wide panel is drawn for a narrow screen."""
    return size[0] < WIDE[0]


def inline_svg(axes: Axes, label: str, *, zoomable: bool = True) -> str:
    """The figure as inline SVG: no header, no identifiers that could clash, short coordinates, colours as variables.

    Parameters
    ----------
    axes : Axes
        Its whole figure is drawn.
    label : str
        What it shows; another one for every drawing of a page.
    zoomable : bool
        Whether the page's script may move what it holds.
    """
    from html import escape

    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    figure = axes.get_figure(root=True)
    assert figure is not None
    powers = {each: tuple(map(_named_by_power, (each.xaxis, each.yaxis))) for each in figure.axes}
    _fit_margins(figure)
    for each in figure.axes:
        for line in each.lines:
            if not str(line.get_label()).startswith("_"):
                line.set_gid(f"series {line.get_label()}")
    text = StringIO()
    with mpl.rc_context({"svg.hashsalt": label}):  # identifiers of clips and markers that are those of no other
        FigureCanvasSVG(figure).print_svg(text)
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", svg, flags=re.DOTALL)
    svg = re.sub(r'<g id="([^"]*)">', _group, svg).replace("'DejaVu Sans'", FONTS)
    view = re.search(r'viewBox="[^"]*"', svg)
    about = f" data-axes='{escape(json.dumps([_about(a, powers[a]) for a in figure.axes]))}'" if zoomable else ""
    head = f'<svg role="img" aria-label="{escape(label)}" {view.group() if view else ""}{about}>'
    svg = head + svg[svg.index(">") + 1 :].replace("xlink:href", "href")
    svg = re.sub(r'style="[^"]*"', _with_variables, svg)
    return re.sub(r'\b(?:d|x|y|width|height|transform)="[^"]*"', _shortened, svg)


def _group(match: re.Match[str]) -> str:
    """A group without its identifier, but with what the script asks for."""
    name = match.group(1)
    if name.startswith("series "):
        return f'<g data-series="{name.removeprefix("series ")}">'
    kind = next((k for k in ("axes", "xtick", "ytick") if name.startswith(f"{k}_")), None)
    return "<g>" if kind is None else f'<g class="{kind}">'


def _with_variables(match: re.Match[str]) -> str:
    return re.sub(
        r"#[0-9a-f]{6}", lambda m: f"var(--{VARIABLES[m.group()]})" if m.group() in VARIABLES else m.group(),
        match.group(),
    )  # fmt: skip


def _shortened(match: re.Match[str]) -> str:
    def short(number: re.Match[str]) -> str:
        return f"{float(number.group()):.{DIGITS_OF_COORDINATES}f}".rstrip("0").rstrip(".")

    return re.sub(r"-?\d+\.\d+", short, match.group())


def _about(axes: Axes, powers: tuple[int, ...]) -> dict[str, Any]:
    """What the script has to know of axes: their box in points from above, limits as they are labelled, and names."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    width, height = (POINTS_PER_INCH * float(side) for side in figure.get_size_inches())
    box = axes.get_position()
    edges = (width * box.x0, height * (1.0 - box.y1), width * box.x1, height * (1.0 - box.y0))
    limits = [[v / 10.0**p for v in ends] for ends, p in zip((axes.get_xlim(), axes.get_ylim()), powers, strict=True)]
    lowest = min(figure.axes, key=lambda each: each.get_position().y0)
    return {
        "box": [round(float(v), 2) for v in edges],
        "x": [float(f"{v:.9g}") for v in limits[0]],
        "y": [float(f"{v:.9g}") for v in limits[1]],
        "log": "".join(n for n, scale in (("x", axes.get_xscale()), ("y", axes.get_yscale())) if scale == "log"),
        "names": [axes.get_xlabel() or lowest.get_xlabel(), axes.get_ylabel()],
    }


def _named_by_power(axis: Axis) -> int:
    """Give an axis of very small or large numbers a power of ten in its label, and return its exponent."""
    from matplotlib.ticker import FuncFormatter, ScalarFormatter

    low, high = axis.get_view_interval()
    largest = max(abs(low), abs(high))
    if not isinstance(axis.get_major_formatter(), ScalarFormatter) or not largest > 0.0 or not np.isfinite(largest):
        return 0
    power = 3 * floor(floor(log10(largest)) / 3) if not SMALL_POWER <= floor(log10(largest)) < LARGE_POWER else 0
    axis.set_major_formatter(FuncFormatter(lambda v, _: plain(v / 10.0**power, 6)))
    if power:
        quantity, comma, unit = axis.get_label_text().rpartition(", ")
        exponent = f"10{str(power).translate(SUPERSCRIPTS)}"
        axis.set_label_text(f"{quantity}, {exponent} {unit}" if comma else f"{unit}, {exponent}")
    return power


def _fit_margins(figure: Figure) -> None:
    """Move the left edges of the axes to where the labels of the ordinates end, and shrink labels that are too long."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas = FigureCanvasAgg(figure)
    scale = POINTS_PER_INCH / figure.dpi
    width, height = (POINTS_PER_INCH * float(side) for side in figure.get_size_inches())
    renderer = canvas.get_renderer()
    needed = 0.0
    for axes in figure.axes:
        box = axes.get_position()
        for label, room in ((axes.yaxis.label, height * (box.height + 0.1)), (axes.xaxis.label, 0.8 * width)):
            extent = label.get_window_extent(renderer)
            long = scale * max(extent.width, extent.height)
            if long > room:
                label.set_fontsize(float(label.get_fontsize()) * room / long)
        shown = axes.yaxis.get_tightbbox(renderer)
        if shown is not None:
            needed = max(needed, width * box.x0 - scale * shown.x0)
    left = (needed + EDGE) / width
    for axes in figure.axes:
        box = axes.get_position()
        axes.set_position((left, box.y0, box.x1 - left, box.height))


def decade_text(value: float) -> str:
    """A number on a logarithmic axis: a power of ten without its factor of one."""
    return plain(value).removeprefix("1·")


def thinned(time: Array, values: Array, largest: int = LARGEST_LINE) -> tuple[Array, Array]:
    """Extremes of runs of rows, where there are more rows than a line can show."""
    size = -(-len(time) // (largest // 2))
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
    margin = 0.06 * (high - low) or (abs(low) or 1.0) * 0.1
    return float(low - margin), float(high + margin)


def draw_dots(axes: Axes, x: Array, y: Array, colour: str = DOTS, size: float = 2.6) -> None:
    """Scatter as one path: every dot is a line of no length with round ends, which takes 30 bytes."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    rows = np.linspace(0, len(x) - 1, min(len(x), LARGEST_SCATTER)).astype(int)
    vertices = np.repeat(np.column_stack([x[rows], y[rows]]), 2, axis=0)
    path = Path(vertices, np.tile([Path.MOVETO, Path.LINETO], len(rows)))
    path.should_simplify = False
    patch = PathPatch(path, facecolor="none", edgecolor=colour, linewidth=size, capstyle="round", zorder=1.5)
    patch.set_gid("series row")
    axes.add_artist(patch)
    patch.set_clip_path(axes.patch)


def quartiles_of_bins(x: Array, y: Array, bins: int = BINS) -> tuple[Array, Array]:
    """Centres of bins of x, shape (B,), and quartiles of y in them, shape (B, 3); few levels are a bin each."""
    levels = np.unique(x)
    if len(levels) <= MOST_LEVELS:
        groups, index = levels, np.searchsorted(levels, x)
    else:
        low, high = np.percentile(x, [1.0, 99.0])
        edges = np.linspace(low, high, bins + 1)
        groups, index = 0.5 * (edges[1:] + edges[:-1]), np.digitize(x, edges) - 1
    kept = [i for i in range(len(groups)) if np.count_nonzero(index == i) >= LEAST_IN_BIN]
    quartiles = np.array([np.percentile(y[index == i], [25.0, 50.0, 75.0]) for i in kept])
    return groups[kept], quartiles.reshape(-1, 3)


def legend_above(axes: Axes, columns: int) -> None:
    """The legend in rows above the axes."""
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=columns,
        borderaxespad=0.1,
        handlelength=1.8,
        columnspacing=1.3,
    )


def ticks_within_decade(low: float, high: float) -> tuple[float, ...]:
    """Where a logarithmic axis has ticks within a decade: more of them where it spans few decades."""
    return (1.0, 2.0, 5.0) if high < 200.0 * low else (1.0,)
