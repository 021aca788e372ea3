"""Ablation of assumption A3: errors against resolution, bit depth, noise and region of interest."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Motion, centroid → line, colour, words.
MARKERS = {
    ("moving", "gradient"): ("o-", style.VERMILION, "gradient, moving"),
    ("static", "gradient"): ("D:", style.ORANGE, "gradient, static"),
    ("moving", "grey-level"): ("s-", style.BLACK, "grey-level, moving"),
    ("moving", "grey-level, black known"): ("x-", style.GREY, "grey-level, moving, black level known"),
    ("static", "grey-level"): ("^--", style.BLUE, "grey-level, static"),
}
REGION = {
    ("static", "gradient"): ("D:", style.ORANGE, "gradient"),
    ("static", "gradient, plain OpenCV"): ("x", style.BLACK, "gradient, plain OpenCV"),
    ("static", "grey-level"): ("^--", style.BLUE, "grey-level"),
    ("static", "grey-level, threshold"): ("v-", style.GREEN, "grey-level, above 5 σ"),
}
PANELS = {
    "resolution": ("marker diameter in pixels, same scene", "resolution", MARKERS),
    "bit depth": ("bits of a pixel", "bit depth", MARKERS),
    "noise": ("noise (grey levels of 8 bit)", "pixel noise", MARKERS),
    "region": ("side of the region of interest (px)", "static marker, pixel noise", REGION),
}
# Ten-thousandths of a pixel: what lies below is the rendering's own error.
DIGITS = 4


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw one panel per quality of the image.

    Parameters
    ----------
    table : DataFrame
        From :func:`camid.ablations.image_quality.runs.compute`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    table = table.assign(error=table["error"].round(DIGITS))
    figure, panels = plt.subplots(2, 2, figsize=(style.PAGE_WIDTH, 5.4), sharey=True)
    for axes, (varied, (label, title, curves)) in zip(panels.flat, PANELS.items(), strict=True):
        for (motion, centroid), (line, colour, words) in curves.items():
            runs = _runs(table, varied, motion, centroid)
            axes.plot(runs["setting"], runs["error"], line, color=colour, label=words)
        axes.set(yscale="log", ylim=(3e-4, 50.0), xlabel=label, title=title)
        axes.set_yticks([1e-3, 1e-2, 1e-1, 1.0, 1e1], ["0.001", "0.01", "0.1", "1", "10"])
        axes.minorticks_off()
    panels[0, 0].set_xscale("log")
    for axes, (varied, (_, _, curves)) in zip(panels.flat, PANELS.items(), strict=True):
        for (motion, centroid), (_, colour, _) in curves.items():
            runs = _runs(table, varied, motion, centroid)
            style.mark_outside(axes, runs["setting"], runs["error"], colour)
    panels[0, 0].set_xticks([2, 5, 10, 20, 30, 60], ["2", "5", "10", "20", "30", "60"])
    panels[0, 0].minorticks_off()
    for axes in panels[:, 0]:
        axes.set_ylabel("rms error (px)")
    panels[1, 1].legend(loc="upper left", ncols=2)
    handles, labels = panels[1, 0].get_legend_handles_labels()
    below = plt.Line2D([], [], marker="v", color=style.GREY, markersize=4.5, linestyle="none")
    words = "falls below the axis"
    figure.legend([*handles, below], [*labels, words], loc="outside upper center", ncols=3)
    return figure, table


def _runs(table: pd.DataFrame, varied: str, motion: str, centroid: str) -> pd.DataFrame:
    """Rows of one curve in the order of the setting."""
    chosen = (table["varied"] == varied) & (table["motion"] == motion) & (table["centroid"] == centroid)
    return table[chosen].sort_values("setting")
