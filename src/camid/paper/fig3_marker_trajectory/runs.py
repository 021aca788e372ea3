"""Fig. 3: the slow circle as image processing and the simplified model see it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.images.centroids import gradient_centroid, grey_level_centroid
from camid.images.forming import expose, quantise
from camid.paper.marker_images import configured_path, frame_format, marker, time_mean

Array = NDArray[np.float64]


def slow_marker_trajectory(imaging: Mapping[str, Any]) -> pd.DataFrame:
    """Fig. 3: image-processing measurements of the slow circle beside the simplified model.

    Returns
    -------
    DataFrame
        One row per frame: ``k``, ``time`` (s, end of the exposure), ``measured_x``, ``measured_y`` (gradient centroid),
        ``half_threshold_x``, ``half_threshold_y`` (the same with a threshold of 0.5), ``grey_level_x``,
        ``grey_level_y``, ``model_x``, ``model_y`` (equations (4), (5)); px; and
        ``signal_to_noise`` of the whole (dB).
    """
    path = configured_path(imaging, imaging["slow_frequency"])
    rows = []
    for k in range(imaging["slow_frames"]):
        start = k * imaging["period"] + imaging["period"] - imaging["exposure"]
        image = quantise(expose(path, start, imaging["exposure"], marker(imaging), frame_format(imaging)))
        measured = gradient_centroid(image, imaging["threshold"])
        other = gradient_centroid(image, 0.5)
        grey = grey_level_centroid(image, background=0.0)
        model = time_mean(path, start, imaging["exposure"])
        rows.append(
            {
                "k": k,
                "time": (k + 1) * imaging["period"],
                "measured_x": measured[0],
                "measured_y": measured[1],
                "half_threshold_x": other[0],
                "half_threshold_y": other[1],
                "grey_level_x": grey[0],
                "grey_level_y": grey[1],
                "model_x": model[0],
                "model_y": model[1],
            }
        )
    table = pd.DataFrame(rows)
    return table.assign(signal_to_noise=signal_to_noise_decibels(table))


def signal_to_noise_decibels(trajectory: pd.DataFrame, measured: str = "measured") -> float:
    """Power of the model's motion about its mean over that of the measurement error, both coordinates, in dB."""
    model = trajectory[["model_x", "model_y"]].to_numpy()
    error = trajectory[[f"{measured}_x", f"{measured}_y"]].to_numpy() - model
    return float(10.0 * np.log10(np.sum((model - model.mean(axis=0)) ** 2) / np.sum(error**2)))
