"""What was concealed and what was named, effect by effect."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from camid import plotting as style
from camid.effects import PLACES as EFFECT_PLACES
from camid.effects import known_effects
from camid.proof.scoring import STRONG

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# The catalogue, place by place.
PLACES = {
    place: [name for name, kind in sorted(known_effects().items()) if kind.place == place] for place in EFFECT_PLACES
}
CATALOGUE = {identifier: place for place, names in PLACES.items() for identifier in names}
NOTHING, OUTSIDE, OTHER, NO_NAME = "nothing missing", "outside the catalogue", "another name", "detected, no name"


def count(scores: pd.DataFrame) -> pd.DataFrame:
    """How often each effect was given each name.

    Parameters
    ----------
    scores : DataFrame
        Single effects of at least three times the detectable size (or without such a size), effects outside the
        catalogue and recordings with nothing missing are counted.

    Returns
    -------
    DataFrame
        ``truth``, ``named``, ``recordings``, and ``in_class``: those of them whose class holds the truth.
    """
    single = (scores["kind"] == "single") & ~(scores["multiple"] < STRONG)
    part = scores[single | scores["kind"].isin(["none", "outside"])]
    truth = part["truth"].where(part["kind"] == "single", part["kind"].map({"none": NOTHING, "outside": OUTSIDE}))
    # An effect that is named by a weaker entry of the diagnosis is named.
    named = part["named"].where(~(part["top"] & (part["kind"] == "single")), part["truth"])
    silent = pd.Series(np.where(part["detected"], NO_NAME, NOTHING), index=part.index)
    named = named.where(named.isin(CATALOGUE), OTHER).where(part["named"] != "", silent)
    table = pd.DataFrame({"truth": truth, "named": named, "in_class": part["in_class"]})
    grouped = table.groupby(["truth", "named"], sort=True)["in_class"].agg(["size", "sum"]).reset_index()
    return grouped.rename(columns={"size": "recordings", "sum": "in_class"})


def draw(scores: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the matrix, grouped by place, with the share named or in a class at its right.

    Parameters
    ----------
    scores : DataFrame
        One row per recording, from :func:`camid.proof.scoring.score`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    counts = count(scores)
    rows = [*CATALOGUE, OUTSIDE, NOTHING]
    columns = [*CATALOGUE, OTHER, NO_NAME, NOTHING]
    matrix = np.zeros((len(rows), len(columns)), int)
    right = np.zeros(len(rows), int)
    for entry in counts.to_dict("records"):
        i = rows.index(entry["truth"])
        matrix[i, columns.index(entry["named"])] += entry["recordings"]
        right[i] += entry["in_class"]
    totals = matrix.sum(axis=1)
    share = np.divide(matrix, totals[:, None], out=np.zeros(matrix.shape), where=totals[:, None] > 0)
    figure, axes = plt.subplots(figsize=(style.PAGE_WIDTH, 7.3))
    axes.imshow(share, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    for i, j in zip(*np.nonzero(matrix), strict=True):
        colour = "white" if share[i, j] > 0.6 else style.BLACK
        axes.text(j, i, str(matrix[i, j]), ha="center", va="center", fontsize=5.5, color=colour)
    for i, total in enumerate(totals):
        text = "–" if not total else f"{right[i]}/{total}" if rows[i] in CATALOGUE else f"{total}"
        axes.text(len(columns) - 0.3, i, text, va="center", fontsize=5.5)
    axes.text(len(columns) - 0.3, -1.1, "named or\nin class", va="bottom", fontsize=5.5)
    edges = np.cumsum([len(names) for names in PLACES.values()]) - 0.5
    for edge in edges:
        axes.axhline(edge, color=style.GREY, linewidth=0.6)
        axes.axvline(edge, color=style.GREY, linewidth=0.6)
    starts = [-0.5, *edges[:-1]]
    for place, start, edge in zip(PLACES, starts, edges, strict=True):
        if edge - start > 1.5:
            axes.text((start + edge) / 2, -1.1, place, ha="center", va="bottom", fontsize=6.5, style="italic")
    axes.set_xticks(range(len(columns)), columns, rotation=90, fontsize=5.5)
    axes.set_yticks(range(len(rows)), rows, fontsize=5.5)
    axes.tick_params(length=0)
    axes.grid(False)
    axes.set(
        xlabel="named by the diagnosis",
        ylabel=f"concealed (single effects above {STRONG:g} × the detectable size)",
    )
    return figure, counts
