"""Error over bound and coverage of the intervals against the sampling period."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from camid import plotting as style
from camid.ablations.monte_carlo.runs import with_ratios

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOOKS = {
    "b0": ("$b_0$", style.BLUE, "-", "o"),
    "a1": ("$a_1$", style.VERMILION, "--", "s"),
    "a0": ("$a_0$", style.BLACK, ":", "^"),
}


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the sums of :func:`camid.ablations.monte_carlo.runs.combine`."""
    style.apply()
    import matplotlib.pyplot as plt

    ratios = with_ratios(table)
    seeds = int(table["fits"].iloc[0])
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(style.COLUMN_WIDTH * 1.45, 4.4), sharex=True)
    scatter, share = 2.0 / np.sqrt(2.0 * seeds), 2.0 * np.sqrt(0.95 * 0.05 / seeds)
    upper.axhspan(1.0 - scatter, 1.0 + scatter, color="#BBBBBB", alpha=0.45, linewidth=0.0)
    lower.axhspan(95.0 - 100.0 * share, 95.0 + 100.0 * share, color="#BBBBBB", alpha=0.45, linewidth=0.0)
    for parameter, (label, colour, line, symbol) in LOOKS.items():
        group = ratios[ratios["parameter"] == parameter]
        look = {"color": colour, "linestyle": line, "marker": symbol, "markersize": 2.6, "linewidth": 0.9}
        upper.plot(group["period"], group["ratio"], label=label, **look)
        lower.plot(group["period"], 100.0 * group["coverage"], label=label, **look)
    upper.axhline(1.05, color=style.GREY, linewidth=0.8, linestyle="-.")
    upper.set(ylabel="rms error / Cramér–Rao bound", title=f"{seeds} noise seeds per period; grey: ± 2 standard errors")
    lower.set(ylabel="95 % intervals that cover (%)", xlabel="sampling period T (s)")
    upper.legend(ncols=3, loc="upper right")
    return figure, ratios[["period", "parameter", "fits", "bound", "ratio", "mean", "coverage", "gross"]]
