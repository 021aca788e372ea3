"""Block diagrams of the two versions of Model #1 (paper, Figs. 4 and 5): one row of blocks, signals and a sampler."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import pandas as pd

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Lengths in inches, as the axes span the figure one to one; line widths and font sizes in points.
HEIGHT = 0.9
MIDLINE = 0.45  # height of the signal path
MARGIN = 0.1
BLOCK_HEIGHT = 0.52
SIGNAL_LENGTH = 0.6  # at most; a fuller row has shorter signals
SWITCH_LENGTH = 0.3
HEAD_LENGTH, HEAD_WIDTH = 0.08, 0.056
LABEL_RISE = 0.075  # from the signal path to the label's baseline
PERIOD_DROP = 0.06  # from the switch's contacts to its label
LINE_WIDTH = 0.8
FONT_SIZE = 9.0
BLOCK_FACE = "#F5F5F5"


class _Element(NamedTuple):
    """One element of a diagram, from left to right; a signal's length follows from the room the others leave."""

    kind: str  # block, signal or sampler
    mathtext: str
    label: str  # the same in plain ASCII, for the table
    length: float = 0.0


SAMPLER = _Element("sampler", "$T$", "T", SWITCH_LENGTH)


def draw_first_version() -> tuple[Figure, pd.DataFrame]:
    """Draw the first version of Model #1: integrator, sampler and discrete-time first-order transfer function.

    Returns
    -------
    figure : Figure
        The diagram, one column wide.
    table : DataFrame
        One row per element, from left to right: ``element`` (block, signal or sampler), ``label`` in plain ASCII, and
        ``x`` and ``y``, the centre of the element in inches from the lower left corner of the figure.

    Notes
    -----
    Source: paper, Fig. 4, equations (7) and (8). The sampler's label is its period, v_k = v(kT).
    """
    return _draw(
        [
            _Element("signal", "$y(t)$", "y(t)"),
            _Element("block", r"$\dfrac{1}{s}$", "1/s", 0.42),
            _Element("signal", "$v(t)$", "v(t)"),
            SAMPLER,
            _Element("signal", "$v_k$", "v_k"),
            _Element("block", r"$\dfrac{1-z^{-1}}{T}$", "(1 - z^-1)/T", 0.72),
            _Element("signal", "$w_k$", "w_k"),
        ]
    )


def draw_second_version() -> tuple[Figure, pd.DataFrame]:
    """Draw the second version of Model #1: continuous-time moving average and sampler.

    Returns
    -------
    figure : Figure
        The diagram, one column wide.
    table : DataFrame
        One row per element, from left to right: ``element`` (block, signal or sampler), ``label`` in plain ASCII, and
        ``x`` and ``y``, the centre of the element in inches from the lower left corner of the figure.

    Notes
    -----
    Source: paper, Fig. 5, equations (9) to (12). The sampler's label is its period, w_k = w(kT).
    """
    return _draw(
        [
            _Element("signal", "$y(t)$", "y(t)"),
            _Element("block", r"$\dfrac{1-e^{-Ts}}{Ts}$", "(1 - exp(-T s))/(T s)", 0.84),
            _Element("signal", "$w(t)$", "w(t)"),
            SAMPLER,
            _Element("signal", "$w_k$", "w_k"),
        ]
    )


def _draw(elements: list[_Element]) -> tuple[Figure, pd.DataFrame]:
    """Draw the elements in one centred row and list where they are."""
    style.apply()  # schemdraw asks for the backend when it is imported
    import matplotlib.pyplot as plt
    import schemdraw
    from schemdraw.elements import Arrow, Line, Switch
    from schemdraw.flow import Box

    figure = plt.figure(figsize=(style.COLUMN_WIDTH, HEIGHT))
    figure.set_layout_engine("none")  # after creation: given to figure(), it would be lost at the first of two savefigs
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, style.COLUMN_WIDTH), ylim=(0.0, HEIGHT))
    axes.set_axis_off()

    fixed = sum(e.length for e in elements)
    signals = sum(e.kind == "signal" for e in elements)
    stretch = min(SIGNAL_LENGTH, (style.COLUMN_WIDTH - 2 * MARGIN - fixed) / signals)
    left = (style.COLUMN_WIDTH - fixed - signals * stretch) / 2

    drawing = schemdraw.Drawing(canvas=axes)
    drawing.config(font="DejaVu Sans", mathfont="dejavusans", fontsize=FONT_SIZE, lw=LINE_WIDTH)
    drawing.here = (left, MIDLINE)
    rows = []
    for element, following in zip(elements, [*elements[1:], None], strict=True):
        length = element.length or stretch
        if element.kind == "block":
            drawing.add(Box(w=length, h=BLOCK_HEIGHT).fill(BLOCK_FACE).label(element.mathtext))
        elif element.kind == "sampler":
            switch = Switch().scale(length).length(length)  # drawn one unit long, with leads if it is to be longer
            drawing.add(switch.label(element.mathtext, "bottom", ofst=PERIOD_DROP))
        else:
            # A sampler is a contact, so its input has no arrowhead.
            signal = Line() if following is SAMPLER else Arrow(arrowlength=HEAD_LENGTH, arrowwidth=HEAD_WIDTH)
            # From the centre, as labels at the top are higher above an arrow than over a line.
            drawing.add(signal.length(length).label(element.mathtext, "center", ofst=(0.0, LABEL_RISE), valign="base"))
        rows.append((element.kind, element.label, round(left + length / 2, 4), MIDLINE))
        left += length
    drawing.draw(show=False)
    return figure, pd.DataFrame(rows, columns=["element", "label", "x", "y"])
