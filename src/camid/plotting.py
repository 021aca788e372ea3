"""One look for all figures: journal column widths, bundled fonts, colours for the colour-blind and for grey print."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from camid.writing import write_whole

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

COLUMN_WIDTH = 3.5  # inches: one column of a two-column journal
PAGE_WIDTH = 7.1
# Okabe & Ito (2008), ordered so that their luminance differs in grey; line styles differ as well.
BLUE, VERMILION, GREEN, ORANGE, GREY, BLACK = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#7F7F7F", "#000000"
SIGNIFICANT_DIGITS = 9
SMALLEST = 1e-12

SETTINGS: dict[Any, Any] = {
    # DejaVu comes with matplotlib, so a figure has the same bytes wherever the locked versions are installed.
    "font.family": "DejaVu Sans",
    "mathtext.fontset": "dejavusans",
    "font.size": 8.0,
    "axes.titlesize": 8.0,
    "axes.labelsize": 8.0,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "legend.fontsize": 7.0,
    "legend.frameon": False,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": "#D9D9D9",
    "grid.linewidth": 0.4,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.2,
    "lines.markersize": 3.5,
    "figure.dpi": 100.0,
    "savefig.dpi": 300.0,
    "figure.constrained_layout.use": True,
    "pdf.fonttype": 42,
    "svg.hashsalt": "camid",
}


def apply() -> None:
    """Choose the backend and set the look; call it before a figure is made."""
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcdefaults()
    mpl.rcParams.update(SETTINGS)


@contextmanager
def look() -> Iterator[None]:
    """The look for figures that a user asks for: no trace in the settings of matplotlib, and names drawn as they are.

    Figures are made by :class:`matplotlib.figure.Figure`, not by pyplot, which would choose a backend.
    """
    import matplotlib as mpl

    defaults = {k: v for k, v in mpl.rcParamsDefault.items() if not k.startswith(("backend", "interactive", "toolbar"))}
    with mpl.rc_context():
        mpl.rcParams.update(defaults)
        mpl.rcParams.update(SETTINGS)
        mpl.rcParams.update({"text.parse_math": False, "axes.formatter.useoffset": False})  # a column may be called $x
        yield


def rendered(figure: Figure, suffix: str) -> bytes:
    """The figure as the content of a PNG, SVG or PDF file, the same at every run."""
    nameless: dict[str, dict[str, Any]] = {
        "png": {"Software": None},
        "svg": {"Date": None, "Creator": None},
        "pdf": {"CreationDate": None, "Producer": None},
    }
    content = BytesIO()
    with look():
        figure.savefig(content, format=suffix, metadata=nameless[suffix])
    return content.getvalue()


def image_element(figure: Figure) -> str:
    """The figure as an image within HTML, for a notebook."""
    from base64 import b64encode

    width = round(96.0 * float(figure.get_size_inches()[0]))
    return f'<img width="{width}" src="data:image/png;base64,{b64encode(rendered(figure, "png")).decode("ascii")}">'


def separate_panels(figure: Figure, share: float = 0.08) -> None:
    """Leave a share of the panels' width between them, where a colour bar's label would touch the next panel."""
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    engine = figure.get_layout_engine()
    if isinstance(engine, ConstrainedLayoutEngine):
        engine.set(wspace=share)


def mark_outside(axes: Axes, abscissa: ArrayLike, ordinate: ArrayLike, colour: str, joined: bool = True) -> bool:
    """Mark with triangles on the frame where a curve, or its points, lie above or below the axis.

    Call it when limits and scales of the axes are set.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    abscissa, ordinate : array_like, shape (n,)
        In the order in which they are drawn; not finite values are gaps.
    colour : str
    joined : bool
        Whether lines join the points: marked is where the line leaves the axis or comes back; otherwise every point
        outside is.

    Returns
    -------
    bool
        Whether anything was marked.
    """
    points = np.column_stack([np.asarray(abscissa, float), np.asarray(ordinate, float)])
    if not len(points):
        return False
    marked = False
    for edge, sign, symbol in ((axes.get_ylim()[1], 1.0, "^"), (axes.get_ylim()[0], -1.0, "v")):
        outside = sign * points[:, 1] > sign * edge
        if joined:
            # In the scales of the axes, where lines are straight.
            scaled = axes.transScale.transform(points)
            level = axes.transScale.transform((points[0, 0], edge))[1]
            first = np.flatnonzero((outside[1:] != outside[:-1]) & np.isfinite(points[1:] + points[:-1]).all(axis=1))
            share = (level - scaled[first, 1]) / (scaled[first + 1, 1] - scaled[first, 1])
            across = scaled[first, 0] + share * (scaled[first + 1, 0] - scaled[first, 0])
            places = axes.transScale.inverted().transform(np.column_stack([across, np.full(across.shape, level)]))[:, 0]
        else:
            places = points[outside, 0]
        if not len(places):  # an empty line would count as the corner of the figure to the layout
            continue
        look: dict[str, Any] = {
            "color": colour,
            "markersize": 4.5,
            "markeredgewidth": 0.0,
            "clip_on": False,
            "zorder": 5.0,
        }
        axes.plot(places, np.full(len(places), edge), symbol, label="_outside", **look)
        marked = True
    return marked


def outside_handle(words: str = "leaves the axis") -> Any:
    """Entry of a legend for :func:`mark_outside`."""
    from matplotlib.lines import Line2D

    return Line2D([], [], marker="^", color=GREY, markersize=4.5, linestyle="none", label=words)


def rounded(table: pd.DataFrame, digits: int = SIGNIFICANT_DIGITS) -> pd.DataFrame:
    """The table with its numbers cut to significant digits that no processor's rounding reaches."""

    def cut(value: float) -> float:
        return 0.0 if abs(value) < SMALLEST else float(f"{value:.{digits}g}")

    floats = [c for c in table.columns if table[c].dtype.kind == "f"]
    return table.assign(**{str(c): table[c].map(cut) for c in floats})


def save(
    figure: Figure,
    table: pd.DataFrame,
    png: str | Path,
    csv: str | Path,
    pdf: str | Path | None = None,
    digits: int = SIGNIFICANT_DIGITS,
) -> None:
    """Write PNG, the CSV of the plotted numbers and, if asked, PDF, byte for byte the same at every run."""
    import matplotlib.pyplot as plt

    write_whole(png, lambda path: figure.savefig(path, format="png", metadata={"Software": None}))
    write_whole(csv, lambda path: rounded(table, digits).to_csv(path, index=False, lineterminator="\n"))
    if pdf is not None:
        figure.set_layout_engine("none")  # the layout is that of the PNG, and not worked out again
        write_whole(
            pdf, lambda path: figure.savefig(path, format="pdf", metadata={"CreationDate": None, "Producer": None})
        )
    plt.close(figure)
