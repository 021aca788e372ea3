"""Ablation of the rolling shutter: models of the measurement in images, and bias in identification."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MODELS = {
    "time of the middle row": ("^:", style.GREY),
    "row of the measurement": ("s--", style.VERMILION),
    "row at begin and end": ("o-", style.BLUE),
}
LABELS = {"b0": "$b_0$", "a1": "$a_1$", "a0": "$a_0$"}
PERIODS = (("o", style.ORANGE), ("s", style.VERMILION), ("^", style.BLUE))
# Percent and px: noise-free errors below are rounding.
PERCENT_DIGITS, PIXEL_DIGITS = 5, 4


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the models' distances above, the bias below.

    Parameters
    ----------
    table : DataFrame
        From :func:`camid.ablations.rolling_shutter.runs.compute`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    figure = plt.figure(figsize=(style.PAGE_WIDTH, 5.4))
    above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=[1.0, 1.05])[:, 0]
    panels = above.subplots(1, 3, sharey=True)
    speed, sizes = (table[table["part"] == part] for part in ("speed", "diameter"))
    for axes, exposure in zip(panels, sorted(speed["exposure"].unique(), reverse=True), strict=False):
        runs = speed[speed["exposure"] == exposure]
        _models(axes, runs, "frequency")
        title = f"{runs['diameter'].iloc[0]:g} px marker, exposure {1e3 * exposure:g} ms"
        axes.set(xlabel="frequency of the circle (Hz)", title=title)
    _models(panels[2], sizes, "diameter")
    title = f"{sizes['frequency'].iloc[0]:g} Hz, exposure {1e3 * sizes['exposure'].iloc[0]:g} ms"
    panels[2].set(xlabel="marker diameter (px)", title=title)
    panels[0].set_ylabel("distance from the\ngrey-level centroid (px)")
    above.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)

    panels = below.subplots(1, 3, sharey=True)
    runs = table[table["part"] == "identification"].sort_values("readout")
    periods = sorted(runs["period"].unique())
    for axes, (parameter, label) in zip(panels, LABELS.items(), strict=True):
        column = f"error_{parameter}"
        for period, (symbol, colour) in zip(periods, PERIODS, strict=False):
            for declared, line, face in (("no latency", "-", colour), ("mean latency", "--", "white")):
                chosen = (runs["period"] == period) & (runs["declared"] == declared)
                along = runs[chosen & (runs["motion"] == "along the rows")]
                words = f"T = {period:g} s, {declared}"
                axes.plot(
                    along["readout"],
                    along[column],
                    line,
                    marker=symbol,
                    color=colour,
                    markerfacecolor=face,
                    label=words,
                )
        fixed = runs[(runs["period"] == periods[-1]) & (runs["declared"] == "no latency")]
        fixed = fixed[fixed["motion"] == "at the middle row"]
        words = f"T = {periods[-1]:g} s, no latency, fixed row"
        axes.plot(fixed["readout"], fixed[column], "x", color=style.BLACK, markersize=5, label=words)
        axes.set(xlabel="readout of all rows / T", title=f"error in {label}")
    panels[0].set_ylabel("error (%)")
    below.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=4, columnspacing=1.2)

    errors = [f"error_{parameter}" for parameter in LABELS]
    table = table.drop(columns="converged")
    table[[*errors, "residual"]] = table[[*errors, "residual"]].round(PERCENT_DIGITS) + 0.0
    return figure, table.assign(distance=table["distance"].round(PIXEL_DIGITS))


def _models(axes: Axes, runs: pd.DataFrame, across: str) -> None:
    """Distance of each model against a column."""
    for model, (line, colour) in MODELS.items():
        curve = runs[runs["model"] == model].sort_values(across)
        axes.plot(curve[across], curve["distance"], line, color=colour, label=model)
    axes.set(yscale="log", ylim=(5e-4, 60.0))
    axes.set_yticks([1e-3, 1e-2, 1e-1, 1.0, 1e1], ["0.001", "0.01", "0.1", "1", "10"])
    axes.minorticks_off()
