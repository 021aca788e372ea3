"""What was concealed and what was named, effect by effect."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid import plotting as style
from camid.effects import PLACES as EFFECT_PLACES
from camid.effects import known_effects
from camid.proof.scoring import STRONG

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# The catalogue, place by place.
PLACES = {
    place: [name for name, kind in sorted(known_effects().items()) if kind.place == place] for place in EFFECT_PLACES
}
CATALOGUE = {identifier: place for place, names in PLACES.items() for identifier in names}
NOTHING, OUTSIDE, OTHER, NO_NAME = "nothing missing", "outside the catalogue", "another name", "detected, no name"
ROWS = [*CATALOGUE, OUTSIDE, NOTHING]
COLUMNS = [*CATALOGUE, OTHER, NO_NAME, NOTHING]
SUMMARY, SUMMARY_SIZE = {OUTSIDE, OTHER, NO_NAME, NOTHING}, 1.9  # in rows or columns of an effect
FONT_SIZE = 6.3


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
    return draw_counts(count(scores))


def draw_counts(counts: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the counts of :func:`count`."""
    style.apply()
    import matplotlib as mpl
    import matplotlib.pyplot as plt

    matrix, right = _matrix(counts)
    totals = matrix.sum(axis=1)
    share = np.divide(matrix, totals[:, None], out=np.zeros(matrix.shape), where=totals[:, None] > 0)
    # Summary columns and rows are wider: they hold numbers of three digits.
    across = np.concatenate([[0.0], np.cumsum([SUMMARY_SIZE if c in SUMMARY else 1.0 for c in COLUMNS])])
    down = np.concatenate([[0.0], np.cumsum([SUMMARY_SIZE if r in SUMMARY else 1.0 for r in ROWS])])
    figure, axes = plt.subplots(figsize=(style.PAGE_WIDTH, 8.6))
    # The root of the share, from a visible shade on: few of many shows, too. Nothing is white.
    shades = mpl.colors.ListedColormap(plt.get_cmap("Blues")(np.linspace(0.18, 1.0, 256)))
    shown = np.ma.masked_where(matrix == 0, np.sqrt(share))
    axes.pcolormesh(across, down, shown, cmap=shades, vmin=0.0, vmax=1.0)
    x, y = 0.5 * (across[1:] + across[:-1]), 0.5 * (down[1:] + down[:-1])
    for i, j in zip(*np.nonzero(matrix), strict=True):
        colour = "white" if share[i, j] > 0.35 else style.BLACK
        axes.text(x[j], y[i], str(matrix[i, j]), ha="center", va="center", fontsize=FONT_SIZE, color=colour)
    for i, total in enumerate(totals):
        text = "–" if not total else f"{right[i]}/{total}" if ROWS[i] in CATALOGUE else f"{total}"
        axes.text(across[-1] + 0.5, y[i], text, va="center", fontsize=FONT_SIZE)
    axes.text(across[-1] + 0.5, -0.6, "named or\nin class,\nof all", va="bottom", fontsize=FONT_SIZE)
    _draw_places(axes, across, down)
    axes.set_xticks(x, COLUMNS, rotation=90, fontsize=FONT_SIZE)
    axes.set_yticks(y, ROWS, fontsize=FONT_SIZE)
    axes.tick_params(length=0)
    axes.grid(False)
    axes.set(xlim=(0.0, across[-1]), ylim=(down[-1], 0.0), xlabel="named by the diagnosis")
    axes.set_ylabel(f"concealed (single effects above {STRONG:g} × the detectable size)")
    return figure, counts


def _matrix(counts: pd.DataFrame) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """Recordings by row and column, and those of each row whose class holds the truth."""
    matrix = np.zeros((len(ROWS), len(COLUMNS)), int)
    right = np.zeros(len(ROWS), int)
    for entry in counts.to_dict("records"):
        i = ROWS.index(entry["truth"])
        matrix[i, COLUMNS.index(entry["named"])] += entry["recordings"]
        right[i] += entry["in_class"]
    return matrix, right


def _draw_places(axes: Axes, across: NDArray[np.float64], down: NDArray[np.float64]) -> None:
    """Fine lines between effects that lead the eye, strong ones between places, and the names of the places."""
    for lines, edges in ((axes.axhline, down), (axes.axvline, across)):
        for edge in edges:
            lines(edge, color="#E4E4E4", linewidth=0.3, zorder=0.5)
    starts = [0, *np.cumsum([len(names) for names in PLACES.values()])]
    for edge in starts[1:]:
        axes.axhline(edge, color=style.GREY, linewidth=0.7)
        axes.axvline(edge, color=style.GREY, linewidth=0.7)
    for place, start, end in zip(PLACES, starts, starts[1:], strict=False):
        if end - start > 1:
            axes.text((start + end) / 2, -0.6, place, ha="center", va="bottom", fontsize=7.0, style="italic")
