"""Criteria, simulation error and determinacy against the number of poles of the model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style
from camid.ablations.model_order.runs import TRUE_POLES, by_order

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOOKS = {"one mode": (style.BLUE, "o", "-"), "two modes": (style.VERMILION, "s", "--")}


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw means over the noise samples for both plants.

    Parameters
    ----------
    table : DataFrame
        From :func:`camid.ablations.model_order.runs.compute`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    orders = by_order(table)
    figure, (criteria, errors, known) = plt.subplots(1, 3, figsize=(style.PAGE_WIDTH, 2.9))
    for plant, (colour, symbol, line) in LOOKS.items():
        rows = orders[orders["plant"] == plant].sort_values("poles")
        label = f"{plant} ({TRUE_POLES[plant]} poles)"
        look = {"color": colour, "marker": symbol, "label": label}
        criteria.plot(rows["poles"], rows["excess_bayes"], line, markerfacecolor="white", **look)
        criteria.plot(rows["poles"], rows["excess_akaike"], line, linewidth=0.8, markersize=2.5, **look)
        errors.plot(rows["poles"], 100.0 * rows["nrmse_true"], line, markerfacecolor="white", **look)
        known.plot(rows["poles"], 100.0 * rows["unknown"], line, markerfacecolor="white", **look)
    criteria.set_yscale("symlog", linthresh=10.0)
    criteria.set(ylabel="criterion less its minimum", title="Bayes (open), Akaike (small, filled)", ylim=(-0.5, 200.0))
    criteria.set_yticks([0, 2, 5, 10, 20, 50, 100, 200], ["0", "2", "5", "10", "20", "50", "100", "200"])
    criteria.minorticks_off()
    errors.set(ylabel="error of the simulated output (%)", title="against the output without noise")
    errors.set_ylim(bottom=0.0)
    known.set(ylabel="share of records (%)", title="with a coefficient undetermined", ylim=(-4.0, 104.0))
    for axes in (criteria, errors, known):
        axes.set_xticks(sorted(set(orders["poles"])))
        axes.set_xlabel("poles of the model")
    figure.legend(*errors.get_legend_handles_labels(), loc="outside upper center", ncols=2)
    # Models of too many poles end where rounding takes them: only coarse digits are the data's.
    columns = [c for c in orders.columns if orders[c].dtype.kind == "f"]
    return figure, orders.round(dict.fromkeys(columns, 3))
