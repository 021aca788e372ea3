"""Finding the marker without knowing its position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camid.images.centroids import CLEARANCE
from camid.tracking.appearance import LEAST_CONTRAST
from camid.tracking.noise import pixel_noise
from camid.tracking.picture import Image

# What belongs to the marker is brighter than this share of the brightest.
SHARE_OF_PEAK = 0.5
# Pieces closer than this many pixels are one thing.
GAP = 4
# A thing this large a share of the image is a change of the light, not a marker.
LARGEST_SHARE = 0.25
# Another thing with this share of the strongest one's grey levels may equally be the marker.
EQUALLY_LIKELY = 0.5


@dataclass(frozen=True)
class MarkerCandidate:
    """Something that stands out, in the grid of the image.

    Attributes
    ----------
    x, y : float
        Centre.
    left, top, width, height : int
        Box around it.
    mass : float
        Sum of its grey levels above the background.
    at_border : bool
        Whether it touches the border of what was searched.
    """

    x: float
    y: float
    left: int
    top: int
    width: int
    height: int
    mass: float
    at_border: bool


def candidates(image: Image, left: int = 0, top: int = 0) -> list[MarkerCandidate]:
    """What stands out from an image, the strongest first.

    Parameters
    ----------
    image : ndarray, shape (height, width)
        Marker bright.
    left, top : int
        Where the image lies in the whole one; the candidates' positions count from there.

    Returns
    -------
    list of MarkerCandidate
        Empty if nothing is brighter than the background by `LEAST_CONTRAST` grey levels and five standard deviations
        of the noise.
    """
    import cv2

    height, width = image.shape
    background = float(np.median(image[:: 1 + height // 200, :: 1 + width // 200]))
    smooth = cv2.blur(image, (3, 3)).astype(np.float32) - np.float32(background)
    peak = float(smooth.max())
    lowest = CLEARANCE * pixel_noise(image[:: 1 + height // 400])
    if peak < max(LEAST_CONTRAST, lowest):
        return []
    bright = (smooth > max(SHARE_OF_PEAK * peak, lowest)).astype(np.uint8)
    joined = cv2.dilate(bright, np.ones((GAP + 1, GAP + 1), np.uint8))
    count, labels, statistics, _ = cv2.connectedComponentsWithStats(joined)
    found = []
    for k in range(1, count):
        x0, y0, w, h = (int(v) for v in statistics[k, :4])
        inside = (labels[y0 : y0 + h, x0 : x0 + w] == k) & (bright[y0 : y0 + h, x0 : x0 + w] > 0)
        rows, columns = np.nonzero(inside)
        weights = smooth[y0 : y0 + h, x0 : x0 + w][rows, columns]
        if len(rows) > LARGEST_SHARE * height * width:
            continue
        found.append(
            MarkerCandidate(
                left + x0 + float(columns @ weights / weights.sum()),
                top + y0 + float(rows @ weights / weights.sum()),
                left + x0 + int(columns.min()),
                top + y0 + int(rows.min()),
                int(np.ptp(columns)) + 1,
                int(np.ptp(rows)) + 1,
                float(weights.sum()),
                x0 == 0 or y0 == 0 or x0 + w == width or y0 + h == height,
            )
        )
    return sorted(found, key=lambda c: -c.mass)
