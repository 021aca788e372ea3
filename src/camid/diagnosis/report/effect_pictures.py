"""Pictures of the effects that were found: each against what shows it, its law drawn over what the recording says.

A force is drawn against what it depends on, a fault of the clock as the time by which frames are late, and an effect on
the noise by its histogram, its spectrum or its spread: none of these bends the missing force. Drawing only.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.diagnosis import Diagnosis
from camid.diagnosis.finding import Finding
from camid.diagnosis.report.noise_pictures import TITLES, noise_pictures
from camid.diagnosis.report.panel import (
    LARGEST_LINE,
    Panel,
    draw_dots,
    inline_svg,
    is_narrow,
    legend_above,
    new_panel,
    quartiles_of_bins,
    range_of_nearly_all,
    thinned,
    wide_panel,
)
from camid.effects import known_effects

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from camid.diagnosis.effect_signals import EffectSignals

Array = NDArray[np.float64]

MOST_EFFECTS = 4
LAW_BINS = 60
# Windows of a recording in which frames are compared with the simulation.
WINDOWS, FEWEST_IN_WINDOW = 24, 12
# Spread of a time shift over its mean below which it is the same throughout.
LARGEST_CHANGE = 0.1
# What effects of a place are drawn against where they say nothing else.
OF_PLACE = {"actuator": "input", "disturbance": "time", "sensor": "position"}
# What a learned law is drawn against; products with a velocity or an input are no curve over one signal.
OF_LEARNED = {"position": "position", "velocity": "velocity", "input": "input", "reading": "position"}
UNBENT = (
    "Computed with the improved coefficients, so that what re-estimated ones took of it does not bend it: the law "
    "along the motion, and on top of it what the improved simulation leaves."
)
SMOOTHED = " The recording shows a force no sharper than the dashed line."


@dataclass(frozen=True)
class Names:
    """What the labels of a panel are made of.

    Attributes
    ----------
    source, output, rate : str
        Units of input, output and rate of the output.
    command, seen : str
        What input and output are called, with their units.
    """

    source: str
    output: str
    rate: str
    command: str
    seen: str


def drawn_against(finding: Finding) -> str:
    """What an effect is drawn against."""
    kind = known_effects().get(finding.identifier)
    if kind is not None and kind.drawn_against:
        return kind.drawn_against
    by_velocity = kind is not None and bool(kind.uses_velocity)
    return OF_PLACE.get(finding.place, "velocity" if by_velocity else "position")


def effect_pictures(diagnosis: Diagnosis, names: Names) -> Iterator[Panel]:
    """Panels of the effects that were found, the strongest first, and of learned laws over one signal."""
    signals = {each.identifier: each for each in diagnosis.effect_signals}
    for index, finding in enumerate(diagnosis.findings[:MOST_EFFECTS]):
        against = drawn_against(finding)
        if against in TITLES:
            yield from noise_pictures(against, diagnosis, finding, names.output, index == 0)
        elif finding.identifier in signals:
            made = _pictures(diagnosis, signals[finding.identifier], finding.title, finding.place, against, names)
            yield from (replace(panel, located=index == 0) for panel in made)
    for part in diagnosis.learned:
        if part.identifier in signals and part.variables in OF_LEARNED:
            made = _pictures(
                diagnosis, signals[part.identifier], part.name, part.place, OF_LEARNED[part.variables], names
            )
            yield from (replace(panel, located=not diagnosis.findings) for panel in made)


def shown_as_force(diagnosis: Diagnosis) -> set[str]:
    """Signals against which a force that was found is drawn; empty where none is one."""
    forces = {each.identifier for each in diagnosis.effect_signals}
    found = {drawn_against(f) for f in diagnosis.findings if f.identifier in forces and f.place != "sensor"}
    learned = {p.variables for p in diagnosis.learned if p.identifier in forces and p.place != "sensor"}
    return found | learned


def _pictures(
    diagnosis: Diagnosis, shown: EffectSignals, title: str, place: str, against: str, names: Names
) -> Iterator[Panel]:
    """Panels of one effect that changes the expected output."""
    first = diagnosis.signals
    if against.startswith("time shift"):
        yield from _time_shifts(diagnosis, shown, title, names, over_position=against.endswith("position"))
        return
    change = np.diff(first.signal, prepend=first.signal[:1])
    abscissas: dict[str, tuple[Array, str]] = {
        "input": (first.signal, f"input {names.command}"),
        "change of the input": (change, f"input less that of the last row, {names.source}"),
        "velocity": (shown.velocity, f"velocity, {names.rate}"),
        "position": (shown.position, f"simulated {names.seen}"),
        "rate": (shown.rate, f"rate of the output, {names.rate}"),
        "time": (first.time, "time, s"),
    }
    if against not in abscissas:
        return
    x, label = abscissas[against]
    at_sensor = place == "sensor"
    quantity = f"error of reading, {names.output}" if at_sensor else f"missing force, {names.source}"
    heading = f"{title}: {'error of the reading' if at_sensor else 'missing force'} against {_called(against)}"
    caption = f"The law that was found, over what the recording shows. {UNBENT}{'' if at_sensor else SMOOTHED}"
    if against == "time":
        yield Panel(heading, caption, **wide_panel(partial(_over_time, first.time, shown, (label, quantity)), heading))
        return
    yield Panel(heading, caption, inline_svg(_with_law(x, shown, (label, quantity)), heading))


def _called(against: str) -> str:
    named = f"the {against}" if " " in against else against
    return "the rate of the output" if against == "rate" else named


def _with_law(x: Array, shown: EffectSignals, labels: tuple[str, str]) -> Axes:
    """Scatter with medians and quartiles of bins, and the law over them, as it is and as smooth as they are."""
    from camid import plotting as style

    data = shown.data
    axes = new_panel(top=28.0)
    draw_dots(axes, x, data)
    centres, quartiles = quartiles_of_bins(x, data)
    axes.fill_between(centres, quartiles[:, 0], quartiles[:, 2], color=style.BLUE, alpha=0.25, linewidth=0, zorder=2)
    axes.plot(centres, quartiles[:, 1], "-o", color=style.BLUE, linewidth=1.6, markersize=4.0, label="recording")
    smoothed = not np.array_equal(shown.seen, shown.law)
    at, middle = quartiles_of_bins(x, shown.law, LAW_BINS)
    axes.plot(at, middle[:, 1], ":" if smoothed else "--", color=style.VERMILION, linewidth=2.0, label="law", zorder=4)
    if smoothed:
        at, middle = quartiles_of_bins(x, shown.seen)
        axes.plot(at, middle[:, 1], "--", color=style.VERMILION, linewidth=2.4, label="law, smoothed alike", zorder=5)
    axes.axhline(0.0, color=style.BLACK, linewidth=0.8)
    axes.set(xlim=range_of_nearly_all(x, share=0.0), ylim=range_of_nearly_all(data, shown.law))
    axes.set(xlabel=labels[0], ylabel=labels[1])
    legend_above(axes, 3)
    return axes


def _over_time(time: Array, shown: EffectSignals, labels: tuple[str, str], size: tuple[float, float]) -> Axes:
    """What every row shows over time, and the law."""
    from camid import plotting as style

    largest = LARGEST_LINE // 2 if is_narrow(size) else LARGEST_LINE
    axes = new_panel(size, top=28.0)
    axes.plot(*thinned(time, shown.data, largest), color=style.BLUE, linewidth=1.0, label="recording")
    axes.plot(*thinned(time, shown.seen, largest), "--", color=style.VERMILION, linewidth=1.4, label="law")
    axes.axhline(0.0, color=style.BLACK, linewidth=0.8)
    axes.set(xlim=(time[0], time[-1]), ylim=range_of_nearly_all(shown.data, shown.law))
    axes.set(xlabel=labels[0], ylabel=labels[1])
    legend_above(axes, 2)
    return axes


def windowed_shift(groups: Sequence[NDArray[np.int_]], error: Array, rate: Array) -> tuple[Array, Array]:
    """Time by which readings are late in groups of rows, and its standard deviation: the error over the rate.

    A reading that is late by d is wrong by -d times the rate of the output.
    """
    shifts, deviations = [], []
    for rows in groups:
        e, v = error[rows], rate[rows]
        power = float(v @ v) or 1.0
        shift = -float(v @ e) / power
        left = e + shift * v
        shifts.append(shift)
        deviations.append(float(np.sqrt(left @ left / max(len(rows) - 1, 1) / power)))
    return np.array(shifts), np.array(deviations)


def _time_shifts(
    diagnosis: Diagnosis, shown: EffectSignals, title: str, names: Names, *, over_position: bool
) -> Iterator[Panel]:
    """How late the readings are, over time or over the position, and their error against the rate of the output."""
    from camid import plotting as style

    signals = diagnosis.signals
    by = shown.position if over_position else signals.time
    good = np.flatnonzero(np.isfinite(by) & np.isfinite(shown.data))
    count = max(min(WINDOWS, len(good) // FEWEST_IN_WINDOW), 1)
    groups = np.array_split(good[np.argsort(by[good], kind="stable")], count)
    at = np.array([float(np.median(by[rows])) for rows in groups])
    shift, deviation = windowed_shift(groups, shown.data, shown.rate)
    law, _ = windowed_shift(groups, shown.law, shown.rate)
    axes = new_panel(top=28.0)
    axes.errorbar(at, 1e3 * shift, 2e3 * deviation, fmt="none", ecolor=style.BLUE, elinewidth=1.2, zorder=2)
    axes.plot(at, 1e3 * shift, "o", color=style.BLUE, markersize=4.5, label="recording (± 2 σ)", zorder=3)
    axes.plot(at, 1e3 * law, "--", color=style.VERMILION, linewidth=2.0, label="law", zorder=4)
    axes.axhline(0.0, color=style.BLACK, linewidth=0.8)
    low, high = min(float(np.min(1e3 * law)), 0.0), max(float(np.max(1e3 * law)), 0.0)
    axes.set_ylim(range_of_nearly_all(1e3 * shift, np.array([low, high]), share=0.0))
    axes.set(xlabel=f"position, {names.output}" if over_position else "time, s", ylabel="readings are late by, ms")
    legend_above(axes, 2)
    over = "position" if over_position else "time"
    heading = f"{title}: time shift over {over}"
    caption = (
        "How late the readings are, by the error of a stretch over the rate of the output; zero where the simulation's "
        "clock is right."
    )
    yield Panel(heading, caption, inline_svg(axes, heading))
    if float(np.std(law)) > LARGEST_CHANGE * abs(float(np.mean(law))):
        return  # what changes is no line over the rate
    heading = f"{title}: error of the reading against the rate of the output"
    drawn = _with_law(
        shown.rate,
        shown,
        (f"rate of the output, {names.rate}", f"error of reading, {names.output}"),
    )
    caption = f"Readings that are late are wrong in proportion to the rate. {UNBENT}"
    yield Panel(heading, caption, inline_svg(drawn, heading))
