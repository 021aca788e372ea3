"""Bias of each pairing of input and output samples against the sampling period."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style
from camid.ablations.identification_drawing import ERROR_LABELS, printed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = {0: style.VERMILION, 1: style.BLUE, 2: style.BLACK}
PARTNERS = {0: "w[k]", 1: "w[k+1]", 2: "w[k+2]"}
HOLDS = {"foh": ("FOH", "-", "o"), "zoh": ("ZOH", "--", "s")}
LARGEST_DRAWN = 45.0  # percent
# A gain that is off by more than this many percent belongs to another optimum than the true plant's: not drawn.
ANOTHER_OPTIMUM = 60.0


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the errors of b0, a1 and a0 by the default method.

    Parameters
    ----------
    table : DataFrame
        From :func:`camid.ablations.pairing.runs.compute`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    drawn = table[table["method"] == "srivc"]
    figure, panels = plt.subplots(1, 3, figsize=(style.PAGE_WIDTH, 3.1), sharey=True)
    pairings = drawn[["hold", "shift", "lag_left"]].drop_duplicates().sort_values("lag_left")
    for axes, (parameter, label) in zip(panels, ERROR_LABELS.items(), strict=True):
        axes.set(xlabel="sampling period T (ms)", title=label, ylim=(-LARGEST_DRAWN, LARGEST_DRAWN))
        for hold, shift, lag in pairings.itertuples(index=False):
            name, line, symbol = HOLDS[hold]
            runs = drawn[(drawn["hold"] == hold) & (drawn["shift"] == shift)].sort_values("period")
            runs = runs[runs["error_b0"].abs() <= ANOTHER_OPTIMUM]
            left = f"{lag:+g}".replace("-", "−")
            axes.plot(
                1e3 * runs["period"],
                runs[f"error_{parameter}"],
                line,
                marker=symbol,
                color=COLOURS[shift],
                markerfacecolor="white",
                label=f"{name}, {PARTNERS[shift]}: lag left {left} T" if lag else f"{name}, {PARTNERS[shift]}: right",
            )
            style.mark_outside(axes, 1e3 * runs["period"], runs[f"error_{parameter}"], COLOURS[shift])
    panels[0].set_ylabel("error (%)")
    handles, labels = panels[0].get_legend_handles_labels()
    handles, labels = [*handles, style.outside_handle()], [*labels, "leaves the axis here"]
    title = f"u[k] paired with (a fit whose $b_0$ is off by more than {ANOTHER_OPTIMUM:g} % is not drawn)"
    figure.legend(handles, labels, loc="outside upper center", ncols=4, title=title, columnspacing=1.2)
    return figure, printed(drawn, [f"error_{p}" for p in ERROR_LABELS])
