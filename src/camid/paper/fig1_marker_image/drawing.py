"""Fig. 1: image produced by a fast circular displacement of the marker, and the trajectory of its centre."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid import plotting as style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw(image: Mapping[str, NDArray[Any]]) -> tuple[Figure, pd.DataFrame]:
    """Draw the image with the trajectory beside it, as the paper does.

    Parameters
    ----------
    image : mapping of str to ndarray
        From :func:`camid.paper.fig1_marker_image.runs.fast_marker_image`.

    Returns
    -------
    figure : matplotlib.figure.Figure
    table : DataFrame
        ``x``, ``y`` of the trajectory and the grey level of the pixel there.
    """
    style.apply()
    quantised, trajectory = image["quantised"], image["trajectory"]
    import matplotlib.pyplot as plt

    height, width = quantised.shape[:2]
    grey = quantised[:, :, 0]
    figure, (left, right) = plt.subplots(1, 2, figsize=(style.PAGE_WIDTH, 2.75), sharex=True, sharey=True)
    shown = left.imshow(grey, cmap="gray", vmin=0, vmax=int(grey.max()), interpolation="nearest")
    left.set(title="image over one exposure", xlabel="x (px)", ylabel="y (px)")
    left.grid(visible=False)
    bar = figure.colorbar(shown, ax=left, shrink=0.82, pad=0.02)
    style.separate_panels(figure)
    bar.set_label("grey level (of 255)")
    bar.outline.set_linewidth(0.6)
    right.plot(trajectory[:, 0], trajectory[:, 1], color=style.BLUE)
    right.plot(*trajectory[0], "o", color=style.BLUE, markerfacecolor="white", label="exposure begins")
    right.plot(*trajectory[-1], "s", color=style.BLUE, label="exposure ends")
    right.set(title="trajectory of the marker's centre", xlabel="x (px)", aspect="equal")
    right.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))
    right.tick_params(labelleft=False)
    right.legend(loc="lower right")
    columns, rows = np.rint(trajectory).astype(int).T
    table = pd.DataFrame({"x": trajectory[:, 0], "y": trajectory[:, 1], "grey_level": grey[rows, columns]})
    return figure, table
