"""Figures of the real recordings: a telling stretch, the law that was found, and the residual before and after."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from camid import plotting as style
from camid.real_recordings.laws import Law
from camid.real_recordings.results import RECORDINGS, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# What is drawn of each recording: label, factor to its unit, and the stretch in seconds that shows the difference best.
SIGNALS: dict[str, tuple[str, float, tuple[float, float]]] = {
    "silverbox": ("V2 (mV)", 1e3, (92.0, 92.15)),
    "emps": ("force of the drive (N)", 1.0, (20.0, 24.8)),
    "pendulum_decay": ("angle (rad)", 1.0, (42.5, 47.5)),
    "pendulum_clip": ("marker position x (px)", 1.0, (1.95, 2.65)),
    "pendulum2_decay": ("angle (rad)", 1.0, (18.8, 23.8)),
    "coupled_drives": ("speed as counted (a.u.)", 1.0, (8.0, 9.98)),
    "cascaded_tanks": ("level (V)", 1.0, (816.0, 4092.0)),
}
LOOKS: dict[str, dict[str, Any]] = {
    "recorded": {"color": "#B0B0B0", "linewidth": 3.0, "linestyle": "-"},
    "refitted": {"color": style.VERMILION, "linewidth": 1.1, "linestyle": "--"},
    "improved": {"color": style.BLUE, "linewidth": 0.9, "linestyle": "-"},
}
# Significant digits of the results: a fit of a nonlinear model settles to eight, and the order in which effects are
# tried decides on the ninth.
SETTLED_DIGITS = 7
# The improved law without what was learned beside it.
NAMED = {"color": style.BLUE, "linewidth": 1.0, "linestyle": (0, (3, 1.5))}
LAW_LABELS = {"named": "the named law", "improved": "with the learned force"}
RESIDUAL_COLOURS = {"refitted": "#E8A27C", "improved": style.BLUE}


def draw(results: Results, law: Law) -> Figure:
    """Draw what was recorded, what was simulated before and after the diagnosis, and the law between.

    Parameters
    ----------
    results : Results
    law : Law
    """
    style.apply()
    import matplotlib.pyplot as plt

    label, factor, (start, end) = SIGNALS[results.name]
    table = _drawn(results)
    time = table["t"].to_numpy()
    figure = plt.figure(figsize=(style.PAGE_WIDTH, 4.3))
    grid = figure.add_gridspec(2, 2, width_ratios=[1.55, 1.0], height_ratios=[1.25, 1.0])
    above, beside, below = (figure.add_subplot(g) for g in (grid[0, 0], grid[0, 1], grid[1, :]))
    rows = (time >= start) & (time <= end)
    for name in ("recorded", *_models(results)):
        above.plot(time[rows], factor * table[name].to_numpy()[rows], label=name, **LOOKS[name])
    above.set(xlabel="time (s)", ylabel=label, title=_stretch(table, rows), xlim=(time[rows][0], time[rows][-1]))
    if not rows.all():
        for edge in (time[rows][0], time[rows][-1]):
            below.axvline(edge, color=style.GREY, linewidth=0.8, linestyle=(0, (4, 2)))
    handles, labels = above.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3, title=RECORDINGS[results.name])
    _draw_law(beside, law)
    _draw_residuals(below, results, factor, label)
    return figure


def _drawn(results: Results) -> pd.DataFrame:
    """Rows that are drawn: of several recordings the last one, which validates."""
    table = results.residuals
    return table[table["recording"] == table["recording"].max()] if "recording" in table else table


def _models(results: Results) -> tuple[str, ...]:
    """Models that differ: where nothing was named, the improved one is the refitted one."""
    return ("refitted", "improved") if results.diagnosis["effects"] else ("refitted",)


def _stretch(table: pd.DataFrame, rows: Any) -> str:
    """Which part of the recording is drawn, and whether it was fitted."""
    time, fitted = table["t"].to_numpy(), table["fitted"].to_numpy()[rows] != 0
    if rows.all():
        return "the whole recording"
    drawn, whole = (f"{t:.0f}" if t >= 100.0 else f"{t:.3g}" for t in (np.ptp(time[rows]), np.ptp(time)))
    seen = "fitted" if fitted.all() else "not fitted" if not fitted.any() else "partly fitted"
    return f"{drawn} s of {whole} s ({seen}), between the dashed lines below"


def _draw_law(axes: Any, law: Law) -> None:
    if len(law.low):
        axes.fill_between(law.position, law.low, law.high, color="#D0D0D0", linewidth=0.0, label="quartiles")
    axes.plot(law.position, law.middle, "o", color=style.BLACK, markersize=2.6, label="recording")
    drawn = [
        axes.plot(abscissa, ordinate, label=LAW_LABELS.get(name), **_look_of_law(name))[0]
        for name, (abscissa, ordinate) in law.curves.items()
    ]
    if "named" in law.curves:
        axes.legend(handles=[d for d in drawn if d.get_label() in LAW_LABELS.values()], loc="upper left")
    axes.set(xlabel=law.abscissa, ylabel=law.ordinate, title=law.title)


def _look_of_law(name: str) -> dict[str, Any]:
    return NAMED if name == "named" else {**LOOKS[name], "linewidth": 1.4}


def _draw_residuals(axes: Any, results: Results, factor: float, label: str) -> None:
    table = _drawn(results)
    time = table["t"].to_numpy()
    unit = label[label.rindex("(") + 1 : -1]
    for name in _models(results):
        residual = factor * table[f"residual_{name}"].to_numpy()
        size = float(np.sqrt(np.mean(residual**2)))
        axes.plot(time, residual, color=RESIDUAL_COLOURS[name], linewidth=0.5, label=f"{name}: rms {size:.3g} {unit}")
    held_out = time[table["fitted"].to_numpy() == 0]
    if len(held_out):
        axes.axvspan(held_out[0], held_out[-1], color="#EEEEEE", zorder=-1, label="not fitted")
    axes.set(xlabel="time (s)", ylabel=f"residual ({unit})", xlim=(time[0], time[-1]))
    legend = axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.1)
    for line in legend.get_lines():
        line.set_linewidth(2.0)
