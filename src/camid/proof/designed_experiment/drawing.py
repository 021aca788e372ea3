"""The picture of designed experiments: what both recordings state of the truth, and whether predictions come true."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from camid import plotting as style
from camid.proof.designed_experiment.campaign import DECIDED, EXPERIMENTS, WORDS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Evidence that the axes show, logarithmic.
LEAST, MOST = 0.1, 1e5


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
    left.axhline(DECIDED, color=style.GREY, linewidth=0.7, linestyle=(0, (1, 2)))
    left.set(
        xlabel="rigs in %, the most certain first", ylabel="weight of the right name", xlim=(0, 100), ylim=(0, 1.02)
    )
    left.legend(loc="lower left", title="second recording")
    predicted = shown["predicted_evidence"].to_numpy(float).clip(LEAST, MOST)
    for name, marker in (("designed", "o"),):
        measured = shown[f"{name}_gap"].to_numpy(float).clip(LEAST, MOST)
        good = shown[f"{name}_right"].astype(bool).to_numpy()
        right.loglog(predicted[good], measured[good], marker, color=style.BLUE, label="the right name leads")
        right.loglog(predicted[~good], measured[~good], "x", color=style.VERMILION, label="another name leads")
    right.plot([LEAST, MOST], [LEAST, MOST], color=style.GREY, linewidth=0.8, linestyle=(0, (4, 2)))
    right.set(xlabel="ΔBIC that the design predicts", ylabel="ΔBIC to the next best, measured")
    right.legend(loc="upper left")
    columns = ["number", "law", "kind", "first_truth_weight", "predicted_evidence", "predicted_weight"]
    columns += [f"{e}_{c}" for e in EXPERIMENTS for c in ("name", "weight", "truth_weight", "gap")]
    return figure, shown[columns].reset_index(drop=True)
