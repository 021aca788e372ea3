"""Whether stated weights are right as often as they say."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style
from camid.proof.rates import reliability

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw(weights: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the frequency of being the truth against the stated weight, with 95 % intervals (Wilson).

    Parameters
    ----------
    weights : DataFrame
        One row per member of a class: ``weight``, ``right``.
    """
    style.apply()
    import matplotlib.pyplot as plt

    table = reliability(weights)
    figure, axes = plt.subplots(figsize=(style.COLUMN_WIDTH, 3.1))
    axes.plot([0.0, 1.0], [0.0, 1.0], color=style.GREY, linewidth=0.8, linestyle=(0, (4, 2)), label="as stated")
    axes.errorbar(
        table["weight"],
        table["share"],
        yerr=[
            (table["share"] - table["from"]).clip(lower=0.0),
            (table["to"] - table["share"]).clip(lower=0.0),
        ],
        fmt="o-",
        color=style.BLUE,
        markerfacecolor="white",
        elinewidth=0.7,
        capsize=1.5,
        label="measured",
    )
    for row in table.to_dict("records"):
        # Beside the point on its own side of the diagonal, and so away from that and from the line.
        left = row["share"] >= row["weight"]
        axes.annotate(
            f"{row['members']}",
            (row["weight"], row["share"]),
            xytext=(-5 if left else 5, 3 if left else -8),
            textcoords="offset points",
            ha="right" if left else "left",
            fontsize=6.0,
            color=style.GREY,
        )
    axes.set(
        xlim=(-0.06, 1.09),
        ylim=(-0.04, 1.04),
        xlabel="stated weight (with the number of class members)",
        ylabel="frequency of being the truth",
    )
    axes.legend(loc="upper left")
    return figure, table
