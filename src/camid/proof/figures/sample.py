"""A small sample of the sealed proof, recording by recording."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from camid import plotting as style
from camid.proof.scoring import STRONG

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Outcome → symbol, colour, face.
OUTCOMES = {
    "right": ("o", style.BLUE, style.BLUE),
    "right, in a class": ("o", style.BLUE, "white"),
    "right, with a wrong name besides": ("D", style.ORANGE, style.ORANGE),
    "a weaker one not named": ("^", style.BLUE, "white"),
    "outside the catalogue, no confident claim": ("P", style.GREY, style.GREY),
    "not (all) named": ("s", style.ORANGE, "white"),
    "not detected": ("v", style.BLACK, "white"),
    "wrong": ("X", style.VERMILION, style.VERMILION),
}
NO_STRENGTH, STRONGEST = 0.14, 105.0  # where recordings without an effect, and with huge ones, are drawn
INVISIBLE = 1e-3
ORDER = ("none", "invisible", "single", "several", "outside")


def outcome(row: Mapping[Any, Any]) -> str:
    """What became of a recording, in a few words.

    Of physics outside the catalogue nothing may be said with confidence.
    """
    if row["kind"] in {"none", "invisible"}:
        return "wrong" if row["false_alarm"] else "right"
    if row["verdict"] == "adequate":
        return "not detected"
    if row["kind"] == "outside":
        return "wrong" if row["confidently_wrong"] else "outside the catalogue, no confident claim"
    # Of several effects those that are too weak to show need not be named, but what is not named is not right.
    enough = row["kind"] == "several" and row["strong"] > 0
    if row["in_class"] or (enough and row["strong_in_class"] == row["strong"]):
        return _named(row)
    return "wrong" if row["wrong_names"] else "not (all) named"


def _named(row: Mapping[Any, Any]) -> str:
    """What became of a recording whose effects, or the strong ones of them, were named."""
    if row["wrong_names"]:
        return "right, with a wrong name besides"
    if not row["in_class"]:
        return "a weaker one not named"
    return "right" if row["top"] else "right, in a class"


def draw(scores: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw one line per recording: what was concealed, how strong, what was said.

    Parameters
    ----------
    scores : DataFrame
        One row per recording, from :func:`camid.proof.scoring.score`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    rank = scores["kind"].map(ORDER.index)
    ordered = scores.assign(rank=rank).sort_values(["rank", "multiple", "index"], ascending=[True, False, True])
    records = ordered.to_dict("records")
    figure, axes = plt.subplots(figsize=(style.PAGE_WIDTH, 0.75 + 0.17 * len(records)))
    drawn = []
    for line, row in enumerate(records):
        found = outcome(row)
        symbol, colour, face = OUTCOMES[found]
        # Nothing missing has no strength; noise is measured by no multiple.
        place = NO_STRENGTH if np.isnan(row["multiple"]) else np.clip(row["multiple"], NO_STRENGTH, STRONGEST)
        axes.plot(place, line, symbol, color=colour, markerfacecolor=face, markersize=5, clip_on=False)
        said = row["verdict"] + (f": {row['names']}" if row["names"] else "")
        axes.annotate(
            said, (1.02, line), xycoords=("axes fraction", "data"), va="center", fontsize=6.5, annotation_clip=False
        )
        drawn.append({"concealed": row["truth"] or "nothing missing", "outcome": found})
    axes.set_yticks(range(len(records)), [d["concealed"] for d in drawn], fontsize=6.5)
    axes.set_ylim(len(records) - 0.4, -0.6)
    strong = axes.axvline(STRONG, color=style.GREY, linewidth=0.8, linestyle=(0, (1, 2)))
    strong.set_label(f"{STRONG:g} × the detectable size: strong")
    edges = np.flatnonzero(np.diff(ordered["rank"].to_numpy())) + 0.5
    for edge in edges:
        axes.axhline(edge, color=style.GREY, linewidth=0.6)
    axes.set(
        xscale="log",
        xlim=(0.1, 110.0),
        xlabel="strength of the strongest effect\n(multiples of the detectable size; –: none)",
        title="strength",
    )
    axes.set_xticks([NO_STRENGTH, 0.3, 1, 3, 10, 30, 100], ["–", "0.3", "1", "3", "10", "30", "100"])
    axes.minorticks_off()
    # On the height of the title, which stands six points above the axes.
    above: dict[str, Any] = {"xycoords": "axes fraction", "xytext": (0, 6), "textcoords": "offset points"}
    axes.annotate("concealed", (-0.06, 1.0), ha="right", **above)
    axes.annotate("said", (1.02, 1.0), ha="left", **above)
    handles = [
        plt.Line2D([], [], marker=s, color=c, markerfacecolor=f, linestyle="", label=words)
        for words, (s, c, f) in OUTCOMES.items()
    ]
    handles.append(strong)
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    columns = ["index", "kind", "multiple", "snr_db", "verdict", "names", "named_place"]
    numbers = ordered[columns].reset_index(drop=True).join(pd.DataFrame(drawn))
    # More digits would be those of the processor, as is the strength of what cannot show.
    printed = {c: [float(f"{v:.3g}") for v in numbers[c]] for c in ("multiple", "snr_db")}
    printed["multiple"] = [0.0 if v < INVISIBLE else v for v in printed["multiple"]]
    return figure, numbers.assign(**printed)
