"""Run time of a diagnosis."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from camid import plotting as style
from camid.proof.targets import LARGEST_TIME, MEDIAN_TIME

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TARGETS = {"median at most": MEDIAN_TIME, "largest at most": LARGEST_TIME}


def draw(run_times: pd.DataFrame) -> tuple[Figure, pd.DataFrame]:
    """Draw the share of the recordings that were diagnosed within a time.

    Parameters
    ----------
    run_times : DataFrame
        ``index``, ``seconds``: of the command in a process that is warm.
    """
    style.apply()
    import matplotlib.pyplot as plt

    seconds = np.sort(run_times["seconds"].to_numpy(float))
    share = 100.0 * np.arange(1, len(seconds) + 1) / len(seconds)
    figure, axes = plt.subplots(figsize=(style.COLUMN_WIDTH, 2.6))
    axes.step(seconds, share, where="post", color=style.BLUE)
    for (words, limit), height in zip(TARGETS.items(), (0.06, 0.06), strict=True):
        axes.axvline(limit, color=style.GREY, linewidth=0.8, linestyle=(0, (4, 2)))
        axes.annotate(
            f"{words} {limit:g} s",
            (limit, height),
            xycoords=("data", "axes fraction"),
            xytext=(-2, 0),
            textcoords="offset points",
            rotation=90,
            ha="right",
            fontsize=6.5,
            color=style.GREY,
        )
    axes.plot(float(np.median(seconds)), 50.0, "o", color=style.VERMILION, label=f"median {np.median(seconds):.2f} s")
    axes.plot(seconds[-1], 100.0, "s", color=style.VERMILION, label=f"largest {seconds[-1]:.1f} s", clip_on=False)
    axes.set(
        xscale="log",
        xlim=(0.8 * min(seconds[0], 1.0), 1.25 * max(seconds[-1], LARGEST_TIME)),
        ylim=(0.0, 102.0),
        xlabel="run time of one diagnosis (s)",
        ylabel="recordings (%)",
    )
    ticks = [t for t in (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100) if axes.get_xlim()[0] <= t <= axes.get_xlim()[1]]
    axes.set_xticks(ticks, [f"{t:g}" for t in ticks])
    axes.minorticks_off()
    axes.legend(loc="upper left")
    return figure, pd.DataFrame({"seconds": seconds, "share": share})
