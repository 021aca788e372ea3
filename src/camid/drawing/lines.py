"""Lines, bands and legends that the pictures share: told apart by colour, by dash, and in grey."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid import plotting as style
from camid.number_text import printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

# 95 % of a normal variable lie within so many standard deviations.
BAND = 1.959964
COLOURS = (style.BLUE, style.VERMILION, style.GREEN, style.ORANGE, "#CC79A7", "#56B4E9")
DASHES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (1.2, 1.2)), (0, (6, 1.5, 1.2, 1.5)), (0, (3, 3)), (0, (8, 2)))
BAND_OPACITY = 0.22
SHADE = "#E4E4E4"
# A name of more letters is cut.
LONGEST_NAME = 34


def line_of(index: int) -> dict[str, Any]:
    """Colour and dashes of a model's line."""
    return {"color": COLOURS[index % len(COLOURS)], "linestyle": DASHES[index % len(DASHES)]}


def short(name: str, longest: int = LONGEST_NAME) -> str:
    """A name without control characters, its middle cut out where it is long."""
    name = printable(name)
    half = (longest - 1) // 2
    return name if len(name) <= longest else f"{name[:half]}…{name[-half:]}"


@cache
def _figure_of_notebooks() -> type[Figure]:
    """The class of figures that a notebook shows, be pyplot loaded or not."""
    from matplotlib.figure import Figure

    class NotebookFigure(Figure):
        """A figure that is shown as a PNG."""

        def _repr_png_(self) -> bytes:
            return style.rendered(self, "png")

    return NotebookFigure


def new_figure(height: float, width: float = style.PAGE_WIDTH) -> Figure:
    """A figure without pyplot, sizes in inches."""
    return _figure_of_notebooks()(figsize=(width, height))


def band(axes: Axes, x: Array, low: Array, high: Array, index: int) -> None:
    """A band in the colour of a model's line."""
    axes.fill_between(x, low, high, color=COLOURS[index % len(COLOURS)], alpha=BAND_OPACITY, linewidth=0, zorder=1.2)


def legend_above(axes: Axes, columns: int = 4) -> None:
    """The legend in rows above the axes, left, in reading order."""
    handles, labels = axes.get_legend_handles_labels()
    widest = max((len(label) for label in labels), default=1)
    fitting = max(1, min(columns, len(labels), 96 // (widest + 8)))
    axes.legend(handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=fitting, borderaxespad=0.2)


def range_of(values: Sequence[Array], margin: float = 0.06) -> tuple[float, float]:
    """Limits of an axis that holds all finite values."""
    finite = np.concatenate([np.ravel(v)[np.isfinite(np.ravel(v))] for v in values])
    if not finite.size:
        return -1.0, 1.0
    low, high = float(np.min(finite)), float(np.max(finite))
    room = margin * (high - low) or 0.1 * max(abs(low), 1.0)
    return low - room, high + room
