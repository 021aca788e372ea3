"""The image of the fast marker and its gradient, which Figs. 1 and 2 show."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.images.centroids import gradient_centroid, gradient_image
from camid.images.forming import expose, quantise
from camid.paper.marker_images import arc_length_mean, configured_path, frame_format, marker, time_mean

Array = NDArray[np.float64]


def fast_marker_image(imaging: Mapping[str, Any]) -> dict[str, Array]:
    """Everything that Figs. 1 and 2 show: image, trajectory, gradient, selected pixels and centres.

    Returns
    -------
    dict of ndarray
        ``image`` (height, width, 3) float grey levels, ``quantised`` (8 bit), ``trajectory`` (M, 2), ``gradient``
        (height, width), ``selected`` (bool), ``centroid``, ``arc_length_mean``, ``time_mean`` (2,) each, in px.
    """
    path = configured_path(imaging, imaging["fast_frequency"])
    exposure = imaging["exposure"]
    image = expose(path, 0.0, exposure, marker(imaging), frame_format(imaging))
    quantised = quantise(image)
    gradient = gradient_image(quantised)
    return {
        "image": image,
        "quantised": quantised,
        "trajectory": path(np.linspace(0.0, exposure, 401)),
        "gradient": np.asarray(gradient),
        "selected": np.asarray(gradient > imaging["threshold"] * gradient.max()),
        "centroid": np.array(gradient_centroid(quantised, imaging["threshold"])),
        "arc_length_mean": arc_length_mean(path, 0.0, exposure),
        "time_mean": time_mean(path, 0.0, exposure),
    }
