"""Pictures of the report: what the recording looks like before and after, as small inline SVG. Drawing only.

Each panel is a figure of its own, so that the page can set them side by side on a desk and one below the other on a
telephone. They keep their text as text, and dense scatters are one path of dots.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import nullcontext
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.diagnosis import AS_GIVEN, IMPROVED, REFITTED, Diagnosis, Signals
from camid.diagnosis.normalised_errors import NormalisedErrors
from camid.diagnosis.report.bode_pictures import bode_pictures
from camid.diagnosis.report.effect_pictures import Names, effect_pictures, shown_as_force
from camid.diagnosis.report.learned_pictures import learned_pictures
from camid.diagnosis.report.panel import (
    LARGEST_LINE,
    REGION,
    SHADE,
    Panel,
    decade_text,
    draw_dots,
    inline_svg,
    is_narrow,
    legend_above,
    look_of_the_project,
    new_panel,
    new_panels,
    quartiles_of_bins,
    range_of_nearly_all,
    thinned,
    ticks_within_decade,
    wide_panel,
)
from camid.number_text import percentage, printable
from camid.side_by_side import side_by_side, with_a_copy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

# In the order of what they take: the longest first, so that two processes end at about the same time.
GROUPS = ("fit", "structure", "effects", "response", "learned")
ZOOMED_ROWS = 150
# Letters of a name beside an axis.
LONGEST_NAME = 22


def _against(x: Array, y: Array, labels: tuple[str, str], region: tuple[float, float] | None) -> Axes:
    """Scatter with the median and the quartiles of bins: a curve here is a law that the simulation does not have."""
    from camid import plotting as style

    axes = new_panel()
    good = np.isfinite(x) & np.isfinite(y)
    x, y = x[good], y[good]
    if region is not None:
        axes.axvspan(*region, color=REGION, alpha=0.25, linewidth=0)
    draw_dots(axes, x, y)
    centres, quartiles = quartiles_of_bins(x, y) if len(x) else (x, np.zeros((0, 3)))
    axes.fill_between(centres, quartiles[:, 0], quartiles[:, 2], color=style.BLUE, alpha=0.25, linewidth=0, zorder=2)
    axes.plot(centres, quartiles[:, 1], "-o", color=style.BLUE, linewidth=2.0, markersize=4.0, zorder=3)
    axes.axhline(0.0, color=style.BLACK, linewidth=0.8)
    axes.set(xlim=range_of_nearly_all(x, share=0.0), ylim=range_of_nearly_all(y), xlabel=labels[0], ylabel=labels[1])
    return axes


def _shade_held_out(axes: Axes, signals: Signals, period: float, label: str | None = "not fitted") -> None:
    steps = np.flatnonzero(np.diff(np.concatenate([[0], signals.validates.astype(int), [0]])))
    spans = [(signals.time[a] - 0.5 * period, period * (b - a)) for a, b in zip(steps[::2], steps[1::2], strict=True)]
    if spans:
        transform = axes.get_xaxis_transform()
        axes.broken_barh(spans, (0.0, 1.0), transform=transform, color=SHADE, linewidth=0, zorder=0, label=label)


def _errors(fit: NormalisedErrors, named: bool) -> Axes:
    """Errors on held-out rows on a logarithmic axis, with the noise floor as a line."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    from camid import plotting as style

    axes = new_panel(top=26.0)
    rows = [(AS_GIVEN, fit.as_given, style.GREY, "s"), (REFITTED, fit.refitted, style.ORANGE, "D")]
    rows += [(IMPROVED, fit.improved, style.BLUE, "o")] if named else []
    values = np.array([*(100.0 * value for _, value, _, _ in rows), 100.0 * fit.noise_floor])
    values = np.maximum(np.nan_to_num(values, posinf=1e6), 1e-6)
    low, high = values.min() / 1.6, values.max() * 1.6 * (values.max() / values.min()) ** 0.25
    for i, ((_, share, colour, marker), value) in enumerate(zip(rows, values, strict=False)):
        axes.plot([low, value], [-i, -i], color=colour, linewidth=2.0)
        axes.plot(
            [value], [-i], marker, color=colour, markersize=10.0, markeredgecolor=style.BLACK, markeredgewidth=0.6
        )
        axes.annotate(percentage(share), (value, -i), (9.0, 0.0), textcoords="offset points", va="center")
    axes.axvline(values[-1], color=style.BLACK, linestyle="--", linewidth=1.2)
    note = f"noise floor {percentage(fit.noise_floor)}"
    axes.annotate(note, (values[-1], 1.0), (0, 4), xycoords=("data", "axes fraction"), textcoords="offset points")
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=ticks_within_decade(low, high)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: decade_text(v)))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set(xlim=(low, high), ylim=(0.6 - len(rows), 0.6), xlabel="error, % of the output's standard deviation")
    axes.set_yticks([-i for i in range(len(rows))], [name for name, *_ in rows])
    axes.grid(visible=False, axis="y")
    return axes


def _worst_rows(signals: Signals) -> tuple[slice, bool]:
    """Rows on which the refitted simulation errs most, and whether they are rows that were not fitted."""
    squares = np.nan_to_num((signals.recorded - signals.refitted) ** 2)
    size = min(ZOOMED_ROWS, len(squares))
    held = signals.validates
    inside = np.convolve(held, np.ones(size), mode="valid") >= size - 0.5
    sums = np.convolve(squares, np.ones(size), mode="valid")
    unseen = bool(inside.any())
    first = int(np.argmax(np.where(inside, sums, -1.0) if unseen else sums))
    return slice(first, first + size), unseen


def _overlay(diagnosis: Diagnosis, rows: slice, size: tuple[float, float]) -> Axes:
    """Recorded and simulated output on a stretch, and the input above them."""
    from camid import plotting as style

    signals, named = diagnosis.signals, _named(diagnosis)
    time = signals.time[rows]
    columns = 2 if is_narrow(size) else 4
    top = 28.0 * (4 // columns)
    driven = diagnosis.improved.input_column is not None and diagnosis.residual_of == "output"
    tall = (size[0], size[1] + (90.0 if driven else 20.0))
    *above, axes = new_panels(tall, (1.0, 2.4) if driven else (1.0,), top)
    for upper in above:
        held = diagnosis.improved.hold == "zoh"
        driving = diagnosis.improved.units.input
        label = _short(driving.label) if driving.unit else f"input, {_short(driving.symbol)}"
        upper.plot(
            time, signals.signal[rows], color=style.GREEN, linewidth=1.4, label="_input",
            drawstyle="steps-post" if held else "default", gid="series input",
        )  # fmt: skip
        upper.set(ylabel=label, ylim=range_of_nearly_all(signals.signal[rows], share=0.0))
    recorded: dict[str, Any] = {
        "color": style.BLACK,
        "markersize": 4.2,
        "markerfacecolor": "none",
        "markeredgewidth": 0.7,
    }
    axes.plot(time, signals.recorded[rows], "o", label="recorded", **recorded)
    axes.plot(time, signals.nominal[rows], ":", color=style.GREY, linewidth=1.6, label=AS_GIVEN)
    axes.plot(time, signals.refitted[rows], "--", color=style.ORANGE, linewidth=2.0, label=REFITTED)
    if named:
        axes.plot(time, signals.improved[rows], color=style.BLUE, linewidth=1.6, label=IMPROVED)
    axes.set(xlim=(time[0], time[-1]), xlabel="time, s", ylabel=_labelled(diagnosis))
    handles, labels = axes.get_legend_handles_labels()
    (above or [axes])[0].legend(
        handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, borderaxespad=0.1,
        handlelength=1.8,
    )  # fmt: skip
    return axes


def _over_time(diagnosis: Diagnosis, size: tuple[float, float]) -> Axes:
    """The residual of the whole recording before and after."""
    from camid import plotting as style

    signals, named = diagnosis.signals, _named(diagnosis)
    largest = LARGEST_LINE // 2 if is_narrow(size) else LARGEST_LINE
    columns = 2 if is_narrow(size) and named else 3
    axes = new_panel(size, top=28.0 if columns == 3 else 44.0)
    _shade_held_out(axes, signals, diagnosis.period)
    before, after = signals.recorded - signals.refitted, signals.recorded - signals.improved
    label = "before (re-estimated)" if named else REFITTED
    axes.plot(*thinned(signals.time, before, largest), color=style.ORANGE, linewidth=0.9, label=label)
    if named:
        axes.plot(*thinned(signals.time, after, largest), color=style.BLUE, linewidth=0.9, label="after (improved)")
    if diagnosis.location.time is not None:
        for edge in diagnosis.location.time:
            axes.axvline(edge, color=style.BLACK, linestyle="-.", linewidth=1.0)
    axes.set(xlim=(signals.time[0], signals.time[-1]), ylim=range_of_nearly_all(before, after, share=0.05))
    axes.set(xlabel="time, s", ylabel=f"residual, {_short(diagnosis.compared_signal.symbol)}")
    legend_above(axes, columns)
    return axes


def _spectrum(diagnosis: Diagnosis, output: str, named: bool) -> Axes:
    from matplotlib.mlab import psd
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    from camid import plotting as style

    signals = diagnosis.signals
    axes = new_panel(top=28.0)
    lines = [("before" if named else "re-estimated", signals.refitted, style.ORANGE, "-")]
    lines += [("after", signals.improved, style.BLUE, "-")] if named else []
    count = min(256, max(16, len(signals.time) // 4))
    if diagnosis.location.frequency is not None:
        axes.axvspan(*diagnosis.location.frequency, color=REGION, alpha=0.25, linewidth=0)
    for label, simulated, colour, line in lines:
        residual = np.nan_to_num(signals.recorded - simulated)
        welch = psd(residual - residual.mean(), NFFT=count, Fs=1.0 / diagnosis.period, noverlap=count // 2)
        power, frequency = (np.asarray(part) for part in welch)
        level = np.sqrt(np.maximum(power[1:], np.finfo(float).tiny))
        axes.semilogy(frequency[1:], level, line, color=colour, linewidth=1.5, label=label)
    axes.yaxis.set_major_locator(LogLocator(subs=ticks_within_decade(*axes.get_ylim())))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda v, _: decade_text(v)))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set(xlim=(0.0, 0.5 / diagnosis.period), xlabel="frequency, Hz", ylabel=f"residual, {output}/√Hz")
    legend_above(axes, 2)
    return axes


def draw(diagnosis: Diagnosis, *, shared: bool = False) -> dict[str, list[Panel]]:
    """Draw all panels.

    Parameters
    ----------
    diagnosis : Diagnosis
    shared : bool
        Whether a copy of this process draws a part of them.

    Returns
    -------
    dict of str to list of Panel
        ``fit`` (before and after), ``response`` (Bode), ``effects`` (what shows the effects that were found),
        ``structure`` (what the missing force depends on, where it is one) and ``learned`` (laws without a name).
    """
    drawn = partial(_drawn, diagnosis)
    with look_of_the_project(), with_a_copy(diagnosis) if shared else nullcontext(False) as copied:
        panels = side_by_side(drawn, GROUPS) if copied else [drawn(group) for group in GROUPS]
    return dict(zip(GROUPS, panels, strict=True))


def _drawn(diagnosis: Diagnosis, group: str) -> list[Panel]:
    """The panels of one group."""
    pictures: dict[str, Callable[[], Iterable[Panel]]] = {
        "fit": partial(_fit_pictures, diagnosis),
        "structure": partial(_structure_pictures, diagnosis),
        "effects": lambda: effect_pictures(diagnosis, _names(diagnosis)),
        "response": partial(bode_pictures, diagnosis),
        "learned": partial(learned_pictures, diagnosis),
    }
    return list(pictures[group]())


def _named(diagnosis: Diagnosis) -> bool:
    """Whether the improved simulation is another one than the re-estimated."""
    return bool(diagnosis.findings or diagnosis.learned)


def _short(name: str) -> str:
    """A name that fits beside an axis."""
    name = printable(name)
    return name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 1]}…"


def _names(diagnosis: Diagnosis) -> Names:
    units = diagnosis.improved.units
    source, output, rate = (_short(units.text(unit)) for unit in ("u", "y", "y/s"))
    return Names(source, output, rate, _short(units.input.label), _short(units.output.label))


def _labelled(diagnosis: Diagnosis) -> str:
    """What the ordinate of recorded and simulated values is called."""
    compared = diagnosis.compared_signal
    return _short(compared.label) if compared.unit else f"{diagnosis.residual_of}, {_short(compared.symbol)}"


def _fit_pictures(diagnosis: Diagnosis) -> Iterator[Panel]:
    output, named = _short(diagnosis.compared_signal.symbol), _named(diagnosis)
    rows, unseen = _worst_rows(diagnosis.signals)
    where = "rows that were not fitted" if unseen else "the first recording (all of it was fitted)"
    yield Panel(
        f"Recorded and simulated {diagnosis.residual_of}",
        f"The stretch of {where} on which the re-estimated simulation errs most.",
        **wide_panel(partial(_overlay, diagnosis, rows), "Recorded and simulated output, with the input above"),
    )
    drawn = _errors(diagnosis.fit, named)
    yield Panel(
        "Error on rows that were not fitted",
        "Logarithmic. The dashed line is what a perfect model would leave: the noise.",
        inline_svg(drawn, "Errors on held-out rows", zoomable=False),
    )
    yield Panel(
        "Spectrum of the residual",
        "A flat line is noise; a hump or a line is structure.",
        inline_svg(_spectrum(diagnosis, output, named), "Residual spectrum before and after"),
    )
    shaded = "Shaded: rows that were not fitted. " if diagnosis.signals.validates.any() else ""
    located = "Between the dash-dotted lines: where the mismatch was located. " if diagnosis.location.time else ""
    yield Panel(
        "Residual over time",
        f"{shaded}{located}Recorded minus simulated {diagnosis.residual_of}.",
        **wide_panel(partial(_over_time, diagnosis), "Residual over time"),
    )


def _structure_pictures(diagnosis: Diagnosis) -> Iterator[Panel]:
    """Missing force and residual against every signal; nothing where what was found is no force."""
    drawn = shown_as_force(diagnosis)
    if _named(diagnosis) and not drawn and not diagnosis.structured:
        return
    signals, names, state = diagnosis.signals, _names(diagnosis), diagnosis.location.state
    region = {} if state is None else {state[0]: (state[1], state[2])}
    adequate = diagnosis.verdict == "adequate"
    force, verb = f"{'remaining' if adequate else 'missing'} force, {names.source}", "would be" if adequate else "is"
    residual = signals.recorded - signals.refitted
    panels: list[tuple[str, str, Array, Array, str, str, str]] = [
        ("input", f"input {names.command}", signals.signal, signals.equivalent_input, force, "actuator",
         f"A curve here {verb} a fault of the actuator: it depends on the command alone."),
        ("velocity", f"velocity, {names.rate}", signals.velocity, signals.equivalent_input, force, "plant",
         f"A curve here {verb} friction, drag or damping that the simulation does not have."),
        ("position", f"simulated {names.seen}", signals.position, signals.equivalent_input, force, "plant",
         f"A curve here {verb} a stiffness, a stop or a weight that the simulation does not have."),
        ("output", f"simulated {names.seen}", signals.refitted, residual, f"residual, {names.output}",
         "sensor", f"A curve here {verb} a fault of the sensor: it distorts what is seen, not what moves."),
    ]  # fmt: skip
    if diagnosis.residual_of == "control":  # recorded and simulated values are those of the control
        del panels[-1]
    for variable, label, x, y, across, place, caption in panels:
        if variable in drawn or not np.any(np.diff(x[np.isfinite(x)])):
            continue  # it is drawn with its law, or a free decay has no input to draw against
        title = f"{across.split(',')[0].capitalize()} against {variable}"
        axes = _against(x, y, (label, across), region.get(variable))
        yield Panel(title, caption, inline_svg(axes, title), located=_is_located(diagnosis, place, variable))


def _is_located(diagnosis: Diagnosis, place: str, variable: str) -> bool:
    """Whether a panel belongs to the place of the mismatch: where no effect says what it is drawn against."""
    location = diagnosis.location
    if _named(diagnosis) or place != location.place:
        return False
    seen_as = {"output": "position"}
    return location.state is None or location.state[0] in {variable, seen_as.get(variable)}
