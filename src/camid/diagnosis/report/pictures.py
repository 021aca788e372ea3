"""Pictures of the report: what the recording looks like before and after, as small inline SVG. Drawing only.

Each panel is a figure of its own, so that the page can set them side by side on a desk and one below the other on a
telephone. They keep their text as text, and dense scatters are one path of dots.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import StringIO
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.diagnosis import Diagnosis, NormalisedErrors, Signals
from camid.number_text import percentage, plain, printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

POINTS_PER_INCH = 72.0
PANEL, WIDE = (420.0, 262.0), (880.0, 250.0)  # points; the page shows a point as about a pixel
LARGEST_SCATTER, LARGEST_LINE = 900, 1200
BINS, LEAST_IN_BIN, MOST_LEVELS = 20, 5, 12
ZOOMED_ROWS = 150
DIGITS_OF_COORDINATES = 2
FONTS = "'DejaVu Sans', Verdana, sans-serif"  # Verdana has the widths of DejaVu Sans, with which the panel was laid out


@dataclass(frozen=True)
class Panel:
    """A panel of the page.

    Attributes
    ----------
    title, caption : str
    svg : str
        Inline, without identifiers that could clash.
    wide : bool
        Whether it takes the whole width.
    located : bool
        Whether it shows the signal that the located mismatch depends on.
    """

    title: str
    caption: str
    svg: str
    wide: bool = False
    located: bool = False


@contextmanager
def _look() -> Iterator[None]:
    """The project's look, without a trace in the caller's settings of matplotlib."""
    import matplotlib as mpl

    from camid import plotting as style

    defaults = {k: v for k, v in mpl.rcParamsDefault.items() if not k.startswith(("backend", "interactive", "toolbar"))}
    with mpl.rc_context():
        mpl.rcParams.update(defaults)
        mpl.rcParams.update(style.SETTINGS)
        mpl.rcParams.update(
            {
                "font.size": 11.0,
                "axes.labelsize": 11.0,
                "xtick.labelsize": 10.0,
                "ytick.labelsize": 10.0,
                "legend.fontsize": 10.0,
                "figure.constrained_layout.use": False,
                "svg.fonttype": "none",
                "text.parse_math": False,  # a column may be called $x
                "axes.formatter.useoffset": False,
                "path.simplify_threshold": 0.3,
            }
        )
        yield


def _panel(size: tuple[float, float] = PANEL, left: float = 66.0, top: float = 12.0) -> Axes:
    """Axes on a new figure, with margins in points."""
    from matplotlib.figure import Figure

    width, height = size
    figure = Figure(figsize=(width / POINTS_PER_INCH, height / POINTS_PER_INCH))
    bottom, right = 46.0, 14.0
    box = (left / width, bottom / height, 1.0 - (left + right) / width, 1.0 - (bottom + top) / height)
    return figure.add_axes(box)


def _svg(axes: Axes, label: str) -> str:
    """The figure as inline SVG: no header, no identifiers of groups, short coordinates."""
    from html import escape

    from matplotlib.backends.backend_svg import FigureCanvasSVG

    text = StringIO()
    FigureCanvasSVG(axes.get_figure(root=True)).print_svg(text)
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", svg, flags=re.DOTALL)
    svg = re.sub(r'<g id="[^"]*">', "<g>", svg).replace("'DejaVu Sans'", FONTS)
    view = re.search(r'viewBox="[^"]*"', svg)
    head = f'<svg role="img" aria-label="{escape(label)}" {view.group() if view else ""}>'
    svg = head + svg[svg.index(">") + 1 :].replace("xlink:href", "href")

    def shorten(match: re.Match[str]) -> str:
        return re.sub(r"-?\d+\.\d+", lambda m: f"{float(m.group()):.{DIGITS_OF_COORDINATES}f}", match.group())

    return re.sub(r'\b(?:d|x|y|width|height|transform)="[^"]*"', shorten, svg)


def _thinned(time: Array, values: Array) -> tuple[Array, Array]:
    """Extremes of runs of rows, where there are more rows than a line can show."""
    size = -(-len(time) // (LARGEST_LINE // 2))
    if size <= 2:
        return time, values
    count = len(time) // size * size
    blocks = np.nan_to_num(values[:count]).reshape(-1, size)
    first = np.arange(len(blocks)) * size
    both = np.sort(np.stack([first + blocks.argmin(1), first + blocks.argmax(1)]), axis=0)
    rows = both.T.ravel()
    return time[rows], values[rows]


def _limits(*values: Array, share: float = 0.4) -> tuple[float, float]:
    """Range of nearly all values, so that a few outliers do not flatten the picture."""
    finite = np.concatenate([v[np.isfinite(v)] for v in values])
    if not finite.size:
        return -1.0, 1.0
    low, high = np.percentile(finite, [share, 100.0 - share])
    margin = 0.06 * (high - low) or max(abs(low), 1.0) * 0.1
    return float(low - margin), float(high + margin)


def _dots(axes: Axes, x: Array, y: Array, colour: str, size: float = 2.6) -> None:
    """Scatter as one path: every dot is a line of no length with round ends, which takes 30 bytes."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    rows = np.linspace(0, len(x) - 1, min(len(x), LARGEST_SCATTER)).astype(int)
    vertices = np.repeat(np.column_stack([x[rows], y[rows]]), 2, axis=0)
    path = Path(vertices, np.tile([Path.MOVETO, Path.LINETO], len(rows)))
    path.should_simplify = False
    patch = PathPatch(path, facecolor="none", edgecolor=colour, linewidth=size, capstyle="round", zorder=1.5)
    axes.add_artist(patch)
    patch.set_clip_path(axes.patch)


def _bins(x: Array, y: Array) -> tuple[Array, Array]:
    """Centres of bins of x, shape (B,), and quartiles of y in them, shape (B, 3); few levels are a bin each."""
    levels = np.unique(x)
    if len(levels) <= MOST_LEVELS:
        groups, index = levels, np.searchsorted(levels, x)
    else:
        low, high = np.percentile(x, [1.0, 99.0])
        edges = np.linspace(low, high, BINS + 1)
        groups, index = 0.5 * (edges[1:] + edges[:-1]), np.digitize(x, edges) - 1
    kept = [i for i in range(len(groups)) if np.count_nonzero(index == i) >= LEAST_IN_BIN]
    quartiles = np.array([np.percentile(y[index == i], [25.0, 50.0, 75.0]) for i in kept])
    return groups[kept], quartiles.reshape(-1, 3)


def _against(x: Array, y: Array, labels: tuple[str, str], region: tuple[float, float] | None) -> Axes:
    """Scatter with the median and the quartiles of bins: a curve here is a law that the simulation does not have."""
    from camid import plotting as style

    axes = _panel()
    good = np.isfinite(x) & np.isfinite(y)
    x, y = x[good], y[good]
    if region is not None:
        axes.axvspan(*region, color="#F0E442", alpha=0.25, linewidth=0)
    _dots(axes, x, y, "#B8B8B8")
    centres, quartiles = _bins(x, y) if len(x) else (x, np.zeros((0, 3)))
    axes.fill_between(centres, quartiles[:, 0], quartiles[:, 2], color=style.BLUE, alpha=0.25, linewidth=0, zorder=2)
    axes.plot(centres, quartiles[:, 1], "-o", color=style.BLUE, linewidth=2.0, markersize=4.0, zorder=3)
    axes.axhline(0.0, color=style.BLACK, linewidth=0.8)
    axes.set(xlim=_limits(x, share=0.0), ylim=_limits(y), xlabel=labels[0], ylabel=labels[1])
    return axes


def _shade_held_out(axes: Axes, signals: Signals, period: float, label: str | None = "not fitted") -> None:
    steps = np.flatnonzero(np.diff(np.concatenate([[0], (~signals.fitted).astype(int), [0]])))
    spans = [(signals.time[a] - 0.5 * period, period * (b - a)) for a, b in zip(steps[::2], steps[1::2], strict=True)]
    if spans:
        transform = axes.get_xaxis_transform()
        axes.broken_barh(spans, (0.0, 1.0), transform=transform, color="#E3E3E3", linewidth=0, zorder=0, label=label)


def _legend(axes: Axes, columns: int) -> None:
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, borderaxespad=0.1, handlelength=1.8)


def _subdivisions(low: float, high: float) -> tuple[float, ...]:
    """Where a logarithmic axis has ticks within a decade: more of them where it spans few decades."""
    return (1.0, 2.0, 5.0) if high < 200.0 * low else (1.0,)


def _errors(fit: NormalisedErrors, named: bool) -> Axes:
    """Errors on held-out rows on a logarithmic axis, with the noise floor as a line."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    from camid import plotting as style

    axes = _panel(left=112.0, top=26.0)
    rows = [("as given", fit.nominal, style.GREY, "s"), ("re-estimated", fit.refitted, style.ORANGE, "D")]
    rows += [("improved", fit.improved, style.BLUE, "o")] if named else []
    values = np.array([*(100.0 * value for _, value, _, _ in rows), 100.0 * fit.noise_floor])
    values = np.maximum(np.nan_to_num(values, posinf=1e6), 1e-6)
    low, high = values.min() / 1.6, values.max() * 1.6 * (values.max() / values.min()) ** 0.25
    for i, ((_, share, colour, marker), value) in enumerate(zip(rows, values, strict=False)):
        axes.plot([low, value], [-i, -i], color=colour, linewidth=2.0)
        axes.plot([value], [-i], marker, color=colour, markersize=10.0, markeredgecolor="black", markeredgewidth=0.6)
        axes.annotate(percentage(share), (value, -i), (9.0, 0.0), textcoords="offset points", va="center")
    axes.axvline(values[-1], color=style.BLACK, linestyle="--", linewidth=1.2)
    note = f"noise floor {percentage(fit.noise_floor)}"
    axes.annotate(note, (values[-1], 1.0), (0, 4), xycoords=("data", "axes fraction"), textcoords="offset points")
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=_subdivisions(low, high)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: plain(v)))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set(xlim=(low, high), ylim=(0.6 - len(rows), 0.6), xlabel="error, % of the output's standard deviation")
    axes.set_yticks([-i for i in range(len(rows))], [name for name, *_ in rows])
    axes.grid(visible=False, axis="y")
    return axes


def _overlay(signals: Signals, output: str, named: bool) -> tuple[Axes, bool]:
    """Recorded and simulated output where the refitted simulation errs most, if possible on rows not fitted."""
    from camid import plotting as style

    squares = np.nan_to_num((signals.recorded - signals.refitted) ** 2)
    size = min(ZOOMED_ROWS, len(squares))
    held = ~signals.fitted
    inside = np.convolve(held, np.ones(size), mode="valid") >= size - 0.5
    sums = np.convolve(squares, np.ones(size), mode="valid")
    unseen = bool(inside.any())
    first = int(np.argmax(np.where(inside, sums, -1.0) if unseen else sums))
    rows = slice(first, first + size)
    time = signals.time[rows]
    axes = _panel(WIDE, top=28.0)
    recorded: dict[str, Any] = {
        "color": style.BLACK,
        "markersize": 4.2,
        "markerfacecolor": "white",
        "markeredgewidth": 0.7,
    }
    axes.plot(time, signals.recorded[rows], "o", label="recorded", **recorded)
    axes.plot(time, signals.nominal[rows], ":", color=style.GREY, linewidth=1.6, label="as given")
    axes.plot(time, signals.refitted[rows], "--", color=style.ORANGE, linewidth=2.0, label="re-estimated")
    if named:
        axes.plot(time, signals.improved[rows], color=style.BLUE, linewidth=1.6, label="improved")
    axes.set(xlim=(time[0], time[-1]), xlabel="time, s", ylabel=output)
    _legend(axes, 4)
    return axes, unseen


def _over_time(diagnosis: Diagnosis, output: str, named: bool) -> Axes:
    from camid import plotting as style

    signals = diagnosis.signals
    axes = _panel(WIDE, top=28.0)
    _shade_held_out(axes, signals, diagnosis.period)
    before, after = signals.recorded - signals.refitted, signals.recorded - signals.improved
    axes.plot(
        *_thinned(signals.time, before),
        color=style.ORANGE,
        linewidth=0.9,
        label="before (re-estimated)" if named else "re-estimated",
    )
    if named:
        axes.plot(*_thinned(signals.time, after), color=style.BLUE, linewidth=0.9, label="after (improved)")
    if diagnosis.location.time is not None:
        for edge in diagnosis.location.time:
            axes.axvline(edge, color=style.BLACK, linestyle="-.", linewidth=1.0)
    axes.set(xlim=(signals.time[0], signals.time[-1]), ylim=_limits(before, after, share=0.05))
    axes.set(xlabel="time, s", ylabel=f"residual, {output}")
    _legend(axes, 3)
    return axes


def _spectrum(diagnosis: Diagnosis, output: str, named: bool) -> Axes:
    from matplotlib.mlab import psd
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    from camid import plotting as style

    signals = diagnosis.signals
    axes = _panel(top=28.0)
    lines = [("before" if named else "re-estimated", signals.refitted, style.ORANGE, "-")]
    lines += [("after", signals.improved, style.BLUE, "-")] if named else []
    count = min(256, max(16, len(signals.time) // 4))
    if diagnosis.location.frequency is not None:
        axes.axvspan(*diagnosis.location.frequency, color="#F0E442", alpha=0.25, linewidth=0)
    for label, simulated, colour, line in lines:
        residual = np.nan_to_num(signals.recorded - simulated)
        welch = psd(residual - residual.mean(), NFFT=count, Fs=1.0 / diagnosis.period, noverlap=count // 2)
        power, frequency = (np.asarray(part) for part in welch)
        level = np.sqrt(np.maximum(power[1:], np.finfo(float).tiny))
        axes.semilogy(frequency[1:], level, line, color=colour, linewidth=1.5, label=label)
    axes.yaxis.set_major_locator(LogLocator(subs=_subdivisions(*axes.get_ylim())))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda v, _: plain(v)))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set(xlim=(0.0, 0.5 / diagnosis.period), xlabel="frequency, Hz", ylabel=f"residual, {output}/√Hz")
    _legend(axes, 2)
    return axes


def draw(diagnosis: Diagnosis) -> dict[str, list[Panel]]:
    """Draw all panels.

    Returns
    -------
    dict of str to list of Panel
        ``fit`` (before and after) and ``structure`` (where the mismatch sits).
    """
    with _look():
        return {"fit": list(_fit_pictures(diagnosis)), "structure": list(_structure_pictures(diagnosis))}


def _fit_pictures(diagnosis: Diagnosis) -> Iterator[Panel]:
    output = _short(diagnosis.compared)
    named = bool(diagnosis.findings)
    drawn = _errors(diagnosis.fit, named)
    yield Panel(
        "Error on rows that were not fitted",
        "Logarithmic. The dashed line is what a perfect model would leave: the noise.",
        _svg(drawn, "Errors on held-out rows"),
    )
    yield Panel(
        "Spectrum of the residual",
        "A flat line is noise; a hump or a line is structure.",
        _svg(_spectrum(diagnosis, output, named), "Residual spectrum before and after"),
    )
    drawn, unseen = _overlay(diagnosis.signals, output, named)
    where = "rows that were not fitted" if unseen else "the first recording (all of it was fitted)"
    yield Panel(
        f"Recorded and simulated {diagnosis.residual_of}",
        f"The stretch of {where} on which the re-estimated simulation errs most.",
        _svg(drawn, "Recorded and simulated output, zoomed"),
        wide=True,
    )
    yield Panel(
        "Residual over time",
        "Recorded minus simulated output. Grey: rows that were not fitted."
        + (" Between the vertical lines: where the mismatch sits." if diagnosis.location.time else ""),
        _svg(_over_time(diagnosis, output, named), "Residual over time before and after"),
        wide=True,
    )


def _short(name: str, longest: int = 22) -> str:
    name = printable(name)
    return name if len(name) <= longest else name[: longest - 1] + "…"


def _structure_pictures(diagnosis: Diagnosis) -> Iterator[Panel]:
    signals, names, state = diagnosis.signals, diagnosis.improved, diagnosis.location.state
    output, source = _short(names.output_column), _short(names.input_column or "u")
    region = {} if state is None else {state[0]: (state[1], state[2])}
    seen_as = {"output": "position"}
    adequate = diagnosis.verdict == "adequate"
    missing = "remaining force" if adequate else "missing force"
    force, verb = f"{missing}, {source}", "would be" if adequate else "is"
    residual = signals.recorded - signals.refitted
    panels: list[tuple[str, str, Array, Array, str, Any, str]] = [
        ("input", f"input {source}", signals.signal, signals.equivalent_input, force, "actuator",
         f"A curve here {verb} a fault of the actuator: it depends on the command alone."),
        ("velocity", f"velocity, {output}/s", signals.velocity, signals.equivalent_input, force, "plant",
         f"A curve here {verb} friction, drag or damping that the simulation does not have."),
        ("position", f"simulated {output}", signals.position, signals.equivalent_input, force, "plant",
         f"A curve here {verb} a stiffness, a stop or a weight that the simulation does not have."),
        ("output", f"simulated {output}", signals.refitted, residual, f"residual, {output}", "sensor",
         f"A curve here {verb} a fault of the sensor: it distorts what is seen, not what moves."),
    ]  # fmt: skip
    if diagnosis.residual_of == "control":  # recorded and simulated values are those of the control
        del panels[-1]
    for variable, label, x, y, across, place, caption in panels:
        if not np.any(np.diff(x[np.isfinite(x)])):
            continue  # a free decay has no input to draw against
        title = f"{across.split(',')[0].capitalize()} against {variable}"
        axes = _against(x, y, (label, across), region.get(variable))
        located = place == diagnosis.location.place and (state is None or state[0] in {variable, seen_as.get(variable)})
        yield Panel(title, caption, _svg(axes, title), located=located)
