"""Rms error and Cramér–Rao bound against the length of the excitation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from camid import plotting as style
from camid.ablations.excitation_length.runs import by_length
from camid.ablations.identification_drawing import SYMBOLS, printed

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw errors of b0, a1 and a0 for longer registers and for more periods, with the bound and a 1/sqrt(N) line.

    Parameters
    ----------
    table : DataFrame
        From :func:`camid.ablations.excitation_length.runs.compute`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    lengths = by_length(table)
    orders = lengths[lengths["kind"] == "order"]
    repeated = lengths[lengths["kind"] == "periods"]
    figure, panels = plt.subplots(1, len(SYMBOLS), figsize=(style.PAGE_WIDTH, 3.0), sharex=True)
    for axes, (p, symbol) in zip(panels, SYMBOLS.items(), strict=True):
        longest = orders.iloc[-1]
        axes.loglog(
            orders["length"],
            longest[f"bound_{p}"] * np.sqrt(longest["length"] / orders["length"]),
            ":",
            color=style.GREY,
            label="1/√N through the longest",
        )
        axes.loglog(orders["length"], orders[f"bound_{p}"], "-", color=style.BLUE, label="bound, longer register")
        axes.loglog(
            repeated["length"], repeated[f"bound_{p}"], "--", color=style.VERMILION, label="bound, more periods"
        )
        axes.loglog(
            orders["length"],
            orders[f"rms_{p}"],
            "o",
            color=style.BLUE,
            markerfacecolor="white",
            label="rms error, longer register",
        )
        axes.loglog(
            repeated["length"],
            repeated[f"rms_{p}"],
            "s",
            color=style.VERMILION,
            markerfacecolor="white",
            label="rms error, more periods",
        )
        axes.loglog(
            lengths["length"],
            lengths[f"moving_start_{p}"].abs(),
            "x",
            color=style.BLACK,
            label="|bias|, moving start declared at rest",
        )
        # Biases far below the noise need no room.
        low, high = 0.5 * float(orders[f"bound_{p}"].min()), 1.15 * axes.get_ylim()[1]
        ticks = [t for t in (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0) if low <= t <= high]
        axes.set_yticks(ticks, [f"{t:g}" for t in ticks])
        axes.set_xticks([128, 256, 512, 1024, 2048, 4096], ["128", "256", "512", "1024", "2048", "4096"])
        axes.minorticks_off()
        axes.set(xlabel="length N (samples)", title=symbol, ylim=(low, high))
        style.mark_outside(axes, lengths["length"], lengths[f"moving_start_{p}"].abs(), style.BLACK, joined=False)
    panels[0].set_ylabel("relative error (%)")
    handles, labels = panels[0].get_legend_handles_labels()
    below = plt.Line2D([], [], marker="v", color=style.BLACK, markersize=4.5, linestyle="none")
    figure.legend([*handles, below], [*labels, "|bias| below the axis"], loc="outside upper center", ncols=3)
    columns = [c for c in lengths.columns if c.split("_")[0] in {"rms", "bound", "moving", "ratio"}]
    return figure, printed(lengths, columns)
