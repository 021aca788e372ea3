"""Share of the error that is recovered under each law outside the catalogue, on recordings that were not fitted."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOWEST, HIGHEST = -0.1, 1.04
# Median and lower quartile that were asked for.
TARGETS = (0.9, 0.7)
KINDS = (
    ("o", style.BLUE, style.BLUE, "variables right"),
    ("s", style.VERMILION, "white", "variables wrong"),
)


def draw(rows: pd.DataFrame) -> Figure:
    """Draw one row per law, sorted by the median share, and all shares together as a cumulated frequency.

    Parameters
    ----------
    rows : DataFrame
        Of :func:`camid.proof.unlisted.table.judged`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    under = rows[rows["missing"]].assign(recovered=lambda t: t["recovered"].fillna(0.0))
    laws = list(under.groupby("law")["recovered"].median().sort_values().index)
    figure, (axes, whole) = plt.subplots(
        1, 2, figsize=(style.PAGE_WIDTH, 1.0 + 0.155 * len(laws)), width_ratios=[2.2, 1.0]
    )
    for right, (symbol, colour, face, words) in zip((True, False), KINDS, strict=True):
        part = under[under["variables_right"] == right]
        drawn = part["recovered"].clip(LOWEST)
        places = [laws.index(law) for law in part["law"]]
        axes.plot(drawn, places, symbol, color=colour, markerfacecolor=face, label=words, clip_on=False)
    written = under[under["formula_right"]]
    axes.plot(
        written["recovered"].clip(LOWEST),
        [laws.index(law) for law in written["law"]],
        "o",
        color=style.BLACK,
        markerfacecolor="none",
        markersize=6.5,
        markeredgewidth=0.7,
        label="formula right in form",
        clip_on=False,
    )
    axes.set_yticks(range(len(laws)), laws, fontsize=6.5)
    axes.set(ylim=(-0.7, len(laws) - 0.3), xlabel="share of the error recovered\non another recording")
    shares = under["recovered"].clip(LOWEST).sort_values()
    whole.step(shares, [100.0 * (i + 1) / len(shares) for i in range(len(shares))], where="post", color=style.BLUE)
    for target, level in zip(TARGETS, (50.0, 25.0), strict=True):
        whole.plot([target, target], [0.0, level], color=style.GREY, linestyle=(0, (4, 2)), linewidth=0.9)
        whole.plot(target, level, "v", color=style.BLACK, markersize=4)
        whole.annotate(
            f"asked for: at most\n{level:g} % below {target:g}",
            (target, level),
            xytext=(-6, 6),
            textcoords="offset points",
            ha="right",
            fontsize=6.0,
        )
    whole.set(xlabel="share of the error recovered", ylabel="recordings with at most that share (%)", ylim=(0.0, 100.0))
    for panel in (axes, whole):
        panel.set_xlim(LOWEST, HIGHEST)
        panel.set_xticks([0.0, 0.25, 0.5, 0.75, 1.0], ["0", "0.25", "0.5", "0.75", "1"])
    axes.set_xticks([LOWEST, *axes.get_xticks()], [f"≤ −{-LOWEST:g}", "0", "0.25", "0.5", "0.75", "1"])
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure
