"""Fig. 7: estimation errors against the sampling period."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LABELS = {
    "b0": "error in $b_0 = K\\omega_0^2$ (%)",
    "a1": "error in $a_1 = 2\\xi\\omega_0$ (%)",
    "a0": "error in $a_0 = \\omega_0^2$ (%)",
}
LIMITS = {"b0": (-60.0, 20.0), "a1": (-45.0, 45.0), "a0": (-12.0, 36.0)}
# Noise-free errors are rounding; finer digits than this are not printed, so that no
# processor changes the table.
RESOLUTION = 1e-6


def draw(estimates: pd.DataFrame, natural_frequency: float, cases: dict[str, str]) -> tuple[Figure, pd.DataFrame]:
    """Draw the errors of b0, a1 and a0.

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

    def runs(role: str, method: str = "srivc", sample: int | None = None) -> pd.DataFrame:
        chosen = estimates[(estimates["case"] == cases[role]) & (estimates["method"] == method)]
        return chosen if sample is None else chosen[chosen["sample"] == sample]

    figure, panels = plt.subplots(3, 1, figsize=(style.COLUMN_WIDTH * 1.45, 6.0), sharex=True)
    for axes, (parameter, label) in zip(panels, LABELS.items(), strict=True):
        column = f"error_{parameter}"
        held, camera = runs("held"), runs("camera")
        axes.plot(held["period"], held[column], "--", color=style.VERMILION, label="(ii) camera, ZOH")
        _converged(axes, runs("held", "plain-srivc"), column, "s", style.VERMILION, "(ii) by plain SRIVC")
        for sample in sorted(set(runs("noise")["sample"])):
            noise = runs("noise", sample=sample)
            first = sample == 0
            axes.plot(
                noise["period"],
                noise[column],
                ":",
                color=style.BLACK,
                linewidth=0.9,
                label="(iii) camera, FOH, SNR 10" if first else None,
            )
            plain = runs("noise", "plain-srivc", sample)
            _converged(axes, plain, column, ".", style.BLACK, "(iii) by plain SRIVC" if first else None)
        bound = runs("noise", sample=0)
        axes.fill_between(
            bound["period"],
            -2.0 * bound[f"bound_{parameter}"],
            2.0 * bound[f"bound_{parameter}"],
            color="#BBBBBB",
            alpha=0.45,
            linewidth=0.0,
            label="± 2 × Cramér–Rao bound",
        )
        axes.plot(camera["period"], camera[column], "-", color=style.BLUE, linewidth=1.6, label="(i) camera, FOH")
        _converged(axes, runs("camera", "plain-srivc"), column, "o", style.BLUE, "(i) by plain SRIVC")
        axes.axvline(np.pi / natural_frequency, color=style.GREY, linewidth=0.8, linestyle="-.")
        axes.set(ylabel=label, ylim=LIMITS[parameter])
    panels[-1].annotate(
        "Tω$_0$ = π",
        (np.pi / natural_frequency, -10.5),
        xytext=(-3, 0),
        textcoords="offset points",
        ha="right",
        color=style.GREY,
        fontsize=7,
    )
    panels[-1].set(xlabel="sampling period T (s)", xlim=(0.0, 1.03 * np.pi / natural_frequency))
    figure.legend(*_ordered(panels[0]), loc="outside upper center", ncols=2)
    drawn = estimates[estimates["case"].isin(cases.values())]
    errors = [f"error_{p}" for p in LABELS]
    table = drawn[["period", "case", "sample", "method", "converged", *errors, *(f"bound_{p}" for p in LABELS)]].copy()
    # Where plain SRIVC did not converge nothing is drawn, and its numbers mean nothing.
    table.loc[~table["converged"] & (table["method"] == "plain-srivc"), errors] = np.nan
    table[errors] = (table[errors] / RESOLUTION).round() * RESOLUTION + 0.0
    return figure, table


def _converged(axes: Axes, runs: pd.DataFrame, column: str, symbol: str, colour: str, label: str | None) -> None:
    """Markers of the runs that converged; gaps elsewhere."""
    good = runs[runs["converged"]]
    axes.plot(
        good["period"],
        good[column],
        symbol,
        color=colour,
        markersize=2.6,
        markerfacecolor="white",
        markeredgewidth=0.7,
        linestyle="none",
        label=label,
    )


def _ordered(axes: Axes) -> tuple[list[Any], list[str]]:
    """Legend entries in the order of the paper's cases."""
    handles, labels = axes.get_legend_handles_labels()
    order = sorted(range(len(labels)), key=lambda i: labels[i].replace("±", "~"))
    return [handles[i] for i in order], [labels[i] for i in order]
