"""Fig. 6: Bode diagrams of the three camera models."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOOKS = {
    1: ("Model #1", style.BLUE, "-", 1.2),
    2: ("Model #2", style.VERMILION, "--", 1.2),
    3: ("Model #3", style.BLACK, ":", 2.2),
}
FLOOR_DECIBELS = -60.0
PERIODS_OF_ZEROS = 4  # zeros of Model #1 that are drawn, the last one at 4/T


def draw(responses: pd.DataFrame, period: float) -> tuple[Figure, pd.DataFrame]:
    """Draw gain and phase to several times 1/T, with the zeros marked.

    Parameters
    ----------
    responses : DataFrame
        From :func:`camid.paper.fig6_camera_models.runs.camera_model_responses`.
    period : float
        T in seconds.
    """
    style.apply()
    import matplotlib.pyplot as plt

    frequency = responses["frequency"].to_numpy()
    turns = frequency * period
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(style.COLUMN_WIDTH * 1.45, 4.2), sharex=True)
    with np.errstate(divide="ignore"):
        gains = {n: 20.0 * np.log10(responses[f"gain_{n}"].to_numpy()) for n in LOOKS}
    for number, (label, colour, line, width) in LOOKS.items():
        drawn = np.maximum(gains[number], 2.0 * FLOOR_DECIBELS)
        upper.semilogx(frequency, drawn, line, color=colour, linewidth=width, label=label)
    # Models #1 and #2 share their phase up to whole half turns at the zeros, so the phases lie on each other.
    for number, (_, colour, line, width) in reversed(LOOKS.items()):
        lower.semilogx(frequency, responses[f"phase_{number}"], line, color=colour, linewidth=width)
    for first, (step, colour, symbol) in {1.0: (1.0, style.BLUE, "o"), 0.5: (1.0, style.VERMILION, "^")}.items():
        zeros = np.arange(first, min(turns[-1], PERIODS_OF_ZEROS + 0.25), step) / period
        upper.plot(
            zeros,
            np.full(zeros.shape, FLOOR_DECIBELS + 2.5),
            symbol,
            color=colour,
            markerfacecolor="white",
            clip_on=False,
        )
    upper.plot([], [], "o", color=style.BLUE, markerfacecolor="white", label="zeros of #1: (1 + k)/T")
    upper.plot([], [], "^", color=style.VERMILION, markerfacecolor="white", label="zeros of #2: (½ + k)/T")
    for axes in (upper, lower):
        axes.axvline(1.0 / (2.0 * np.pi * period), color=style.GREY, linewidth=0.8, linestyle="-.")
    upper.annotate(
        f"ω = 1/T ({1.0 / (2.0 * np.pi * period):.1f} Hz)",
        (1.0 / (2.0 * np.pi * period), -34.0),
        xytext=(-4, 0),
        textcoords="offset points",
        ha="right",
        color=style.GREY,
        fontsize=7,
    )
    upper.set(ylabel="gain (dB)", ylim=(FLOOR_DECIBELS, 5.0))
    upper.legend(loc="lower left")
    lower.set(ylabel="phase (°)", xlabel=f"frequency (Hz), T = {1e3 * period:g} ms", xlim=(frequency[0], frequency[-1]))
    lower.set_yticks(np.arange(-900, 1, 180))
    lower.set_ylim(-920, 20)
    table = responses.assign(**{f"gain_{n}_decibels": np.maximum(gains[n], -200.0) for n in LOOKS})
    return figure, table
