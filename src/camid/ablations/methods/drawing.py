"""Error over the Cramér–Rao bound and gross failures of every method against the sampling period."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style
from camid.ablations.identification_drawing import SYMBOLS, printed
from camid.ablations.methods.runs import by_method

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOOKS = {
    "srivc": ("safeguarded SRIVC (default)", style.BLUE, "-", "o", 6.0),
    "output-error": ("output error", style.BLACK, ":", "x", 4.0),
    "plain-srivc": ("plain SRIVC", style.VERMILION, "--", "s", 3.5),
    "state-variable-filter": ("LSSVF", style.GREEN, "-.", "^", 3.5),
    "discrete-least-squares": ("discrete-time least squares", style.GREY, "--", "D", 3.0),
    "discrete-output-error": ("discrete-time output error", style.ORANGE, "-", "v", 3.5),
}


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the rms error of each parameter (runs that are not failures) and the share of failures.

    Parameters
    ----------
    table : DataFrame
        From :func:`camid.ablations.methods.runs.compute`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    results = by_method(table)
    figure, panels = plt.subplots(2, 2, figsize=(style.PAGE_WIDTH, 4.8), sharex=True)
    failures, *errors = [panels[1, 1], panels[0, 0], panels[0, 1], panels[1, 0]]
    for method, (name, colour, line, symbol, size) in LOOKS.items():
        rows = results[results["method"] == method].sort_values("period")
        look = {"color": colour, "marker": symbol, "markersize": size, "markerfacecolor": "none", "label": name}
        for axes, p in zip(errors, SYMBOLS, strict=True):
            axes.semilogy(1e3 * rows["period"], rows[f"ratio_{p}"], line, **look)
        failures.plot(1e3 * rows["period"], 100.0 * rows["gross"] / rows["runs"], line, **look)
    for axes, symbol in zip(errors, SYMBOLS.values(), strict=True):
        axes.axhline(1.0, color=style.GREY, linewidth=0.8)
        axes.set(ylabel="rms error over bound", title=symbol, ylim=(0.5, 100.0))
        axes.set_yticks([0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0], ["0.5", "1", "2", "5", "10", "20", "50", "100"])
        axes.minorticks_off()
    failures.set(ylabel="gross failures (%)", title="failures", ylim=(-4.0, 104.0))
    for axes in panels[-1]:
        axes.set_xlabel("sampling period T (ms)")
    figure.legend(
        *failures.get_legend_handles_labels(),
        loc="outside upper center",
        ncols=3,
        title="Errors are of the runs without gross failure; where more than half of the runs fail none is drawn.",
        title_fontsize=7,
    )
    columns = [c for c in results.columns if c.split("_")[0] in {"ratio", "bias"}]
    return figure, printed(results, columns)
