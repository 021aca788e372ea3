"""What the ablations of the assumptions A1 to A4 share: paths, rendered images and how a measurement is judged."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.images.centroids import RegionOfInterest
from camid.images.forming import Marker, expose
from camid.paper.marker_images import configured_path, frame_format

Array = NDArray[np.float64]
Path = Callable[[Array], Array]

# Fractional parts of its multiples fill the interval evenly at every count and hit no grid of pixels again and again.
GOLDEN_RATIO = 0.5 * (np.sqrt(5.0) - 1.0)


def even_fractions(count: int) -> Array:
    """Numbers in [0, 1), evenly spread and in no simple ratio to each other, shape (count,)."""
    return (GOLDEN_RATIO * np.arange(count)) % 1.0


def circles(imaging: Mapping[str, Any], frequency: float, count: int) -> list[Path]:
    """The configured circle run through at a frequency in Hz, from ``count`` starting angles."""
    return [
        configured_path({**imaging, "path_phase": 2.0 * np.pi * float(turn)}, frequency)
        for turn in even_fractions(count)
    ]


def grey_levels(imaging: Mapping[str, Any], path: Path, diameter: float) -> NDArray[np.float32]:
    """Image of one exposure from time 0, not rounded, of a marker of full intensity; shape (height, width)."""
    marker = Marker(diameter, float(np.mean(imaging["marker_intensity"])))
    return expose(path, 0.0, imaging["exposure"], marker, frame_format(imaging)).astype(np.float32)


def swept_region(path: Path, exposure: float, diameter: float, margin: float) -> RegionOfInterest:
    """Region of interest that holds what the marker covers in an exposure from time 0, and a margin in px around it."""
    positions = path(np.linspace(0.0, exposure, 1001))
    (left, top), (right, bottom) = positions.min(axis=0), positions.max(axis=0)
    reach = 0.5 * diameter + margin
    first_row, first_column = round(top - reach), round(left - reach)
    return RegionOfInterest(
        first_row, first_column, round(bottom + reach) - first_row + 1, round(right + reach) - first_column + 1
    )


def outward(imaging: Mapping[str, Any], position: Array) -> Array:
    """Unit vector from the centre of the configured circle towards a position, shape (2,)."""
    direction = position - np.asarray(imaging["path_centre"], dtype=float)
    return direction / np.linalg.norm(direction)


def root_mean_square(errors: Array) -> float:
    """Root of the mean squared length of error vectors, shape (n, 2)."""
    return float(np.sqrt(np.mean(np.sum(np.asarray(errors) ** 2, axis=-1))))
