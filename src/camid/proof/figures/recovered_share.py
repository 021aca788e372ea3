"""Share of the avoidable error that the improved model avoids on recordings it was not fitted to."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from camid import plotting as style
from camid.proof.scoring import STRONG

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PANELS = {"same_kind": "fresh input of the same kind", "double_amplitude": "twice the amplitude"}
LOWEST, HIGHEST = -0.25, 1.15
STRONGEST = 105.0  # where huge effects are drawn
TARGET = 0.95


def draw(scores: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the share against the strength, one panel per kind of held-out recording.

    Parameters
    ----------
    scores : DataFrame
        With ``kind``, ``multiple``, ``in_class``, ``share_same_kind`` and ``share_double_amplitude``, from
        :func:`camid.proof.score_table.recovered_shares`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    known = scores[scores["share_same_kind"].notna() & scores["multiple"].notna()]
    place = known["multiple"].clip(upper=STRONGEST)
    figure, panels = plt.subplots(1, 2, figsize=(style.PAGE_WIDTH, 3.4), sharey=True)
    for axes, (name, kind) in zip(panels, PANELS.items(), strict=True):
        shares, title = known[f"share_{name}"], kind
        outside = known["kind"] == "outside"
        for chosen, symbol, colour, face, words in (
            (outside, "x", style.GREY, style.GREY, "laws outside the catalogue"),
            (~outside & known["in_class"], "o", style.BLUE, style.BLUE, "all effects named or in a class"),
            (~outside & ~known["in_class"], "s", style.VERMILION, "white", "not all"),
        ):
            drawn = shares[chosen].clip(LOWEST, HIGHEST)
            axes.plot(place[chosen], drawn, symbol, color=colour, markerfacecolor=face, markersize=3, label=words)
        below = shares < LOWEST
        axes.plot(
            place[below],
            np.full(int(below.sum()), LOWEST),
            "v",
            color=style.BLACK,
            clip_on=False,
            label=f"below −{-LOWEST:g}",
        )
        strong = shares[~outside & (known["multiple"] >= STRONG)].dropna()
        if len(strong):
            middle = float(np.median(strong))
            words = f"their median from {STRONG:g} on"
            axes.hlines(middle, STRONG, 110.0, color=style.BLACK, linewidth=1.6, label=words)
            title = f"{kind}\nmedian {middle:.3f} of {len(strong)} in the catalogue, from {STRONG:g} on"
        look: dict[str, Any] = {"color": style.BLACK, "linewidth": 0.9}
        axes.axhline(TARGET, linestyle=(0, (4, 2)), label=f"target of the median: {TARGET:g}", **look)
        axes.axvline(STRONG, linestyle=(0, (1, 2)), label=f"target holds from {STRONG:g} on", **look)
        axes.set(
            title=title,
            xscale="log",
            xlim=(0.25, 110.0),
            ylim=(LOWEST, HIGHEST),
            xlabel="strength (multiples of the detectable size)",
        )
        axes.set_xticks([0.3, 1, 3, 10, 30, 100], ["0.3", "1", "3", "10", "30", "100"])
        axes.minorticks_off()
    panels[0].set_ylabel("share of the avoidable error recovered")
    figure.legend(*panels[1].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    columns = ["index", "kind", "truth", "multiple", "in_class"]
    columns += [f"{quantity}_{name}" for name in PANELS for quantity in ("refitted", "improved", "floor", "share")]
    return figure, known[columns].reset_index(drop=True)
