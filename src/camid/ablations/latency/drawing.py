"""Bias against a latency that is not declared."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style
from camid.ablations.identification_drawing import ERROR_LABELS, printed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = (style.BLUE, style.VERMILION, style.BLACK, style.GREEN, style.ORANGE)
SYMBOLS = ("o", "s", "^", "x", "v")
LARGEST_DRAWN = 62.0  # percent; beyond it the fit has left the true plant's optimum


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the errors of b0, a1 and a0 against the undeclared latency, with the projection of first order.

    Parameters
    ----------
    table : DataFrame
        From :func:`camid.ablations.latency.runs.compute`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 3, figsize=(style.PAGE_WIDTH, 2.9), sharey=True)
    undeclared, declared = table[~table["declared"]], table[table["declared"]]
    for axes, (parameter, label) in zip(panels, ERROR_LABELS.items(), strict=True):
        axes.set(xlabel="latency ℓ/T", title=label, ylim=(-LARGEST_DRAWN, LARGEST_DRAWN))
        column = f"error_{parameter}"
        axes.plot(declared["latency"], declared[column], "D", color=style.GREY, markersize=2.5, label="declared, any T")
        for (period, rows), colour, symbol in zip(undeclared.groupby("period"), COLOURS, SYMBOLS, strict=False):
            runs = rows.sort_values("latency")
            name = f"T = {1e3 * float(str(period)):g} ms"
            axes.plot(
                runs["latency"],
                runs[column],
                symbol,
                color=colour,
                markerfacecolor="white",
                label=f"undeclared, {name}",
            )
            style.mark_outside(axes, runs["latency"], runs[column], colour, joined=False)
            axes.plot(runs["latency"], runs[f"first_order_{parameter}"], "-", color=colour, linewidth=0.9)
            axes.plot(runs["latency"], runs["white_input"], ":", color=colour, linewidth=0.9)
    panels[0].set_ylabel("error (%)")
    handles, names = panels[0].get_legend_handles_labels()
    for line, name in (("-", "first order, this excitation"), (":", "first order, white input: −2ξω$_0$ℓ")):
        handles += panels[0].plot([], [], line, color=style.GREY, linewidth=0.9)
        names.append(name)
    handles.append(style.outside_handle())
    names.append("undeclared, beyond the axis")
    figure.legend(handles, names, loc="outside upper center", ncols=3)
    columns = [f"{kind}_{p}" for kind in ("error", "first_order") for p in ERROR_LABELS]
    return figure, printed(table, columns)
