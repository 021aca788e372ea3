"""What happens when an assumption of section 2.2 fails."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.images.centroids import gradient_centroid
from camid.images.forming import Marker, expose
from camid.paper.marker_images import Path, arc_length_mean, configured_path, frame_format, marker, time_mean

Array = NDArray[np.float64]

# Where the assumptions are made to fail: diameters in px, thresholds as shares of the largest gradient, turns in an
# exposure, a distance in px.
A1_DIAMETERS = (8.0, 15.0, 30.0, 45.0)
A1_THRESHOLDS = (0.05, 0.2, 0.5)
A2_DIAMETER = 8.0
A2_TURNS = (0.5, 0.75, 1.25, 1.5)
A4_DISTANCE = 60.0


def assumption_failures(imaging: Mapping[str, Any]) -> pd.DataFrame:
    """What the gradient centroid does when A1, A2 or A4 fails, each against the formula that the assumption leads to.

    The images stay floating point here: a dim, fast marker has few grey levels, and rounding is assumption A3.

    Returns
    -------
    DataFrame
        Columns ``assumption``, ``quantity``, ``setting`` (marker diameter in px, turns an exposure, …), ``threshold``
        and ``value`` (px).
    """
    exposure, fast = imaging["exposure"], imaging["fast_frequency"]
    rows = [
        ("A1", "outward shift from (1)", diameter, threshold, _outward_shift(imaging, fast, diameter, threshold))
        for threshold in A1_THRESHOLDS
        for diameter in A1_DIAMETERS
    ]
    for turns in A2_TURNS:
        path = configured_path(imaging, turns / exposure)
        measured = gradient_centroid(_grey_image(imaging, path, A2_DIAMETER), imaging["threshold"])
        distance = float(np.linalg.norm(np.array(measured) - arc_length_mean(path, 0.0, exposure)))
        rows.append(("A2", "distance from (1)", turns, imaging["threshold"], distance))
    centre = np.array(imaging["path_centre"])

    def accelerated(time: Array) -> Array:
        share = np.asarray(time) / exposure
        return centre + np.stack([A4_DISTANCE * share**2, np.zeros_like(share)], axis=-1)

    for name, path in (("constant speed", configured_path(imaging, fast)), ("from rest", accelerated)):
        difference = arc_length_mean(path, 0.0, exposure) - time_mean(path, 0.0, exposure)
        rows.append(("A4", f"distance of (2) from the time mean, {name}", fast, 0.0, float(np.linalg.norm(difference))))
    path = configured_path(imaging, fast)
    colour = expose(path, 0.0, exposure, marker(imaging), frame_format(imaging))[:, :, 0]
    grey = expose(
        path,
        0.0,
        exposure,
        Marker(imaging["marker_diameter"], float(imaging["marker_intensity"][0])),
        frame_format(imaging),
    )
    rows.append(("colour", "largest difference from a grey camera", fast, 0.0, float(np.max(np.abs(colour - grey)))))
    return pd.DataFrame(rows, columns=["assumption", "quantity", "setting", "threshold", "value"])


def _grey_image(imaging: Mapping[str, Any], path: Path, diameter: float) -> NDArray[np.float32]:
    image = expose(path, 0.0, imaging["exposure"], Marker(diameter), frame_format(imaging))
    return image.astype(np.float32)


def _outward_shift(imaging: Mapping[str, Any], frequency: float, diameter: float, threshold: float) -> float:
    """Displacement of the gradient centroid from (1) away from the circle's centre, mean over four starting angles."""
    centre = np.array(imaging["path_centre"])
    shifts = []
    for turn in np.arange(4) / 4.0:
        path = configured_path({**imaging, "path_phase": 2.0 * np.pi * turn}, frequency)
        expected = arc_length_mean(path, 0.0, imaging["exposure"])
        outward = (expected - centre) / np.linalg.norm(expected - centre)
        measured = np.array(gradient_centroid(_grey_image(imaging, path, diameter), threshold))
        shifts.append(float((measured - expected) @ outward))
    return float(np.mean(shifts))
