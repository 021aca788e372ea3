"""Block diagrams of the two versions of Model #1 (paper, Figs. 4 and 5): one row of blocks, signals and a sampler."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Lengths in inches, as the axes span the figure one to one; line widths and font sizes in points.
HEIGHT = 0.9
MIDLINE = 0.45  # height of the signal path
MARGIN = 0.1
BLOCK_HEIGHT = 0.52
SIGNAL_LENGTH = 0.6  # at most; a fuller row has shorter signals
SWITCH_LENGTH, SWITCH_RISE = 0.3, 0.16
CONTACT_RADIUS = 0.02
HEAD_LENGTH, HEAD_WIDTH = 0.08, 0.056
LABEL_RISE = 0.075  # from the signal path to the label's baseline
PERIOD_DROP = 0.19
LINE_WIDTH = 0.8
FONT_SIZE = 9.0
BLOCK_FACE = "#F5F5F5"


@dataclass(frozen=True)
class _Element:
    """One element of a diagram, from left to right; a signal's length follows from the room the others leave."""

    kind: str  # block, signal or sampler
    mathtext: str
    label: str  # the same in plain ASCII, for the table
    length: float = 0.0


def _signal(mathtext: str, label: str) -> _Element:
    return _Element("signal", mathtext, label)


def _sampler() -> _Element:
    return _Element("sampler", "$T$", "T", SWITCH_LENGTH)


def draw_first_version() -> tuple[Figure, pd.DataFrame]:
    """Draw the first version of Model #1: integrator, sampler and discrete-time first-order transfer function.

    Returns
    -------
    figure : Figure
        The diagram, one column wide.
    table : DataFrame
        One row an element, from left to right: ``element`` (block, signal or sampler), ``label`` in plain ASCII, and
        ``x`` and ``y``, the centre of the element in inches from the lower left corner of the figure.

    Notes
    -----
    Source: paper, Fig. 4, equations (7) and (8). The sampler's label is its period, v_k = v(kT).
    """
    return _draw(
        [
            _signal("$y(t)$", "y(t)"),
            _Element("block", r"$\dfrac{1}{s}$", "1/s", 0.42),
            _signal("$v(t)$", "v(t)"),
            _sampler(),
            _signal("$v_k$", "v_k"),
            _Element("block", r"$\dfrac{1-z^{-1}}{T}$", "(1 - z^-1)/T", 0.72),
            _signal("$w_k$", "w_k"),
        ]
    )


def draw_second_version() -> tuple[Figure, pd.DataFrame]:
    """Draw the second version of Model #1: continuous-time moving average and sampler.

    Returns
    -------
    figure : Figure
        The diagram, one column wide.
    table : DataFrame
        One row an element, from left to right: ``element`` (block, signal or sampler), ``label`` in plain ASCII, and
        ``x`` and ``y``, the centre of the element in inches from the lower left corner of the figure.

    Notes
    -----
    Source: paper, Fig. 5, equations (9) to (12). The sampler's label is its period, w_k = w(kT).
    """
    return _draw(
        [
            _signal("$y(t)$", "y(t)"),
            _Element("block", r"$\dfrac{1-e^{-Ts}}{Ts}$", "(1 - exp(-T s))/(T s)", 0.84),
            _signal("$w(t)$", "w(t)"),
            _sampler(),
            _signal("$w_k$", "w_k"),
        ]
    )


def _draw(elements: list[_Element]) -> tuple[Figure, pd.DataFrame]:
    """Draw the elements in one centred row and list where they are."""
    import matplotlib.pyplot as plt

    style.apply()
    figure = plt.figure(figsize=(style.COLUMN_WIDTH, HEIGHT))
    figure.set_layout_engine("none")  # after creation: given to figure(), it would be lost at the first of two savefigs
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, style.COLUMN_WIDTH), ylim=(0.0, HEIGHT))
    axes.set_axis_off()

    fixed = sum(e.length for e in elements)
    signals = sum(e.kind == "signal" for e in elements)
    stretch = min(SIGNAL_LENGTH, (style.COLUMN_WIDTH - 2 * MARGIN - fixed) / signals)
    left = (style.COLUMN_WIDTH - fixed - signals * stretch) / 2

    rows = []
    for element, following in zip(elements, [*elements[1:], None], strict=True):
        right = left + (element.length or stretch)
        if element.kind == "block":
            _draw_block(axes, left, right, element.mathtext)
        elif element.kind == "sampler":
            _draw_sampler(axes, left, right, element.mathtext)
        else:
            # A sampler is a contact, so its input bears no head.
            head = following is None or following.kind != "sampler"
            _draw_arrow(axes, left, right, element.mathtext, head=head)
        rows.append((element.kind, element.label, round((left + right) / 2, 4), MIDLINE))
        left = right
    return figure, pd.DataFrame(rows, columns=["element", "label", "x", "y"])


def _draw_block(axes: Axes, left: float, right: float, mathtext: str) -> None:
    """Draw a transfer function in its frame."""
    from matplotlib.patches import Rectangle

    corner = (left, MIDLINE - BLOCK_HEIGHT / 2)
    frame = Rectangle(
        corner, right - left, BLOCK_HEIGHT, facecolor=BLOCK_FACE, edgecolor=style.BLACK, linewidth=LINE_WIDTH, zorder=2
    )
    axes.add_patch(frame)
    axes.text((left + right) / 2, MIDLINE, mathtext, fontsize=FONT_SIZE, ha="center", va="center", zorder=3)


def _draw_arrow(axes: Axes, left: float, right: float, mathtext: str, *, head: bool) -> None:
    """Draw a signal: a line, its name above it and, with ``head``, a filled head whose tip is at ``right``."""
    from matplotlib.patches import Polygon

    end = right - HEAD_LENGTH if head else right
    axes.plot([left, end], [MIDLINE, MIDLINE], color=style.BLACK, linewidth=LINE_WIDTH, zorder=1)
    if head:
        base = [(end, MIDLINE - HEAD_WIDTH / 2), (end, MIDLINE + HEAD_WIDTH / 2)]
        axes.add_patch(Polygon([(right, MIDLINE), *base], facecolor=style.BLACK, edgecolor="none", zorder=3))
    middle = (left + end) / 2
    axes.text(middle, MIDLINE + LABEL_RISE, mathtext, fontsize=FONT_SIZE, ha="center", va="baseline", zorder=3)


def _draw_sampler(axes: Axes, left: float, right: float, mathtext: str) -> None:
    """Draw an open switch between two contacts, its period below it."""
    from matplotlib.patches import Circle

    axes.plot([left, right - 0.04], [MIDLINE, MIDLINE + SWITCH_RISE], color=style.BLACK, linewidth=LINE_WIDTH, zorder=2)
    for x in (left, right):
        contact = Circle((x, MIDLINE), CONTACT_RADIUS, facecolor="white", edgecolor=style.BLACK, linewidth=LINE_WIDTH)
        contact.set_zorder(3)
        axes.add_patch(contact)
    middle = (left + right) / 2
    axes.text(middle, MIDLINE - PERIOD_DROP, mathtext, fontsize=FONT_SIZE, ha="center", va="baseline", zorder=3)
