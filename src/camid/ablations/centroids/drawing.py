"""Ablation of the two centroids: errors against speed in clean, noisy, lit and saturated images."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GRADIENT, FIXED = "gradient", "gradient, fixed threshold"
GREY, REMOVED, CUT = "grey-level", "grey-level, border removed", "grey-level, border removed, threshold"
# A colour stands for a centroid in all panels.
COLOURS = {GRADIENT: style.VERMILION, FIXED: style.ORANGE, GREY: style.BLUE, REMOVED: style.BLACK, CUT: style.GREY}
# Panel → condition, centroid, line, words.
PANELS: dict[str, tuple[tuple[str, str, str, str], ...]] = {
    "clean": (
        ("8 bit", GRADIENT, "o-", "gradient, relative threshold"),
        ("8 bit", FIXED, "D:", "gradient, fixed threshold"),
        ("8 bit, truncated", GREY, "^--", "grey-level, 8 bit truncated"),
        ("8 bit", GREY, "s-", "grey-level, 8 bit rounded"),
    ),
    "pixel noise": (
        ("noise", GRADIENT, "o-", "gradient, relative threshold"),
        ("noise", FIXED, "D:", "gradient, fixed threshold"),
        ("noise", GREY, "s-", "grey-level, noise clipped at 0"),
        ("noise", CUT, "x-.", "grey-level, above 5 σ"),
        ("noise, black level", REMOVED, "v-", "grey-level, black level raised, border removed"),
    ),
    "background light": (
        ("uniform light", GRADIENT, "o-", "gradient, relative threshold, uniform light"),
        ("uniform light", GREY, "s-", "grey-level, uniform light left in"),
        ("ramp of light", REMOVED, "^--", "grey-level, border removed, ramp of light"),
        ("uniform light", REMOVED, "v-", "grey-level, border removed, uniform light"),
    ),
    "saturation": (),
}
SATURATED = ("s-", "^--", "D:", "o-.")
# Ten-thousandths of a pixel: what lies below is the rendering's own error.
DIGITS = 4


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw one panel per way of spoiling the image.

    Parameters
    ----------
    table : DataFrame
        From :func:`camid.ablations.centroids.runs.compute`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    saturated = [name for name in dict.fromkeys(table["condition"]) if "full scale" in name]
    drawn = {
        **PANELS,
        "saturation": tuple(
            (name, GREY, line, f"grey-level, {name}") for name, line in zip(saturated, SATURATED, strict=False)
        ),
    }
    figure, panels = plt.subplots(2, 2, figsize=(style.PAGE_WIDTH, 6.2), sharex=True, sharey=True)
    for axes, (title, curves) in zip(panels.flat, drawn.items(), strict=True):
        for condition, centroid, line, words in curves:
            runs = table[(table["condition"] == condition) & (table["centroid"] == centroid)].sort_values("frequency")
            axes.plot(runs["frequency"], runs["error"], line, color=COLOURS[centroid], label=words)
        axes.set(yscale="log", ylim=(3e-4, 60.0))
        axes.set_yticks([1e-3, 1e-2, 1e-1, 1.0, 1e1], ["0.001", "0.01", "0.1", "1", "10"])
        axes.minorticks_off()
        legend = axes.legend(
            loc="lower left", bbox_to_anchor=(0.0, 1.0), handlelength=2.6, labelspacing=0.3, title=title
        )
        legend.set_alignment("left")
    for axes in panels[-1]:
        axes.set_xlabel("frequency of the circle (Hz)")
    for axes in panels[:, 0]:
        axes.set_ylabel("rms error (px)")
    return figure, table.assign(error=table["error"].round(DIGITS)).drop(columns="peak")
