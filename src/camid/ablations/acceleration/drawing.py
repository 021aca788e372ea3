"""Ablation of assumption A4: where the measurements lie when the speed changes within the exposure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Position and threshold → line, colour, words.
DRAWN = {
    ("arc-length mean", 0.0): ("-", style.BLACK, "equation (2)"),
    ("gradient", 0.05): ("s:", style.ORANGE, "gradient, threshold 0.05"),
    ("gradient", 0.2): ("o-", style.BLUE, "gradient, threshold 0.2"),
    ("gradient", 0.5): ("^--", style.VERMILION, "gradient, threshold 0.5"),
    ("grey-level", 0.0): ("x-", style.GREY, "grey-level centroid"),
}
MOTIONS = {
    "acceleration": "change of speed / mean speed",
    "turning point": "turning point / exposure",
    "stop": "rest at the end / exposure",
}
# Thousandths of a pixel: what lies below is the rendering's own error.
DIGITS = 3


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw one row per marker and one panel per kind of motion.

    Parameters
    ----------
    table : DataFrame
        From :func:`camid.ablations.acceleration.runs.compute`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    diameters = sorted(table["diameter"].unique())
    figure, panels = plt.subplots(
        len(diameters),
        len(MOTIONS),
        figsize=(style.PAGE_WIDTH, 0.7 + 1.9 * len(diameters)),
        sharex="col",
        sharey=True,
        squeeze=False,
    )
    for row, diameter in zip(panels, diameters, strict=True):
        for axes, motion in zip(row, MOTIONS, strict=True):
            here = table[(table["motion"] == motion) & (table["diameter"] == diameter)]
            for (position, threshold), (line, colour, words) in DRAWN.items():
                runs = here[(here["position"] == position) & (here["threshold"] == threshold)].sort_values("setting")
                axes.plot(runs["setting"], runs["ahead"], line, color=colour, label=words)
        row[0].set_ylabel(f"{diameter:g} px marker:\nahead of the time mean (px)")
    for first, last, (motion, label) in zip(panels[0], panels[-1], MOTIONS.items(), strict=True):
        first.set_title(motion)
        last.set_xlabel(label)
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=5, columnspacing=1.2)
    shown = table.sort_values(["motion", "diameter", "position", "threshold", "setting"])
    return figure, shown.assign(ahead=shown["ahead"].round(DIGITS) + 0.0).drop(columns=["spread", "length"])
