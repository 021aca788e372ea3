"""Step responses with their bands."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from camid import plotting as style
from camid.drawing.lines import BAND, band, line_of, new_figure, range_of, short
from camid.number_text import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from camid.analysis.step_response import StepCurve, StepResponses


def draw(result: StepResponses) -> Figure:
    """All models over one axis of time."""
    figure = new_figure(3.2)
    axes = figure.subplots()
    signal, seen = result.units.input, result.units.output
    curves = [_in_units(curve, seen.factor) for curve in result.curves]
    for index, curve in enumerate(curves):
        axes.plot(curve.time, curve.output, label=short(curve.name), zorder=2.5, **line_of(index))
        if curve.deviation is not None:
            half = BAND * curve.deviation
            band(axes, curve.time, curve.output - half, curve.output + half, index)
        final = curve.characteristics.get("final_value")
        if final is not None:
            axes.axhline(final[0], color=line_of(index)["color"], linewidth=0.5, linestyle=(0, (1, 3)), zorder=1.0)
    size = plain(result.amplitude / signal.factor, unit=short(signal.symbol))
    bands = " (bands of 95 %)" if any(c.deviation is not None for c in curves) else ""
    axes.set(xlabel="time, s", ylabel=short(seen.label))
    axes.set_title(
        f"response to a step of {size}{bands}",
        loc="right",
        fontsize=7.0,
    )
    axes.axhline(0.0, color=style.GREY, linewidth=0.6)
    outputs = [c.output for c in curves]
    low, high = range_of([*outputs, np.zeros(1)], 0.0)
    room = 0.5 * (high - low)
    reaching = [
        np.clip(c.output + side * BAND * c.deviation, low - room, high + room)
        for c in curves
        if c.deviation is not None
        for side in (-1.0, 1.0)
    ]
    axes.set_ylim(range_of([*outputs, *reaching, np.zeros(1)]))
    axes.set_xlim(float(curves[0].time[0]), float(max(c.time[-1] for c in curves)))
    axes.legend(loc="best")
    return figure


def _in_units(curve: StepCurve, factor: float) -> StepCurve:
    """The curve in a unit that is so many of SI."""
    final = {k: (v / factor, s) for k, (v, s) in curve.characteristics.items() if k == "final_value"}
    deviation = None if curve.deviation is None else curve.deviation / factor
    return replace(curve, output=curve.output / factor, deviation=deviation, characteristics=final)
