"""Position of the marker in a region that holds it, by both centroids, with standard deviation and quality."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.images.centroids import (
    CLEARANCE,
    NORMAL_DEVIATION_RANK,
    MarkerNotFound,
    RegionOfInterest,
    gradient_centroid,
    grey_level_centroid,
)
from camid.tracking.find import GAP
from camid.tracking.noise import SOBEL_NOISE, filtered, gradient_deviation, grey_level_deviation, noise_inside, noise_of
from camid.tracking.picture import Image

METHODS = ("grey-level", "gradient")
# Grey levels below this share of the marker's contrast are the ringing of codecs and soft shadows.
LEAST_SHARE = 0.05
# Of the largest gradient; more where the noise would pass it.
GRADIENT_THRESHOLD = 0.2
LARGEST_GRADIENT_THRESHOLD = 0.9
# Another thing in the region with more than this share of its grey levels is taken out before measuring.
STRANGER = 0.005


@dataclass(frozen=True)
class Measurement:
    """Marker in one frame, in the grid of the appearance.

    Attributes
    ----------
    gradient, grey_level : (float, float)
        Both centroids: column and row in the whole image.
    deviation : (float, float)
        Standard deviation of the centroid that was asked for.
    box : RegionOfInterest
        Smallest region with the whole marker, at least 3 × 3.
    mass : float
        Sum of the marker's grey levels above the background.
    contrast : float
        Share of the marker's contrast that is above the threshold: 0 is lost in noise, 1 is free of it.
    alone : float
        Share of the grey levels in the region that are the marker's.
    touches : tuple of bool
        Whether the marker reaches the region's left, top, right, bottom border.
    noise : float
        Standard deviation of a pixel, grey levels.
    """

    gradient: tuple[float, float]
    grey_level: tuple[float, float]
    deviation: tuple[float, float]
    box: RegionOfInterest
    mass: float
    contrast: float
    alone: float
    touches: tuple[bool, bool, bool, bool]
    noise: float


def measure(image: Image, region: RegionOfInterest, method: str = METHODS[0]) -> Measurement:
    """Measure the marker in the image of a region.

    Parameters
    ----------
    image : ndarray, shape (height, width)
        The region's image, marker bright.
    region : RegionOfInterest
        Where it lies in the whole image.
    method : {"grey-level", "gradient"}
        Whose standard deviation is required.

    Raises
    ------
    MarkerNotFound
        If nothing stands out.
    """
    import cv2

    background, deviation, border = _border(image)
    answer = filtered(image)
    outside = noise_of(answer[::2, ::2])
    spread = max(deviation + (0.5 if deviation > 0.0 and image.dtype.kind == "u" else 0.0), outside)
    peak = float(cv2.blur(image, (3, 3)).max()) - background
    threshold = max(CLEARANCE * spread, LEAST_SHARE * peak)
    if peak <= threshold:
        raise MarkerNotFound(f"nothing in the region stands out by more than {threshold:.3g} grey levels")
    mask: NDArray[np.uint8] = (image > np.float32(background + threshold)).view(np.uint8)
    mask, box, alone, strangers = _main_thing(mask, image, background)
    if strangers is not None:
        image = np.where(strangers, np.asarray(background, image.dtype), image)
    x, y = grey_level_centroid(image, background, threshold)
    relative = min(LARGEST_GRADIENT_THRESHOLD, max(GRADIENT_THRESHOLD, 2.0 * CLEARANCE * SOBEL_NOISE * outside / peak))
    gradient = gradient_centroid(image, relative)
    inner, inside = noise_inside(answer, mask)
    noise = outside if inside is None else inside
    level = image.astype(np.float32) - np.float32(background)
    mass = float(cv2.sumElems(cv2.multiply(level, mask, dtype=cv2.CV_32F))[0])
    if method == "gradient":
        std = gradient_deviation(image, relative, gradient, max(noise, outside))
    else:
        std = grey_level_deviation(level, mask, inner, (x, y), threshold, (noise, outside), border)
    left, top, width, height = box
    rows, columns = image.shape
    return Measurement(
        (region.left + gradient[0], region.top + gradient[1]),
        (region.left + x, region.top + y),
        std,
        RegionOfInterest(region.top + top, region.left + left, max(height, 3), max(width, 3)),
        mass,
        max(0.0, 1.0 - CLEARANCE * spread / peak),
        alone,
        (left == 0, top == 0, left + width == columns, top + height == rows),
        max(noise, outside),
    )


def _border(image: Image) -> tuple[float, float, int]:
    """Median, spread above it and number of the pixels at the border, as `grey_level_centroid` takes them."""
    border = np.sort(np.concatenate((image[0], image[-1], image[1:-1, 0], image[1:-1, -1])))
    middle = 0.5 * (float(border[(border.size - 1) // 2]) + float(border[border.size // 2]))
    return middle, float(border[int(NORMAL_DEVIATION_RANK * border.size)]) - middle, border.size


def _main_thing(
    mask: NDArray[np.uint8], image: Image, background: float
) -> tuple[NDArray[np.uint8], tuple[int, int, int, int], float, NDArray[np.bool_] | None]:
    """Mask and box (left, top, width, height) of the largest thing, its share of the grey levels, and the others."""
    import cv2

    joined = cv2.dilate(mask, np.ones((GAP + 1, GAP + 1), np.uint8))
    count, labels = cv2.connectedComponents(joined)
    alone, strangers = 1.0, None
    if count > 2:
        weights = np.where(mask > 0, image.astype(np.float32) - np.float32(background), np.float32(0.0))
        masses = np.bincount(labels.ravel(), weights.ravel(), count)[1:]
        main = 1 + int(np.argmax(masses))
        alone = float(masses[main - 1] / masses.sum())
        own = labels == main
        mask = mask * own.astype(np.uint8)
        if 1.0 - alone > STRANGER:
            strangers = (labels > 0) & ~own
    left, top, width, height = cv2.boundingRect(mask)
    return mask, (left, top, width, height), alone, strangers
