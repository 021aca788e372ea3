"""Frequency responses of the plant before and after, and that of the recording beside them. Drawing only."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.diagnosis import AS_GIVEN, IMPROVED, REFITTED, Diagnosis
from camid.diagnosis.report.panel import (
    Panel,
    decade_text,
    inline_svg,
    legend_above,
    new_panel,
    range_of_nearly_all,
    ticks_within_decade,
)
from camid.diagnosis.report.words import with_titles

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from camid.analysis.frequency_response import FrequencyResponses

Array = NDArray[np.float64]

BAND = 1.96
# Beyond what the curves span, that dots and bands may lengthen an axis by.
ROOM_DECIBELS, ROOM_DEGREES = 12.0, 40.0


def bode_pictures(diagnosis: Diagnosis) -> Iterator[Panel]:
    """Magnitude and phase."""
    if diagnosis.responses is None:
        return
    responses = diagnosis.responses.in_declared_units()
    recorded = "" if responses.empirical is None else " Circles: the recording, where noise does not cover it."
    yield Panel(
        "Magnitude of the plant",
        f"In decibels of {responses.units.text('y/u')}; bands of 95 %.{recorded}",
        inline_svg(_drawn(responses, decibels=True), "Bode magnitude before and after"),
    )
    remarks = with_titles("; ".join(responses.remarks), diagnosis.own_titles)
    yield Panel(
        "Phase of the plant",
        f"{remarks[:1].upper()}{remarks[1:]}." if remarks else "Hold and sensor are not part of it.",
        inline_svg(_drawn(responses, decibels=False), "Bode phase before and after"),
    )


def _drawn(responses: FrequencyResponses, *, decibels: bool) -> Axes:
    from matplotlib.ticker import FuncFormatter, LogLocator, MultipleLocator, NullFormatter

    from camid import plotting as style

    looks: dict[str, dict[str, Any]] = {
        AS_GIVEN: {"linestyle": ":", "color": style.GREY, "linewidth": 2.0},
        REFITTED: {"linestyle": "--", "color": style.ORANGE, "linewidth": 2.0},
        IMPROVED: {"linestyle": "-", "color": style.BLUE, "linewidth": 1.8},
    }
    axes = new_panel(top=28.0)
    shown: list[Array] = []
    for curve in responses.curves:
        hertz = curve.angular_frequency / (2.0 * np.pi)
        values = curve.decibels if decibels else np.degrees(curve.phase)
        spread = curve.decibel_deviation if decibels else curve.phase_deviation
        axes.plot(hertz, values, label=curve.name, zorder=2.5, **looks[curve.name])
        if spread is not None:
            half = BAND * (spread if decibels else np.degrees(spread))
            axes.fill_between(
                hertz, values - half, values + half, color=looks[curve.name]["color"], alpha=0.25, linewidth=0
            )
        shown.append(values)
    limits = range_of_nearly_all(*shown, share=0.0)
    if responses.empirical is not None:
        limits = _dots(axes, responses, decibels, limits)
    axes.set_xscale("log")
    omega = responses.curves[0].angular_frequency
    low, high = (float(omega[i]) / (2.0 * np.pi) for i in (0, -1))
    axes.set(xlim=(low, high), ylim=limits, xlabel="frequency, Hz")
    axes.set_ylabel("magnitude, dB" if decibels else "phase, °")
    axes.xaxis.set_major_locator(LogLocator(subs=ticks_within_decade(low, high)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: decade_text(v)))
    axes.xaxis.set_minor_formatter(NullFormatter())
    if not decibels:
        span = limits[1] - limits[0]
        axes.yaxis.set_major_locator(
            MultipleLocator(next(s for s in (15.0, 45.0, 90.0, 180.0, 720.0, 1e6) if span < 9.0 * s))
        )
    legend_above(axes, 4)
    return axes


def _dots(
    axes: Axes, responses: FrequencyResponses, decibels: bool, limits: tuple[float, float]
) -> tuple[float, float]:
    """What the recording shows of the response; the limits that hold most of it."""
    from camid import plotting as style

    assert responses.empirical is not None
    curve, seen = responses.recorded_curve(), responses.empirical.is_seen
    values = (curve.decibels if decibels else np.degrees(curve.phase))[seen]
    hertz = curve.angular_frequency[seen] / (2.0 * np.pi)
    axes.plot(
        hertz, values, "o", color=style.BLACK, markersize=2.8, markerfacecolor="none", markeredgewidth=0.6,
        label=curve.name, zorder=2.0,
    )  # fmt: skip
    room = ROOM_DECIBELS if decibels else ROOM_DEGREES
    kept = values[np.isfinite(values)]
    if not len(kept):
        return limits
    near = np.clip(kept, limits[0] - room, limits[1] + room)
    return range_of_nearly_all(np.array(limits), near, share=0.0)
