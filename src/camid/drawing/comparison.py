"""Recorded and simulated signals over time, with what the simulations miss below."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from camid import plotting as style
from camid.drawing.lines import SHADE, legend_above, line_of, new_figure, range_of, short

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from camid.analysis.comparison import ComparedSignal, Comparison

# More experiments would make the panels too small to read.
MOST_PANELS = 4
# Rows up to which every recorded one is a dot of its own.
MOST_DOTS = 400
DOTS = {"marker": "o", "markersize": 2.2, "linestyle": "", "markerfacecolor": "white", "markeredgewidth": 0.5}


def draw(result: Comparison) -> Figure:
    """A pair of panels for each signal: what was recorded and simulated, and their difference."""
    shown = [signal.in_declared_unit() for signal in result.signals[:MOST_PANELS]]
    figure = new_figure(0.5 + 3.3 * len(shown))
    panels = figure.subplots(2 * len(shown), 1, squeeze=False, height_ratios=(2.0, 1.0) * len(shown))[:, 0]
    for number, signal in enumerate(shown):
        upper, lower = panels[2 * number], panels[2 * number + 1]
        lower.sharex(upper)
        upper.tick_params(labelbottom=False)
        rows = _rows(signal, result.zoom)
        dots = np.count_nonzero(rows) <= MOST_DOTS
        # On top and thinner than the models, so that neither hides the other where they lie upon each other.
        upper.plot(
            signal.time[rows], signal.recorded[rows], color=style.BLACK, label="recorded", zorder=3.0,
            **(DOTS if dots else {"linewidth": 0.6}),
        )  # fmt: skip
        for index, name in enumerate(result.models):
            if name not in signal.simulated:
                continue
            simulated, label = signal.simulated[name], f"{short(name)}: {signal.fit_text(name)}"
            upper.plot(signal.time[rows], simulated[rows], label=label, zorder=2.5, **line_of(index))
            missed = signal.recorded - simulated
            lower.plot(signal.time[rows], missed[rows], linewidth=0.9, zorder=2.5, **line_of(index))
        _shade(signal, upper, lower)
        _label(signal, upper, lower, rows)
    panels[-1].set_xlabel("time, s")
    if len(result.signals) > len(shown):
        figure.text(0.99, 0.002, f"{len(result.signals) - len(shown)} more in the table", ha="right", fontsize=6.5)
    return figure


def _rows(signal: ComparedSignal, zoom: tuple[float, float] | None) -> np.ndarray:
    if zoom is None:
        return np.ones(len(signal.time), bool)
    return np.asarray((signal.time >= zoom[0]) & (signal.time <= zoom[1]))


def _shade(signal: ComparedSignal, *panels: Axes) -> None:
    """Grey behind the rows that were not fitted."""
    held = signal.held_out & signal.compared
    edges = np.flatnonzero(np.diff(np.concatenate([[False], held, [False]]).astype(int)))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        for axes in panels:
            label = "held out" if axes is panels[0] and start == edges[0] else None
            axes.axvspan(signal.time[start], signal.time[end - 1], color=SHADE, linewidth=0, zorder=0.5, label=label)


def _label(signal: ComparedSignal, upper: Axes, lower: Axes, rows: np.ndarray) -> None:
    """Units, limits and legend."""
    upper.set_ylabel(short(signal.unit.label, 22))
    lower.set_ylabel(f"error, {short(signal.unit.symbol, 22)}")
    curves = [signal.recorded[rows], *(s[rows] for s in signal.simulated.values())]
    reach = range_of([signal.recorded[rows]], 0.0)
    span = reach[1] - reach[0]
    # A simulation that runs away leaves the axes, and the recording stays to be seen.
    low, high = reach[0] - span, reach[1] + span
    upper.set_ylim(range_of([np.clip(c, low, high) for c in curves]))
    errors = [signal.recorded[rows] - s[rows] for s in signal.simulated.values()]
    lower.set_ylim(range_of([np.clip(e, -2.0 * span, 2.0 * span) for e in errors] if span > 0.0 else errors))
    time = signal.time[rows]
    upper.set_xlim(float(time[0]), float(time[-1]))
    legend_above(upper)
    if signal.experiment:
        upper.set_title(short(signal.experiment), loc="right")
