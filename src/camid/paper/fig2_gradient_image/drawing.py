"""Fig. 2: the gradient image and its centre of mass."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw(image: Mapping[str, NDArray[Any]], threshold: float) -> tuple[Figure, pd.DataFrame]:
    """Draw the gradient, the pixels above the threshold and the centres.

    Parameters
    ----------
    image : mapping of str to ndarray
        From :func:`camid.paper.fig1_marker_image.runs.fast_marker_image`.
    threshold : float
        Share of the largest gradient.

    Returns
    -------
    figure : matplotlib.figure.Figure
    table : DataFrame
        The centres and the number of selected pixels.
    """
    style.apply()
    gradient, selected = image["gradient"], image["selected"]
    centres = {name: image[name] for name in ("centroid", "time_mean")}  # measurement and simplified model
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(style.PAGE_WIDTH, 2.75), sharex=True, sharey=True)
    shown = left.imshow(gradient, cmap="gray_r", vmin=0.0, interpolation="nearest")
    left.set(title="gradient (Sobel)", xlabel="x (px)", ylabel="y (px)")
    bar = figure.colorbar(shown, ax=left, shrink=0.82, pad=0.02)
    style.separate_panels(figure)
    bar.set_label("grey levels per pixel")
    bar.outline.set_linewidth(0.6)
    right.imshow(np.where(selected, 0.55, 1.0), cmap="gray", vmin=0.0, vmax=1.0, interpolation="nearest")
    right.set(title=f"above {100 * threshold:g} % of its maximum", xlabel="x (px)")
    right.tick_params(labelleft=False)
    for axes in (left, right):
        axes.grid(visible=False)
        axes.plot(
            *centres["centroid"], "+", color=style.VERMILION, markersize=9, markeredgewidth=1.4, label="centre of mass"
        )
        axes.plot(
            *centres["time_mean"], "o", color=style.BLUE, markersize=6, markerfacecolor="none", label="simplified model"
        )
        axes.legend(loc="lower right")
    table = pd.DataFrame(
        [
            {"quantity": f"{name}_{axis}", "value": float(value), "unit": "px"}
            for name, centre in centres.items()
            for axis, value in zip("xy", centre, strict=True)
        ]
        + [
            {"quantity": "selected_pixels", "value": float(selected.sum()), "unit": ""},
            {"quantity": "largest_gradient", "value": float(gradient.max()), "unit": "grey levels per pixel"},
        ]
    )
    return figure, table
