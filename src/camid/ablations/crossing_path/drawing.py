"""Ablation of assumption A2: distance from equation (1) against the passes of a closed path in an exposure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Diameter and threshold → line, colour.
DRAWN = {
    (8.0, 0.2): ("o-", style.BLUE),
    (8.0, 0.5): ("s--", style.VERMILION),
    (30.0, 0.2): ("^-.", style.BLACK),
}
TITLES = {"circle": "circle", "eight": "figure of eight"}
# Thousandths of a pixel: what lies below is the rendering's own error.
DIGITS = 3


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw one panel per path.

    Parameters
    ----------
    table : DataFrame
        From :func:`camid.ablations.crossing_path.runs.compute`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    table = table.sort_values(["path", "diameter", "threshold", "passes"])
    figure, panels = plt.subplots(1, 2, figsize=(style.PAGE_WIDTH, 3.0), sharey=True)
    for axes, (path, title) in zip(panels, TITLES.items(), strict=True):
        here = table[table["path"] == path]
        for (diameter, threshold), (line, colour) in DRAWN.items():
            runs = here[(here["diameter"] == diameter) & (here["threshold"] == threshold)]
            label = f"gradient, {diameter:g} px marker, threshold {threshold:g}"
            axes.plot(runs["passes"], runs["distance"], line, color=colour, markersize=2.8, label=label)
        runs = here[(here["diameter"] == here["diameter"].min()) & (here["centroid"] == "grey-level")]
        axes.plot(
            runs["passes"],
            runs["distance"],
            "x",
            color=style.GREY,
            label=f"grey-level, {runs['diameter'].iloc[0]:g} px marker",
            clip_on=False,
        )
        axes.axvline(1.0, color=style.GREY, linewidth=0.8)
        axes.annotate(
            "covers itself →", (1.0, 90.0), xytext=(3, 0), textcoords="offset points", color=style.GREY, fontsize=7
        )
        if path == "eight":
            axes.axvline(0.5, color=style.GREY, linewidth=0.8, linestyle="--")
            axes.annotate(
                "crosses\nitself",
                (0.5, 62.0),
                xytext=(3, 0),
                textcoords="offset points",
                color=style.GREY,
                fontsize=7,
            )
        axes.set(xlabel="passes in an exposure", title=title, ylim=(0.0, 120.0))
        axes.set_yscale("symlog", linthresh=1.0)
        axes.set_yticks([0.0, 0.5, 1.0, 3.0, 10.0, 30.0, 100.0], ["0", "0.5", "1", "3", "10", "30", "100"])
        axes.minorticks_off()
    panels[0].set_ylabel("distance from (1) (px)")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return figure, table.assign(distance=table["distance"].round(DIGITS) + 0.0)
