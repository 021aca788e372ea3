"""Rms error against the signal-to-noise ratio, with the Cramér–Rao bound."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style
from camid.ablations.identification_drawing import SYMBOLS, printed
from camid.ablations.signal_to_noise.runs import (
    AMPLITUDE_READING,
    GROSS_MULTIPLE_OF_BOUND,
    LEFT_BOUND,
    POWER_READING,
    by_level,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOOKS = {"b0": (style.BLUE, "o", "-"), "a1": (style.VERMILION, "s", "--"), "a0": (style.BLACK, "^", ":")}


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw rms errors with their bounds, and the ratio of the two.

    Parameters
    ----------
    table : DataFrame
        From :func:`camid.ablations.signal_to_noise.runs.compute`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    levels = by_level(table)
    figure, (left, right) = plt.subplots(1, 2, figsize=(style.PAGE_WIDTH, 2.9))
    for p, (colour, symbol, line) in LOOKS.items():
        left.semilogy(levels["level"], levels[f"bound_{p}"], line, color=colour, label=f"{SYMBOLS[p]}: bound")
        left.semilogy(
            levels["level"],
            levels[f"rms_{p}"],
            symbol,
            color=colour,
            markerfacecolor="white",
            label=f"{SYMBOLS[p]}: rms error",
        )
        right.semilogy(
            levels["level"],
            levels[f"ratio_{p}"],
            line,
            marker=symbol,
            color=colour,
            markerfacecolor="white",
            label=SYMBOLS[p],
        )
    right.axhspan(
        1.0 / LEFT_BOUND, LEFT_BOUND, color="#BBBBBB", alpha=0.35, linewidth=0.0, label="counts as on the bound"
    )
    for reading in (POWER_READING, AMPLITUDE_READING):
        left.axvline(reading, color=style.GREY, linewidth=0.8, linestyle="-.")
    for reading, name in ((POWER_READING, "powers"), (AMPLITUDE_READING, "amplitudes")):
        left.annotate(
            f"10 read as {name}",
            (reading, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(3, -2),
            textcoords="offset points",
            rotation=90,
            va="top",
            color=style.GREY,
            fontsize=6.5,
        )
    left.set(xlabel="signal-to-noise ratio (dB)", ylabel="relative error (%)")
    _name_gross_failures(right, levels)
    right.set(xlabel="signal-to-noise ratio (dB)", ylabel="rms error over the bound", ylim=(0.7, 5.0))
    right.set_yticks([0.7, 1, 1.5, 2, 3, 5], ["0.7", "1", "1.5", "2", "3", "5"])
    right.minorticks_off()
    left.legend(ncols=1, loc="lower left")
    right.legend(loc="upper right")
    columns = [c for c in levels.columns if c.split("_")[0] in {"rms", "bound", "ratio", "mean"}]
    return figure, printed(levels, columns)


def _name_gross_failures(axes: Axes, levels: pd.DataFrame) -> None:
    """Say at which levels runs are left out, and why."""
    for row in levels[levels["gross"] > 0].to_dict("records"):
        worst = max(row[f"ratio_{p}"] for p in LOOKS)
        axes.annotate(
            f"{row['gross']:.0f} of {row['runs']:.0f} runs, off by more than\n"
            f"{GROSS_MULTIPLE_OF_BOUND:g} times the bound, are left out",
            (row["level"], worst),
            xytext=(10, 14),
            textcoords="offset points",
            fontsize=6.5,
            arrowprops={"arrowstyle": "-", "linewidth": 0.5, "shrinkB": 3.0},
        )
