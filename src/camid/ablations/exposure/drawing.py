"""Bias against the exposure, for five declarations of the sensor."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style
from camid.ablations.identification_drawing import ERROR_LABELS, printed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOOKS = {
    "exact": ("(a) camera, true exposure", style.BLACK, "-", ""),
    "first-order-hold": ("(b) first-order hold (the paper's)", style.BLUE, "-", "o"),
    "model-2": ("(c) Model #2, true exposure", style.GREEN, "--", "^"),
    "model-3": ("(d) Model #3, true exposure", style.ORANGE, ":", "s"),
    "instant": ("(e) instant sensor", style.VERMILION, "-.", "x"),
}


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the errors of b0, a1 and a0 (rows) at each period (columns).

    Parameters
    ----------
    table : DataFrame
        From :func:`camid.ablations.exposure.runs.compute`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    periods = sorted(set(table["period"]))
    # Each panel has its own scale: the biases at the shortest period would be a flat line on that of the longest.
    figure, panels = plt.subplots(3, len(periods), figsize=(style.PAGE_WIDTH, 5.6), sharex=True, squeeze=False)
    for row, (parameter, label) in zip(panels, ERROR_LABELS.items(), strict=True):
        for axes, period in zip(row, periods, strict=True):
            for model, (name, colour, line, symbol) in LOOKS.items():
                runs = table[(table["period"] == period) & (table["model"] == model)].sort_values("exposure")
                axes.plot(
                    runs["exposure"],
                    runs[f"error_{parameter}"],
                    line,
                    marker=symbol,
                    markerfacecolor="white",
                    color=colour,
                    label=name,
                )
        row[0].set_ylabel(label)
    for axes, period in zip(panels[0], periods, strict=True):
        axes.set_title(f"T = {1e3 * period:g} ms")
    for axes in panels[-1]:
        axes.set(xlabel="exposure τ/T", xlim=(0.0, 1.03))
    figure.align_ylabels(panels[:, 0])
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure, printed(table, [f"error_{p}" for p in ERROR_LABELS])
