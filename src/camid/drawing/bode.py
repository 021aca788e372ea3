"""Magnitude and phase over frequency: models with bands, a recording as dots with error bars."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING

import numpy as np

from camid import plotting as style
from camid.drawing.lines import BAND, band, line_of, new_figure, range_of, short
from camid.number_text import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

    from camid.analysis.frequency_response import FrequencyResponses

# Bands are not allowed to make an axis this much longer than the curves do.
ROOM_DB, ROOM_DEGREES = 12.0, 40.0
MANY_DECADES = 2e3


def draw(result: FrequencyResponses) -> Figure:
    """Two panels over one axis of angular frequencies, hertz above."""
    result = result.in_declared_units()
    figure = new_figure(5.2)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(1.15, 1.0))
    for index, curve in enumerate(result.curves):
        omega, degrees = curve.angular_frequency, np.degrees(curve.phase)
        upper.semilogx(omega, curve.decibels, label=short(curve.name), zorder=2.5, **line_of(index))
        lower.semilogx(omega, degrees, zorder=2.5, **line_of(index))
        if curve.decibel_deviation is not None and curve.phase_deviation is not None:
            half = BAND * curve.decibel_deviation
            band(upper, omega, curve.decibels - half, curve.decibels + half, index)
            half = BAND * np.degrees(curve.phase_deviation)
            band(lower, omega, degrees - half, degrees + half, index)
    _dots(result, upper, lower)
    _limits(result, upper, lower)
    upper.set_ylabel(f"magnitude, dB of {short(result.units.text('y/u'))}")
    lower.set(ylabel="phase, °", xlabel="angular frequency, rad/s")
    omega = result.curves[0].angular_frequency
    lower.set_xlim(float(omega[0]), float(omega[-1]))
    hertz = upper.secondary_xaxis("top", functions=(lambda w: w / (2.0 * pi), lambda f: 2.0 * pi * f))
    hertz.set_xlabel("frequency, Hz")
    for axis in (lower.xaxis, hertz.xaxis):
        _name_ticks(axis, float(omega[-1] / omega[0]))
    upper.tick_params(labelbottom=False)
    upper.legend(
        loc="lower left",
        title=result.shows + ("; bands of 95 %" if _has_band(result) else ""),
        alignment="left",
        frameon=True,
        framealpha=0.85,
        edgecolor="none",
    )
    if result.empirical is not None:
        for axes in (upper, lower):
            axes.axvline(result.empirical.nyquist, color=style.BLACK, linewidth=0.8, linestyle=(0, (1, 2)))
        upper.annotate(
            "Nyquist", (result.empirical.nyquist, 0.97), xycoords=("data", "axes fraction"), ha="right", va="top",
            xytext=(-3, 0), textcoords="offset points", fontsize=6.5,
        )  # fmt: skip
    return figure


def _name_ticks(axis: Axis, ratio: float) -> None:
    """Numbers at the ticks of a logarithmic axis, more of them where it spans few decades."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if ratio < MANY_DECADES else (1.0,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))
    axis.set_minor_formatter(NullFormatter())


def _has_band(result: FrequencyResponses) -> bool:
    return any(c.relative_deviation is not None for c in result.curves)


def _dots(result: FrequencyResponses, upper: Axes, lower: Axes) -> None:
    """What a recording shows, where the noise does not cover it."""
    if result.empirical is None:
        return
    curve = result.recorded_curve()
    seen = result.empirical.is_seen
    for axes, values, deviation in (
        (upper, curve.decibels, curve.decibel_deviation),
        (lower, np.degrees(curve.phase), np.degrees(curve.phase_deviation)),  # type: ignore[arg-type]
    ):
        assert deviation is not None
        axes.errorbar(
            curve.angular_frequency[seen],
            values[seen],
            BAND * deviation[seen],
            fmt="o",
            color=style.BLACK,
            markersize=2.2,
            elinewidth=0.5,
            markerfacecolor="white",
            markeredgewidth=0.6,
            zorder=2.0,
            label=f"{curve.name} (95 %)" if axes is upper else None,
        )


def _limits(result: FrequencyResponses, upper: Axes, lower: Axes) -> None:
    """Axes that hold the curves, and of bands and dots what is not far away."""
    from matplotlib.ticker import MultipleLocator

    decibels = [c.decibels for c in result.curves]
    degrees = [np.degrees(c.phase) for c in result.curves]
    if result.empirical is not None:
        dots = result.recorded_curve()
        shown = result.empirical.is_seen
        low, high = range_of(decibels, 0.0)
        decibels.append(np.clip(dots.decibels[shown], low - ROOM_DB, high + ROOM_DB))
        low, high = range_of(degrees, 0.0)
        degrees.append(np.clip(np.degrees(dots.phase[shown]), low - ROOM_DEGREES, high + ROOM_DEGREES))
    upper.set_ylim(range_of(decibels))
    lower.set_ylim(range_of(degrees))
    span = np.ptp(lower.get_ylim())
    lower.yaxis.set_major_locator(
        MultipleLocator(next(s for s in (15.0, 45.0, 90.0, 180.0, 720.0, 1e5) if span < 9 * s))
    )
