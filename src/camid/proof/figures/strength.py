"""How often an effect is detected, named and placed, against its strength."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pandas as pd

from camid import plotting as style
from camid.proof.rates import STRENGTHS, by_strength
from camid.proof.scoring import STRONG
from camid.proof.targets import NAMED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Name in the scores → words, symbol, line, colour, and a shift that keeps the intervals apart.
RATES = {
    "detected": ("detected", "o", "-", style.BLACK, 0.93),
    "place_in_class": ("place right", "^", ":", style.GREEN, 0.98),
    "in_class": ("named or in a class of at most four", "s", "--", style.BLUE, 1.03),
    "top": ("named first", "x", "-.", style.VERMILION, 1.08),
}


def draw(scores: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the rates of single effects with their 95 % intervals (Wilson).

    Parameters
    ----------
    scores : DataFrame
        One row per recording, from :func:`camid.proof.scoring.score`.
    """
    return draw_rates(by_strength(scores))


def draw_rates(rates: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the rates of :func:`camid.proof.rates.by_strength`."""
    style.apply()
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(style.COLUMN_WIDTH, 4.1))
    for name, (words, symbol, line, colour, shift) in RATES.items():
        part = rates[rates["rate"] == name]
        share = 100.0 * part["share"]
        errors = [share - 100.0 * part["from"], 100.0 * part["to"] - share]
        axes.errorbar(
            part["multiple"] * shift,
            share,
            yerr=[e.clip(lower=0.0) for e in errors],
            fmt=symbol + line,
            color=colour,
            markerfacecolor="white",
            elinewidth=0.7,
            capsize=1.5,
            label=words,
        )
    for row in rates[rates["rate"] == "detected"].to_dict("records"):
        axes.annotate(f"{row['recordings']}", (row["multiple"], 103.0), ha="center", fontsize=6.0, color=style.GREY)
    axes.annotate("recordings:", (STRENGTHS[0], 108.0), fontsize=6.0, color=style.GREY, annotation_clip=False)
    look: dict[str, Any] = {"color": style.GREY, "linewidth": 0.8}
    words = f"target of “named or in a class”: {NAMED:g} %"
    axes.hlines(NAMED, STRONG, 1.2 * STRENGTHS[-1], linestyle=(0, (4, 2)), label=words, **look)
    axes.axvline(STRONG, linestyle=(0, (1, 2)), label=f"target holds from {STRONG:g} on", **look)
    axes.set(
        xscale="log",
        xlim=(STRENGTHS[0], 1.2 * STRENGTHS[-1]),
        ylim=(-3.0, 107.0),
        xlabel="strength (multiples of the detectable size)",
        ylabel="recordings with a single effect (%)",
    )
    axes.set_xticks([0.3, 1, 3, 10, 30, 100], ["0.3", "1", "3", "10", "30", "100"])
    axes.minorticks_off()
    handles, labels = axes.get_legend_handles_labels()
    order = sorted(range(len(labels)), key=lambda i: labels[i].startswith("target"))  # rates first
    figure.legend([handles[i] for i in order], [labels[i] for i in order], loc="outside lower center", ncols=1)
    return figure, rates
