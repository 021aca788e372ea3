"""Fig. 7: estimation errors against the sampling period."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from camid import plotting as style
from camid.paper.cases import with_gain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# The paper draws K, and the fit has b0 = K ω0²: both.
LABELS = {
    "K": "error in $K = b_0/a_0$ (%)",
    "b0": "error in $b_0 = K\\omega_0^2$ (%)",
    "a1": "error in $a_1 = 2\\xi\\omega_0$ (%)",
    "a0": "error in $a_0 = \\omega_0^2$ (%)",
}
# Limits of the magnified panels in percent: what noise does to the parameter.
MAGNIFIED = {"K": 8.0, "b0": 8.0, "a1": 15.0, "a0": 2.0}
BOUNDED = ("b0", "a1", "a0")
FAR = 60.0  # percent: converged, but to another optimum
# Noise sample → colour, line, symbol of plain SRIVC.
SAMPLES = ((style.BLACK, ":", "."), (style.GREEN, "-.", "x"))
# Noise-free errors are rounding; finer digits than this are not printed, so that no
# processor changes the table.
RESOLUTION = 1e-6


def draw(estimates: pd.DataFrame, natural_frequency: float, cases: dict[str, str]) -> tuple[Figure, pd.DataFrame]:
    """Draw the errors of K, b0, a1 and a0: at the left all of them, at the right magnified to what noise does.

    Parameters
    ----------
    estimates : DataFrame
        From :func:`camid.paper.fig7_sampling_period.runs.identify_sampling_period`.
    natural_frequency : float
        ω0 in rad/s, for the Shannon limit.
    cases : dict of str to str
        Names of the cases drawn as ``camera``, ``held`` and ``noise``.
    """
    style.apply()
    import matplotlib.pyplot as plt

    estimates = with_gain(estimates)
    shannon = np.pi / natural_frequency
    figure, panels = plt.subplots(len(LABELS), 2, figsize=(style.PAGE_WIDTH, 7.6), sharex=True)
    for (whole, magnified), (parameter, label) in zip(panels, LABELS.items(), strict=True):
        for axes in (whole, magnified):
            axes.axvline(shannon, color=style.GREY, linewidth=0.8, linestyle="-.")
        magnified.set_ylim(-MAGNIFIED[parameter], MAGNIFIED[parameter])
        _draw_errors((whole, magnified), estimates, parameter, cases)
        whole.set_ylabel(label)
        magnified.set_ylabel("magnified (%)")
    panels[0, 1].annotate(
        "Tω$_0$ = π",
        (shannon, 0.12),
        xycoords=("data", "axes fraction"),
        xytext=(-3, 0),
        textcoords="offset points",
        ha="right",
        color=style.GREY,
        fontsize=7,
    )
    for axes in panels[-1]:
        axes.set(xlabel="sampling period T (s)", xlim=(0.0, 1.03 * shannon))
    _add_legend(figure, panels[1, 0])
    drawn = estimates[estimates["case"].isin(cases.values())]
    errors = [f"error_{p}" for p in LABELS]
    table = drawn[["period", "case", "sample", "method", "converged", *errors, *(f"bound_{p}" for p in BOUNDED)]].copy()
    # Where plain SRIVC did not converge nothing is drawn, and its numbers mean nothing.
    table.loc[~table["converged"] & (table["method"] == "plain-srivc"), errors] = np.nan
    table[errors] = (table[errors] / RESOLUTION).round() * RESOLUTION + 0.0
    return figure, table


def _draw_errors(both: tuple[Axes, Axes], estimates: pd.DataFrame, parameter: str, cases: dict[str, str]) -> None:
    """All cases in both panels of a parameter; the limits of the second one are set."""
    column = f"error_{parameter}"

    def runs(role: str, method: str = "srivc", sample: int = -1) -> pd.DataFrame:
        same = (estimates["case"] == cases[role]) & (estimates["method"] == method) & (estimates["sample"] == sample)
        return estimates[same]

    noise = [(runs("noise", sample=s), runs("noise", "plain-srivc", s)) for s in range(len(SAMPLES))]
    drawn = [
        ("(ii) camera, ZOH", runs("held"), runs("held", "plain-srivc"), style.VERMILION, "--", "s", 1.2),
        *(
            (f"(iii) camera, FOH, SNR 10, noise sample {s + 1}", *noise[s], *SAMPLES[s], 0.9)
            for s in range(len(SAMPLES))
        ),
        ("(i) camera, FOH", runs("camera"), runs("camera", "plain-srivc"), style.BLUE, "-", "o", 1.6),
    ]
    both[0].set_ylim(*_limits([curve[column] for _, curve, *_ in drawn]))
    for axes in both:
        if parameter in BOUNDED:
            period, bound = noise[0][0]["period"], 2.0 * noise[0][0][f"bound_{parameter}"]
            words = "± 2 × Cramér–Rao bound (not of K)"
            axes.fill_between(period, -bound, bound, color="#BBBBBB", alpha=0.45, linewidth=0.0, label=words)
        for label, curve, plain, colour, line, symbol, width in drawn:
            axes.plot(curve["period"], curve[column], line, color=colour, linewidth=width, label=label)
            converged = plain[plain["converged"]]
            look: dict[str, Any] = {
                "color": colour,
                "markersize": 2.6,
                "markerfacecolor": "white",
                "markeredgewidth": 0.7,
            }
            axes.plot(converged["period"], converged[column], symbol, linestyle="none", **look)
            style.mark_outside(axes, curve["period"], curve[column], colour)
            # Whoever converges to another optimum stays in sight.
            wrong = converged if axes is both[0] else converged[converged[column].abs() > FAR]
            style.mark_outside(axes, wrong["period"], wrong[column], colour, joined=False)


def _limits(curves: list[pd.Series]) -> tuple[float, float]:
    """Limits that hold all curves, with a margin."""
    low, high = min(float(c.min()) for c in curves), max(float(c.max()) for c in curves)
    margin = 0.06 * (high - low) or 1.0
    return low - margin, high + margin


def _add_legend(figure: Figure, axes: Axes) -> None:
    """Cases in the order of the paper, and what lines, markers and triangles mean."""
    from matplotlib.lines import Line2D

    entries = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    handles: list[Any] = [entries[label] for label in sorted(entries, key=lambda label: label.replace("±", "~"))]
    meanings: tuple[tuple[str, dict[str, Any]], ...] = (
        ("lines: safeguarded SRIVC (the default)", {"linestyle": "-"}),
        (
            "markers: plain SRIVC, drawn where it converges",
            {"marker": "s", "linestyle": "none", "markersize": 3.5, "markerfacecolor": "white"},
        ),
    )
    handles += [Line2D([], [], color=style.GREY, label=label, **look) for label, look in meanings]
    handles.append(style.outside_handle("leaves the axis here"))
    figure.legend(handles=handles, loc="outside upper center", ncols=2)
