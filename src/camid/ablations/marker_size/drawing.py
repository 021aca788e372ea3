"""Ablation of assumption A1: the shift of the gradient centroid against marker, speed and threshold."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DRAWN_DIAMETERS = {
    8.0: ("s:", style.GREY),
    15.0: ("^-.", style.GREEN),
    30.0: ("o-", style.BLUE),
    45.0: ("D--", style.VERMILION),
}
# Slower circles are straight lines to the eye, and their shift has no clear sign.
DRAWN_FREQUENCIES = {5.0: ("o-", style.BLACK), 12.0: ("s--", style.BLUE), 24.0: ("^-.", style.VERMILION)}
DRAWN_THRESHOLDS = {0.05: ("s:", style.VERMILION), 0.2: ("o-", style.BLUE), 0.5: ("^--", style.BLACK)}
# Thousandths of a pixel: what lies below is the rendering's own error.
DIGITS = 3


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the shift against threshold, and against diameter, and the threshold at which it vanishes.

    Parameters
    ----------
    table : DataFrame
        From :func:`camid.ablations.marker_size.runs.compute`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    table = table.sort_values(["frequency", "diameter", "threshold"])
    gradient, grey = (table[table["centroid"] == name] for name in ("gradient", "grey-level"))
    fastest = table["frequency"].max()
    figure, panels = plt.subplots(2, 2, figsize=(style.PAGE_WIDTH * 0.9, 5.0))
    (by_threshold, by_diameter), (by_speed, vanishing) = panels
    for diameter, (line, colour) in DRAWN_DIAMETERS.items():
        runs = gradient[(gradient["diameter"] == diameter) & (gradient["frequency"] == fastest)]
        by_threshold.plot(runs["threshold"], runs["outward"], line, color=colour, markevery=3, label=f"{diameter:g} px")
    by_threshold.axhline(0.0, color=style.GREY, linewidth=0.6)
    by_threshold.set(
        xlabel="threshold (share of the largest gradient)",
        ylabel="outward shift (px)",
        ylim=(-13.5, 12.0),
        xlim=(0.0, 1.0),
        title=f"circle at {fastest:g} Hz",
    )
    by_threshold.legend(title="gradient centroid, marker of", ncols=2, loc="upper center", handlelength=2.6)
    paper = float(table.loc[table["configured"], "diameter"].iloc[0])
    for axes, across, kept in ((by_diameter, "diameter", "frequency"), (by_speed, "frequency", "diameter")):
        at = {"frequency": fastest, "diameter": paper}[kept]
        for threshold, (line, colour) in DRAWN_THRESHOLDS.items():
            runs = gradient[(gradient["threshold"] == threshold) & (gradient[kept] == at)]
            axes.plot(runs[across], runs["outward"], line, color=colour, label=f"gradient, threshold {threshold:g}")
        runs = grey[grey[kept] == at]
        axes.plot(runs[across], runs["outward"], "x-", color=style.GREY, linewidth=0.8, label="grey-level centroid")
        axes.set(ylabel="outward shift (px)", ylim=(-12.5, 5.5))
    by_diameter.set(xlabel="marker diameter (px)", title=f"circle at {fastest:g} Hz")
    by_diameter.legend(loc="lower left")
    by_speed.set(xlabel="frequency of the circle (Hz)", title=f"marker of {paper:g} px")
    by_speed.legend(loc="lower left")
    zeros = gradient.drop_duplicates(["frequency", "diameter"])
    frequencies = [f for f in DRAWN_FREQUENCIES if f in set(zeros["frequency"])]
    for frequency in frequencies:
        runs = zeros[zeros["frequency"] == frequency]
        line, colour = DRAWN_FREQUENCIES[frequency]
        vanishing.plot(
            runs["diameter"], runs["vanishing_threshold"], line, color=colour, label=f"circle at {frequency:g} Hz"
        )
    vanishing.set(
        xlabel="marker diameter (px)",
        ylabel="threshold",
        title="threshold at which the shift vanishes",
        ylim=(0.0, 0.6),
    )
    vanishing.legend(loc="upper right")
    shown = table[(table["frequency"] == fastest) | (table["diameter"] == paper)].assign(quantity="outward shift in px")
    shown["value"] = shown["outward"]
    zeros = zeros[zeros["frequency"].isin(frequencies)].assign(quantity="vanishing threshold", centroid="gradient")
    zeros["value"] = zeros["vanishing_threshold"]
    numbers = pd.concat([shown, zeros.assign(threshold=float("nan"))])[
        ["quantity", "centroid", "frequency", "diameter", "threshold", "value"]
    ]
    return figure, numbers.assign(value=numbers["value"].round(DIGITS) + 0.0)
