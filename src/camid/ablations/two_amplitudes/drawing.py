"""Price of a second amplitude in the excitation, and what it gives away."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from camid import plotting as style
from camid.ablations.identification_drawing import SYMBOLS, printed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIGNALS = {
    "prbs": "PRBS",
    "two-amplitudes": "two\namplitudes",
    "multilevel": "multi-\nlevel",
    "multisine": "multi-\nsine",
}
PLANTS = {"linear": "linear", "cubic-stiffness": "cubic\nstiffness", "dead-zone": "dead\nzone"}
LOOKS = {"b0": (style.BLUE, "o", "//"), "a1": (style.ORANGE, "s", ""), "a0": (style.BLACK, "^", "..")}
# A standardised difference beyond this has a probability below 0.001.
SIGNIFICANT = 3.29
# Shares of the output; smaller ones are those of the integration.
SMALLEST_DISTORTION = 1e-6


def draw(table: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw bounds at equal power, what a linear model leaves, and the differences between the halves.

    Parameters
    ----------
    table : DataFrame
        From :func:`camid.ablations.two_amplitudes.runs.compute`.
    """
    style.apply()
    import matplotlib.pyplot as plt

    clean, noisy = table[table["sample"] < 0], table[table["sample"] >= 0]
    figure, (price, rest, halves) = plt.subplots(1, 3, figsize=(style.PAGE_WIDTH, 3.1), width_ratios=[1.0, 1.0, 1.25])
    style.separate_panels(figure, 0.05)
    _draw_bounds(price, clean)
    _draw_distortion(rest, clean)
    _draw_halves(halves, noisy[noisy["signal"].isin(["prbs", "two-amplitudes"])])
    drawn = table.assign(distortion=table["distortion"].where(~(table["distortion"] < SMALLEST_DISTORTION), 0.0))
    columns = [c for c in drawn.columns if c.split("_")[0] in {"bound", "error", "standardised", "distortion", "peak"}]
    drawn = drawn[(drawn["sample"] < 0) | drawn["signal"].isin(["prbs", "two-amplitudes"])]
    return figure, printed(drawn.drop(columns="probability"), columns)


def _draw_bounds(axes: Axes, clean: pd.DataFrame) -> None:
    bounds = clean.drop_duplicates("signal").set_index("signal")
    for i, (p, (colour, _, hatch)) in enumerate(LOOKS.items()):
        values = [bounds[f"bound_{p}"][s] / bounds[f"bound_{p}"]["prbs"] for s in SIGNALS]
        place = np.arange(len(SIGNALS)) + 0.25 * (i - 1)
        axes.bar(place, values, 0.23, color="white", edgecolor=colour, hatch=3 * hatch, linewidth=0.8, label=SYMBOLS[p])
    axes.axhline(1.0, color=style.GREY, linewidth=0.8, linestyle="--")
    axes.set_xticks(range(len(SIGNALS)), [*SIGNALS.values()], fontsize=6.2)
    axes.set(ylabel="bound over that of the PRBS", title="price, at equal power", ylim=(0.0, 1.4))
    axes.set_xlabel("excitation")
    axes.grid(visible=False, axis="x")
    axes.legend(loc="upper right", ncols=3)


def _draw_distortion(axes: Axes, clean: pd.DataFrame) -> None:
    looks = (("cubic-stiffness", style.VERMILION, "//"), ("dead-zone", style.BLUE, ".."))
    for i, (plant, colour, hatch) in enumerate(looks):
        rows = clean[clean["plant"] == plant].set_index("signal")["distortion"]
        values = [100.0 * rows[s] if rows[s] >= SMALLEST_DISTORTION else 0.0 for s in SIGNALS]
        place = np.arange(len(SIGNALS)) + 0.3 * (i - 0.5)
        name = PLANTS[plant].replace("\n", " ")
        axes.bar(place, values, 0.28, color="white", edgecolor=colour, hatch=3 * hatch, linewidth=0.8, label=name)
        for x, value in zip(place, values, strict=True):
            if value == 0.0:
                axes.annotate("0", (x, 0.3), ha="center", color=colour)
    axes.set_xticks(range(len(SIGNALS)), [*SIGNALS.values()], fontsize=6.2)
    axes.set(ylabel="residual over output (%)", title="left by a linear model, no noise")
    axes.set_xlabel("excitation")
    axes.grid(visible=False, axis="x")
    axes.legend(loc="upper left")


def _draw_halves(axes: Axes, noisy: pd.DataFrame) -> None:
    axes.axhspan(-SIGNIFICANT, SIGNIFICANT, color="#BBBBBB", alpha=0.35, linewidth=0.0)
    ticks, names = [], []
    for i, signal in enumerate(("prbs", "two-amplitudes")):
        for j, plant in enumerate(PLANTS):
            place = 3.4 * i + j
            rows = noisy[(noisy["signal"] == signal) & (noisy["plant"] == plant)]
            for k, (p, (colour, symbol, _)) in enumerate(LOOKS.items()):
                values = rows[f"standardised_{p}"]
                axes.plot(
                    np.full(len(values), place + 0.25 * (k - 1)),
                    values,
                    symbol,
                    color=colour,
                    markersize=2.2,
                    markerfacecolor="none",
                    markeredgewidth=0.5,
                    label=SYMBOLS[p] if place == 0 else None,
                )
            ticks.append(place)
            names.append(PLANTS[plant])
    low, high = axes.get_ylim()
    for i, signal in enumerate(("prbs", "two-amplitudes")):
        name = SIGNALS[signal].replace("\n", " ")
        axes.annotate(name, (3.4 * i + 1, high + 0.02 * (high - low)), ha="center", fontsize=7.5)
    axes.set_xticks(ticks, names, fontsize=5.8)
    axes.set(
        ylabel="difference / its std",
        title="second half against first, in noise",
        ylim=(low, high + 0.1 * (high - low)),
        xlabel="plant",
    )
    axes.grid(visible=False, axis="x")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.88), handletextpad=0.1)
