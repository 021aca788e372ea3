"""Fig. 3: trajectories from image processing and from the simplified model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw(trajectory: pd.DataFrame, frequency: float) -> tuple[Figure, pd.DataFrame]:
    """Draw measured and modelled positions, and their difference along and across the circle.

    Parameters
    ----------
    trajectory : DataFrame
        From :func:`camid.paper.fig3_marker_trajectory.runs.slow_marker_trajectory`.
        Its signal-to-noise ratio is stated in the figure: power of the model's motion over that of the difference.
    frequency : float
        Hz.
    """
    style.apply()
    import matplotlib.pyplot as plt

    model = trajectory[["model_x", "model_y"]].to_numpy()
    measured = trajectory[["measured_x", "measured_y"]].to_numpy()
    grey = trajectory[["grey_level_x", "grey_level_y"]].to_numpy()
    signal_to_noise = float(trajectory["signal_to_noise"].iloc[0])
    outward = model - model.mean(axis=0)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    along = np.stack([-outward[:, 1], outward[:, 0]], axis=1)
    table = trajectory.assign(
        radial_error=np.sum((measured - model) * outward, axis=1),
        tangential_error=np.sum((measured - model) * along, axis=1),
        grey_level_radial_error=np.sum((grey - model) * outward, axis=1),
    )
    figure, (left, right) = plt.subplots(1, 2, figsize=(style.PAGE_WIDTH, 2.9), width_ratios=[1.0, 1.25])
    closed = np.vstack([model, model[:1]])
    left.plot(
        closed[:, 0], closed[:, 1], "-o", color=style.BLUE, markerfacecolor="white", label="simplified model (4), (5)"
    )
    left.plot(
        measured[:, 0],
        measured[:, 1],
        "+",
        color=style.VERMILION,
        markersize=8,
        markeredgewidth=1.3,
        label="image processing",
    )
    left.set(
        xlabel="x (px)",
        ylabel="y (px)",
        aspect="equal",
        title=f"circle at {frequency:g} Hz, SNR {signal_to_noise:.1f} dB",
    )
    left.invert_yaxis()
    left.legend(loc="center", fontsize=6.5)
    time = 1e3 * trajectory["time"]
    right.plot(
        time, table["radial_error"], "-+", color=style.VERMILION, markersize=7, label="gradient centroid, outward"
    )
    right.plot(
        time,
        table["tangential_error"],
        "--x",
        color=style.ORANGE,
        markersize=5,
        label="gradient centroid, along the path",
    )
    right.plot(time, table["grey_level_radial_error"], ":.", color=style.BLACK, label="grey-level centroid, outward")
    right.axhline(0.0, color=style.GREY, linewidth=0.6)
    low, high = right.get_ylim()
    right.set(xlabel="time (ms)", ylabel="difference from the model (px)", ylim=(low, high + 0.45 * (high - low)))
    right.set_xticks(time)  # one per frame
    right.set_title("measurement error, frame by frame")
    right.legend(loc="upper right")
    return figure, table
