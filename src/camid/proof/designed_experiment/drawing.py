"""The picture of designed experiments: what both recordings state of the truth, and whether predictions come true."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from camid import plotting as style
from camid.proof.designed_experiment.campaign import DECIDED, EXPERIMENTS, WORDS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Least evidence that the axes show, logarithmic; and the largest, as a multiple of what there is.
LEAST, MORE = 0.1, 2.0


def draw(rows: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the weight of the right name after each experiment, and predicted against measured evidence.

    Parameters
    ----------
    rows : DataFrame
        Of :func:`camid.proof.designed_experiment.campaign.campaign`.

    Returns
    -------
    Figure, DataFrame
        The table has the rigs of the figure, a row each.
    """
    style.apply()
    import matplotlib.pyplot as plt

    shown = rows[rows["open"].astype("boolean").fillna(False) & (rows["truth"] != "") & (rows["failure"] == "")]
    figure, (left, right) = plt.subplots(1, 2, figsize=(style.PAGE_WIDTH, 2.9))
    lines = {"designed": ("-", style.BLUE), "repeated": ("--", style.VERMILION)}
    for name in EXPERIMENTS:
        values = np.sort(shown[f"{name}_truth_weight"].to_numpy(float))[::-1]
        share = np.arange(1, len(values) + 1) / max(len(values), 1)
        line, colour = lines[name]
        left.step(100.0 * share, values, line, where="pre", color=colour, label=WORDS[name])
    decided = f"{100.0 * DECIDED:.0f} %: decided"
    left.axhline(DECIDED, color=style.GREY, linewidth=0.7, linestyle=(0, (1, 2)), label=decided)
    left.set(
        xlabel="rigs in %, the most certain first", ylabel="weight of the right name", xlim=(0, 100), ylim=(0, 1.02)
    )
    left.legend(loc="lower left", title="second recording")
    predicted = shown["predicted_evidence"].to_numpy(float).clip(LEAST)
    measured = shown["designed_gap"].to_numpy(float).clip(LEAST)
    good = shown["designed_right"].astype(bool).to_numpy()
    right.loglog(predicted[good], measured[good], "o", color=style.BLUE, label="the right name leads")
    right.loglog(predicted[~good], measured[~good], "x", color=style.VERMILION, label="another name leads")
    most = MORE * float(np.nanmax([predicted, measured], initial=1.0))
    dashed: dict[str, Any] = {"color": style.GREY, "linewidth": 0.8, "linestyle": (0, (4, 2))}
    right.plot([LEAST, most], [LEAST, most], label="as predicted", **dashed)
    span = (LEAST / MORE, most)
    right.set(
        xlabel=f"ΔBIC that the design predicts (at least {LEAST:g})",
        ylabel=f"measured, to the next best (at least {LEAST:g})",
        xlim=span,
        ylim=span,
    )
    right.legend(loc="lower right")
    columns = ["number", "law", "kind", "first_truth_weight", "predicted_evidence", "predicted_weight"]
    columns += [f"{e}_{c}" for e in EXPERIMENTS for c in ("name", "weight", "truth_weight", "gap")]
    return figure, shown[columns].reset_index(drop=True)
