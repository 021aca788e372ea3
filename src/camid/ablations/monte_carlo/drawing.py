"""Error over bound and coverage of the intervals against the sampling period."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from camid import plotting as style
from camid.ablations.monte_carlo.runs import with_ratios

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Words, colour, symbol, its face, and a shift in seconds that keeps the three apart.
LOOKS = {
    "b0": ("$b_0$", style.BLUE, "o", style.BLUE, -0.0012),
    "a1": ("$a_1$", style.VERMILION, "s", "white", 0.0),
    "a0": ("$a_0$", style.BLACK, "^", style.BLACK, 0.0012),
}
ON_THE_BOUND = 1.05


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the sums of :func:`camid.ablations.monte_carlo.runs.combine`."""
    ratios = with_ratios(table)
    return draw_ratios(ratios[["period", "parameter", "fits", "bound", "ratio", "mean", "coverage", "gross"]])


def draw_ratios(ratios: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the ratios of :func:`camid.ablations.monte_carlo.runs.with_ratios`."""
    style.apply()
    import matplotlib.pyplot as plt

    seeds = int(ratios["fits"].iloc[0])
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(style.COLUMN_WIDTH * 1.45, 4.4), sharex=True)
    scatter, share = 2.0 / np.sqrt(2.0 * seeds), 2.0 * np.sqrt(0.95 * 0.05 / seeds)
    band = f"± 2 standard errors of {seeds} noise seeds"
    upper.axhspan(1.0 - scatter, 1.0 + scatter, color="#BBBBBB", alpha=0.45, linewidth=0.0, label=band)
    lower.axhspan(95.0 - 100.0 * share, 95.0 + 100.0 * share, color="#BBBBBB", alpha=0.45, linewidth=0.0)
    # Every period has noise of its own: no line joins them.
    for parameter, (label, colour, symbol, face, shift) in LOOKS.items():
        group = ratios[ratios["parameter"] == parameter]
        look = {"color": colour, "marker": symbol, "markerfacecolor": face, "markersize": 2.8, "linestyle": "none"}
        upper.plot(group["period"] + shift, group["ratio"], label=label, markeredgewidth=0.7, **look)
        lower.plot(group["period"] + shift, 100.0 * group["coverage"], label=label, markeredgewidth=0.7, **look)
    words = f"{ON_THE_BOUND:g}: counts as on the bound"
    upper.axhline(ON_THE_BOUND, color=style.GREY, linewidth=0.8, linestyle="-.", label=words)
    upper.set(ylabel="rms error / Cramér–Rao bound")
    lower.set(ylabel="95 % intervals that cover (%)", xlabel="sampling period T (s)")
    handles, labels = upper.get_legend_handles_labels()
    order = sorted(range(len(labels)), key=lambda i: not labels[i].startswith("$"))  # parameters first
    figure.legend([handles[i] for i in order], [labels[i] for i in order], loc="outside upper center", ncols=2)
    return figure, ratios
