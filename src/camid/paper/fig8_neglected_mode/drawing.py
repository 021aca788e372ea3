"""Fig. 8: estimation errors due to a neglected mode."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from camid import plotting as style
from camid.paper.cases import with_gain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# The paper draws K, and the fit has b0 = K ω0²: both.
LABELS = {
    "K": "error in $K = b_0/a_0$ (%)",
    "b0": "error in $b_0 = K\\omega_0^2$ (%)",
    "a1": "error in $a_1 = 2\\xi\\omega_0$ (%)",
    "a0": "error in $a_0 = \\omega_0^2$ (%)",
}
LOOKS = {
    "camera-foh": ("(i) camera, FOH", style.BLUE, "-", 2.6),
    "camera-zoh": ("(ii) camera, ZOH", style.VERMILION, "--", 1.2),
    "instant-zoh": ("(iii) no camera, ZOH", style.BLACK, ":", 1.4),
}
# Percent; finer digits are those of the stopping rule and of the processor.
RESOLUTION = 1e-5


def draw(estimates: pd.DataFrame, period: float) -> tuple[Figure, pd.DataFrame]:
    """Draw the errors of K, b0, a1 and a0 against ω1.

    Parameters
    ----------
    estimates : DataFrame
        From :func:`camid.paper.fig8_neglected_mode.runs.identify_neglected_mode`.
    period : float
        T in seconds.
    """
    style.apply()
    import matplotlib.pyplot as plt

    estimates = with_gain(estimates)
    figure, panels = plt.subplots(2, 2, figsize=(style.PAGE_WIDTH, 4.6), sharex=True)
    for axes, (parameter, label) in zip(panels.flat, LABELS.items(), strict=True):
        axes.axhspan(-1.0, 1.0, color="#BBBBBB", alpha=0.35, linewidth=0.0, label="± 1 %")
        for case, (name, colour, line, width) in LOOKS.items():
            runs = estimates[estimates["case"] == case]
            axes.semilogx(runs["omega_1"], runs[f"error_{parameter}"], line, color=colour, linewidth=width, label=name)
        axes.axvline(np.pi / period, color=style.GREY, linewidth=0.8, linestyle="-.")
        axes.set_ylabel(label)
    panels[0, 0].annotate(
        "Tω$_1$ = π",
        (np.pi / period, 0.88),
        xycoords=("data", "axes fraction"),
        xytext=(-3, 0),
        textcoords="offset points",
        ha="right",
        color=style.GREY,
        fontsize=7,
    )
    low, high = estimates["omega_1"].min(), estimates["omega_1"].max()
    ticks = [v for v in (20, 30, 50, 100, 200, 300, 400) if low <= v <= high]
    for axes in panels[-1]:
        axes.set_xticks(ticks, [str(v) for v in ticks])
        axes.minorticks_off()
        axes.set(xlabel=f"$\\omega_1$ (rad/s), T = {1e3 * period:g} ms", xlim=(low, high))
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    errors = [f"error_{p}" for p in LABELS]
    table = estimates.copy()
    table[errors] = (table[errors] / RESOLUTION).round() * RESOLUTION + 0.0
    return figure, table
