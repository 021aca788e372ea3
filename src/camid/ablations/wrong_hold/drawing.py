"""Bias under wrong declarations of hold and sensor, and how often the residual test warns of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LINES = (("o", "-", style.VERMILION), ("s", "--", style.BLUE), ("^", ":", style.BLACK), ("x", "-.", style.GREEN))
DECEIVING = 2.0
# Of bias, alarms and p; finer digits are those of the stopping rule and of the processor.
RESOLUTION = 1e-3


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw bias and power against the sampling period, one column per wrong declaration.

    Parameters
    ----------
    table : DataFrame
        From :func:`camid.ablations.wrong_hold.runs.compute`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    wrong = table[~table["right"]]
    names = list(dict.fromkeys(wrong["case"]))
    figure, panels = plt.subplots(
        2, len(names), figsize=(style.PAGE_WIDTH, 4.2), sharex=True, sharey="row", squeeze=False
    )
    columns = ["case", "right", "period", "decibel", "bias", "alarms"]
    drawn = table[columns].drop_duplicates().reset_index(drop=True)
    for column, name in enumerate(names):
        upper, lower = panels[:, column]
        for (decibel, rows), (symbol, line, colour) in zip(
            drawn[drawn["case"] == name].groupby("decibel"), LINES, strict=False
        ):
            for axes, quantity in ((upper, "bias"), (lower, "alarms")):
                axes.plot(
                    1e3 * rows["period"],
                    rows[quantity],
                    symbol + line,
                    color=colour,
                    markerfacecolor="white",
                    label=f"{decibel:g} dB",
                )
        upper.axhline(DECEIVING, color=style.GREY, linewidth=0.8)
        upper.set(title=name, yscale="log")
        lower.set(xlabel="period T (ms)", xscale="log", ylim=(-4.0, 104.0))
        ticks = sorted(1e3 * p for p in set(drawn["period"]))
        lower.set_xticks(ticks, [f"{t:g}" for t in ticks])
        lower.minorticks_off()
    panels[0, 0].set_ylabel("bias (stated σ)")
    panels[1, 0].set_ylabel("recordings warned of (%)")
    low, high = panels[0, 0].get_ylim()
    ticks = [t for t in (1, 2, 5, 10, 20, 50, 100) if low <= t <= high]
    panels[0, 0].set_yticks(ticks, [f"{t:g}" for t in ticks])
    panels[0, 0].minorticks_off()
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=len(LINES))
    for quantity in ("bias", "alarms"):
        drawn[quantity] = (drawn[quantity] / RESOLUTION).round() * RESOLUTION + 0.0
    return figure, drawn
