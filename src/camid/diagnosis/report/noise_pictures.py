"""Pictures of effects that change the noise: histogram, spread, repetition, lattice and correlation. Drawing only."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.diagnosis import Diagnosis
from camid.diagnosis.finding import Finding
from camid.diagnosis.report.panel import (
    DOTS,
    Panel,
    draw_dots,
    inline_svg,
    legend_above,
    new_panel,
    quartiles_of_bins,
    range_of_nearly_all,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

HISTOGRAM_BINS = 61
# Robust standard deviations from the centre at which an ordinary reading ends, and that a histogram shows at most.
ORDINARY, SHOWN = 4.0, 15.0
LAGS = 40
# Steps of a lattice that a picture shows.
STEPS_SHOWN = 8.0
SPREAD_BINS = 16


def _residual(diagnosis: Diagnosis) -> Array:
    """What the improved simulation leaves, on rows where it is known."""
    signals = diagnosis.signals
    residual = signals.recorded - signals.improved
    return residual[np.isfinite(residual)]


def _histogram(diagnosis: Diagnosis, finding: Finding, output: str) -> tuple[Axes, str]:
    from camid import plotting as style

    residual = _residual(diagnosis)
    middle = float(np.median(residual))
    spread = 1.4826 * float(np.median(np.abs(residual - middle))) or float(np.std(residual)) or 1.0
    reach = min(float(np.max(np.abs(residual - middle))), SHOWN * spread) * 1.02
    edges = middle + np.linspace(-reach, reach, HISTOGRAM_BINS + 1)
    counts, _ = np.histogram(np.clip(residual, edges[0], edges[-1]), edges)
    axes = new_panel(top=28.0)
    shown = np.maximum(counts, 0.3)
    axes.stairs(shown, edges, baseline=0.3, fill=True, color=style.BLUE, alpha=0.35)
    centres = 0.5 * (edges[1:] + edges[:-1])
    axes.step(edges, np.append(shown, shown[-1]), where="post", color=style.BLUE, linewidth=1.2, label="rows")
    width = edges[1] - edges[0]
    gauss = len(residual) * width / (spread * np.sqrt(2.0 * np.pi)) * np.exp(-0.5 * ((centres - middle) / spread) ** 2)
    drawn = gauss > 0.3
    axes.plot(centres[drawn], gauss[drawn], "--", color=style.VERMILION, linewidth=2.0, label="Gaussian noise alone")
    _logarithmic(axes, 0.5, 2.0 * float(max(counts.max(), gauss.max())))
    axes.set(xlim=(edges[0], edges[-1]), xlabel=f"residual, {output}", ylabel="rows")
    legend_above(axes, 2)
    outside = int(np.count_nonzero(np.abs(residual - middle) > ORDINARY * spread))
    return axes, (
        f"Histogram of what is left, logarithmic: {outside} of {len(residual)} rows lie beyond four robust standard "
        "deviations, where Gaussian noise has hardly any. The outermost bars hold all that lies farther out."
    )


def _logarithmic(axes: Axes, low: float, high: float) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    from camid.diagnosis.report.panel import decade_text

    axes.set_yscale("log")
    axes.set_ylim(low, high)
    axes.yaxis.set_major_locator(LogLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda v, _: decade_text(v)))
    axes.yaxis.set_minor_formatter(NullFormatter())


def _spread_over_rate(diagnosis: Diagnosis, finding: Finding, output: str) -> tuple[Axes, str]:
    rate = np.gradient(diagnosis.signals.improved, diagnosis.period)
    axes = _spread_over(rate, diagnosis, finding.parameters["std"].value)
    axes.set(xlabel=f"rate of the output, {output}/s", ylabel=f"residual, {output}")
    return axes, "A frame at an uncertain time is wrong in proportion to the rate: what is left fans out on both sides."


def _spread_over_reading(diagnosis: Diagnosis, finding: Finding, output: str) -> tuple[Axes, str]:
    axes = _spread_over(diagnosis.signals.improved, diagnosis, finding.parameters["share"].value)
    axes.set(xlabel=f"simulated reading, {output}", ylabel=f"residual, {output}")
    return axes, "Noise in proportion to the reading: what is left fans out away from zero."


def _spread_over(measure: Array, diagnosis: Diagnosis, deviation: object) -> Axes:
    """The residual against what its spread grows with, and the law: so much for a unit of it."""
    from camid import plotting as style

    residual = diagnosis.signals.recorded - diagnosis.signals.improved
    good = np.isfinite(residual) & np.isfinite(measure)
    measure, residual = measure[good], residual[good]
    axes = new_panel(top=28.0)
    draw_dots(axes, measure, residual)
    centres, quartiles = quartiles_of_bins(measure, residual, SPREAD_BINS)
    for column, label in ((0, "quartiles of the recording"), (2, "_")):
        axes.plot(centres, quartiles[:, column], "-o", color=style.BLUE, markersize=4.0, label=label)
    if isinstance(deviation, float):
        rest = float(np.mean(np.square(residual)) - deviation**2 * np.mean(np.square(measure)))
        grid = np.linspace(float(measure.min()), float(measure.max()), 101)
        half = 0.6745 * np.sqrt(max(rest, 0.0) + (deviation * grid) ** 2)
        for sign, label in ((1.0, "law"), (-1.0, "_")):
            axes.plot(grid, sign * half, "--", color=style.VERMILION, linewidth=2.0, label=label, zorder=4)
    axes.axhline(0.0, color=style.BLACK, linewidth=0.8)
    axes.set(xlim=range_of_nearly_all(measure, share=0.0), ylim=range_of_nearly_all(residual))
    legend_above(axes, 2)
    return axes


def _repetition(diagnosis: Diagnosis, finding: Finding, output: str) -> tuple[Axes, str]:
    from camid import plotting as style

    signals = diagnosis.signals
    moved = np.diff(signals.improved, prepend=signals.improved[:1])
    residual = signals.recorded - signals.improved
    repeated = np.append(False, signals.recorded[1:] == signals.recorded[:-1])
    axes = new_panel(top=28.0)
    draw_dots(axes, moved[~repeated], residual[~repeated])
    axes.plot([], [], "o", color=DOTS, markersize=3.0, label="frames")
    axes.plot(moved[repeated], residual[repeated], "o", color=style.BLUE, markersize=4.5, label="repeated frames")
    ends = np.array([float(np.nanmin(moved)), float(np.nanmax(moved))])
    axes.plot(ends, -ends, "--", color=style.VERMILION, linewidth=2.0, label="law", zorder=4)
    axes.axhline(0.0, color=style.BLACK, linewidth=0.8)
    axes.set(xlim=range_of_nearly_all(moved, share=0.0), ylim=range_of_nearly_all(residual, -ends, share=0.0))
    axes.set(xlabel=f"way since the last frame, {output}", ylabel=f"residual, {output}")
    legend_above(axes, 3)
    count = int(np.count_nonzero(repeated))
    return axes, (
        f"{count} of {len(moved)} frames repeat the last one to the last digit; they lag behind by the way since then, "
        "which is the falling line. All others scatter about zero."
    )


def _lattice(diagnosis: Diagnosis, finding: Finding, output: str) -> tuple[Axes, str]:
    from camid import plotting as style

    signals = diagnosis.signals
    step = finding.parameters["step"].value
    size = float(step) if isinstance(step, int | float) else 1.0
    centre = size * round(float(np.median(signals.improved)) / size)
    reach = 0.5 * STEPS_SHOWN * size
    axes = new_panel(top=28.0)
    near = np.abs(signals.improved - centre) <= 1.2 * reach
    draw_dots(axes, signals.improved[near], signals.recorded[near], style.BLUE, 3.2)
    axes.plot([], [], "o", color=style.BLUE, markersize=3.0, label="recording")
    levels = centre + size * np.arange(-STEPS_SHOWN, STEPS_SHOWN + 1.0)
    stairs = np.repeat(levels, 2)
    edges = np.column_stack([levels - 0.5 * size, levels + 0.5 * size]).ravel()
    axes.plot(edges, stairs, "--", color=style.VERMILION, linewidth=1.6, label="law", zorder=4)
    axes.set(xlim=(centre - reach, centre + reach), ylim=(centre - 1.15 * reach, centre + 1.15 * reach))
    axes.set(xlabel=f"simulated, {output}", ylabel=f"recorded, {output}")
    legend_above(axes, 2)
    return axes, "A stretch of the range: readings come in steps, whatever the motion between them."


def _past(diagnosis: Diagnosis, finding: Finding, output: str) -> tuple[Axes, str]:
    from camid import plotting as style

    residual = _residual(diagnosis)
    residual = residual - residual.mean()
    lags = np.arange(1, min(LAGS, len(residual) // 4) + 1)
    power = float(residual @ residual) or 1.0
    found = np.array([float(residual[k:] @ residual[:-k]) / power for k in lags])
    axes = new_panel(top=28.0)
    axes.vlines(lags, 0.0, found, color=style.BLUE, linewidth=1.4)
    axes.plot(lags, found, "o", color=style.BLUE, markersize=4.0, label="what is left")
    spectrum = finding.parameters["spectrum"].value
    if isinstance(spectrum, list | tuple):
        axes.plot(
            lags, _correlation([float(a) for a in spectrum], lags), "--", color=style.VERMILION, linewidth=2.0,
            label="law", zorder=4,
        )  # fmt: skip
    half = 1.96 / np.sqrt(len(residual))
    axes.axhspan(-half, half, color=DOTS, alpha=0.35, linewidth=0, label="white noise (95 %)")
    axes.axhline(0.0, color=style.BLACK, linewidth=0.8)
    axes.set(xlim=(0.0, lags[-1] + 1.0), ylim=range_of_nearly_all(found, np.array([-half, half, 0.0]), share=0.0))
    axes.set(xlabel="lag, rows", ylabel="correlation of the residual")
    legend_above(axes, 3)
    return (
        axes,
        "Noise whose samples depend on each other is correlated with its own past; white noise stays in the grey band.",
    )


def _correlation(coefficients: list[float], lags: NDArray[np.int_]) -> Array:
    """Correlation of the autoregression n_k = Σ α_i n_(k-i) + ε_k, from its impulse response."""
    length = 1024
    response = np.zeros(length)
    response[0] = 1.0
    for k in range(1, length):
        response[k] = sum(a * response[k - i] for i, a in enumerate(coefficients[:k], 1))
    power = float(response @ response)
    return np.array([float(response[k:] @ response[:-k]) / power for k in lags.tolist()])


TITLES: dict[str, tuple[str, Callable[[Diagnosis, Finding, str], tuple[Axes, str]]]] = {
    "histogram": ("histogram of the residual", _histogram),
    "spread over the rate": ("spread of the residual against the rate of the output", _spread_over_rate),
    "spread over the reading": ("spread of the residual against the reading", _spread_over_reading),
    "repetition": ("residual against the way since the last frame", _repetition),
    "lattice": ("recorded against simulated output", _lattice),
    "past": ("correlation of the residual with its past", _past),
}


def noise_pictures(against: str, diagnosis: Diagnosis, finding: Finding, output: str, located: bool) -> Iterator[Panel]:
    """The panel of an effect on the noise."""
    words, draw = TITLES[against]
    axes, caption = draw(diagnosis, finding, output)
    heading = f"{finding.title}: {words}"
    yield Panel(heading, caption, inline_svg(axes, heading), located=located)
