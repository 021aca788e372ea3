"""Bound and errors of the natural frequency past the Shannon limit, and the likelihood that tells the alias."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RESOLUTION = 1e-6  # of a deviance


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the table of :func:`camid.ablations.past_shannon.runs.compute`."""
    style.apply()
    import matplotlib.pyplot as plt

    bounds, curve = table[table["kind"] == "curve"], table[table["kind"] == "likelihood"]
    fits = table[table["kind"] == "fit"]
    product = float(curve["product"].iloc[0])
    figure, (left, right) = plt.subplots(1, 2, figsize=(style.PAGE_WIDTH, 2.9))
    left.semilogy(bounds["product"], bounds["value"], "-", color=style.BLUE, label="Cramér–Rao bound")
    rows = []
    for nominal, colour, symbol, label in (
        (True, style.VERMILION, "s", "median error, nominal within 5 %"),
        (False, style.BLACK, "x", "median error, no model at all"),
    ):
        medians = [
            (p, 100.0 * float((g["frequency"] - 1.0).abs().median()) / 0.67449)
            for p, g in fits[fits["nominal"] == nominal].groupby("product")
        ]
        left.semilogy(*zip(*medians, strict=True), symbol, color=colour, label=label, markersize=4, mfc="none")
        rows += [{"kind": label, "x": float(str(p)), "y": v} for p, v in medians]
    for shannon in (np.pi, 2.0 * np.pi):
        left.axvline(shannon, color=style.GREY, linewidth=0.8, linestyle="-.")
    left.set(xlabel="Tω$_0$ (rad)", ylabel="standard deviation of ω$_0$ (%)", title="what the data know of ω$_0$")
    left.annotate("π", (np.pi, 0.97), xycoords=("data", "axes fraction"), xytext=(2, 0), textcoords="offset points")
    left.annotate("2π", (6.28, 0.97), xycoords=("data", "axes fraction"), xytext=(2, 0), textcoords="offset points")
    left.legend(fontsize=6.5, loc="lower right")
    right.plot(curve["frequency"], curve["value"], "-", color=style.BLUE)
    # Each label on the side of its line where no other line stands.
    for place, label, colour, side in (
        (1.0, "true", style.BLACK, 1),
        (2.0 * np.pi / product - 1.0, "alias 2π/T − ω$_0$", style.VERMILION, -1),
    ):
        right.axvline(place, color=colour, linewidth=0.8, linestyle="--")
        right.annotate(label, (place, 0.03), xycoords=("data", "axes fraction"), xytext=(3 * side, 0), color=colour,
                       textcoords="offset points", fontsize=7, ha="left" if side > 0 else "right")  # fmt: skip
    right.axvline(np.pi / product, color=style.GREY, linewidth=0.8, linestyle="-.")
    right.annotate("π/T", (np.pi / product, 0.97), xycoords=("data", "axes fraction"), xytext=(2, 0),
                   textcoords="offset points", fontsize=7, va="top")  # fmt: skip
    right.set(
        xlabel="frequency of the model / ω$_0$",
        ylabel="deviance above the best",
        title=f"one noise sample, Tω$_0$ = {product:g}",
    )
    rows += [{"kind": "bound", "x": r["product"], "y": r["value"]} for r in bounds.to_dict("records")]
    rows += [
        {"kind": "deviance", "x": r["frequency"], "y": round(r["value"] / RESOLUTION) * RESOLUTION}
        for r in curve.to_dict("records")
    ]
    return figure, pd.DataFrame(rows)
