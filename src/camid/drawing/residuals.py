"""Correlations of a residual with itself and with the input, with their bounds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from camid import plotting as style
from camid.drawing.lines import BAND_OPACITY, new_figure, short
from camid.number_text import equals_probability, plain

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from camid.analysis.residual_correlations import ResidualCorrelations


def draw(result: ResidualCorrelations) -> Figure:
    """One panel for the residual with itself and, where something drives the rig, one with that."""
    table = result.numbers
    driven = bool(result.signals[1])
    figure = new_figure(4.6 if driven else 2.6)
    panels = figure.subplots(2 if driven else 1, 1, squeeze=False)[:, 0]
    own = table[(table["lag"] > 0) & table["autocorrelation"].notna()]
    _stems(panels[0], own, "autocorrelation")
    of, source = short(result.signals[0], 22), short(result.signals[1], 22)
    verdict = _p(result.analysis.whiteness_p)
    panels[0].set(ylabel="autocorrelation", title=f"residual of {of} with itself{verdict}")
    if driven:
        _stems(panels[1], table[table["crosscorrelation"].notna()], "crosscorrelation")
        verdict = _p(result.analysis.independence_p)
        panels[1].set(ylabel="cross-correlation", title=f"residual of {of} with {source}{verdict}")
        panels[1].axvline(0.0, color=style.GREY, linewidth=0.6, zorder=1.0)
    future = f" (negative: {source} of the future, which tells of feedback)" if driven else ""
    panels[-1].set_xlabel(f"lag in periods of {plain(1e3 * result.period, 4, 'ms')}{future}")
    for axes in panels:
        axes.title.set_ha("left")
        axes.title.set_x(0.0)
        axes.axhline(0.0, color=style.BLACK, linewidth=0.6)
    return figure


def _p(value: float | None) -> str:
    return "" if value is None else f" (p {equals_probability(value)})"


def _stems(axes: Axes, table: pd.DataFrame, name: str) -> None:
    """Bars from zero, those outside of the bounds filled, and the bounds as a band."""
    lag, value = table["lag"].to_numpy(float), table[name].to_numpy(float)
    bound = table[f"bound_{name}"].to_numpy(float)
    axes.fill_between(
        lag, -bound, bound, color=style.BLUE, alpha=BAND_OPACITY, linewidth=0, label="99 % bounds of a right model"
    )
    outside = np.abs(value) > bound
    axes.vlines(lag, 0.0, value, color=np.where(outside, style.VERMILION, style.BLACK).tolist(), linewidth=1.2)
    axes.plot(lag[~outside], value[~outside], "o", color=style.BLACK, markerfacecolor="white", label="within")
    axes.plot(lag[outside], value[outside], "D", color=style.VERMILION, label="outside")
    if len(lag):
        axes.set_xlim(float(lag[0]) - 0.8, float(lag[-1]) + 0.8)
        reach = 1.18 * float(np.nanmax(np.abs(np.concatenate([value, bound]))))
        axes.set_ylim(-reach, reach)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.1)
