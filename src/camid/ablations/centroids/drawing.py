"""Ablation of the two centroids: errors against speed in clean, noisy, lit and saturated images."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GRADIENT, FIXED = "gradient", "gradient, fixed threshold"
GREY, REMOVED, CUT = "grey-level", "grey-level, border removed", "grey-level, border removed, threshold"
# Panel → condition, centroid, line, colour, words.
PANELS: dict[str, tuple[tuple[str, str, str, str, str], ...]] = {
    "clean": (
        ("8 bit", GRADIENT, "o-", style.VERMILION, "gradient, relative threshold"),
        ("8 bit", FIXED, "D:", style.ORANGE, "gradient, fixed threshold"),
        ("8 bit, truncated", GREY, "^--", style.BLUE, "grey-level, 8 bit truncated"),
        ("8 bit", GREY, "s-", style.BLACK, "grey-level, 8 bit rounded"),
    ),
    "pixel noise": (
        ("noise", GRADIENT, "o-", style.VERMILION, "gradient, relative threshold"),
        ("noise", FIXED, "D:", style.ORANGE, "gradient, fixed threshold"),
        ("noise", GREY, "^--", style.BLUE, "grey-level, noise clipped at 0"),
        ("noise", CUT, "x-.", style.GREY, "grey-level, above 5 σ"),
        ("noise, black level", REMOVED, "s-", style.BLACK, "grey-level, black level raised"),
    ),
    "background light": (
        ("uniform light", GRADIENT, "o-", style.VERMILION, "gradient, uniform light"),
        ("ramp of light", REMOVED, "D:", style.ORANGE, "grey-level, ramp, border removed"),
        ("uniform light", GREY, "^--", style.BLUE, "grey-level, uniform, left in"),
        ("uniform light", REMOVED, "s-", style.BLACK, "grey-level, uniform, border removed"),
    ),
    "saturation": (),
}
SATURATED = (("s-", style.BLACK), ("^--", style.BLUE), ("D:", style.ORANGE), ("o-", style.VERMILION))
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
            (name, GREY, *look, f"grey-level, {name}") for name, look in zip(saturated, SATURATED, strict=False)
        ),
    }
    figure, panels = plt.subplots(2, 2, figsize=(style.PAGE_WIDTH, 5.6), sharex=True, sharey=True)
    for axes, (title, curves) in zip(panels.flat, drawn.items(), strict=True):
        for condition, centroid, line, colour, words in curves:
            runs = table[(table["condition"] == condition) & (table["centroid"] == centroid)].sort_values("frequency")
            axes.plot(runs["frequency"], runs["error"], line, color=colour, label=words)
        axes.set(yscale="log", ylim=(3e-4, 6e4), title=title)
        axes.set_yticks([1e-3, 1e-2, 1e-1, 1.0, 1e1, 1e2], ["0.001", "0.01", "0.1", "1", "10", "100"])
        axes.minorticks_off()
        axes.legend(loc="upper left", handlelength=2.6, labelspacing=0.3)
    for axes in panels[-1]:
        axes.set_xlabel("frequency of the circle (Hz)")
    for axes in panels[:, 0]:
        axes.set_ylabel("rms error (px)")
    return figure, table.assign(error=table["error"].round(DIGITS)).drop(columns="peak")
