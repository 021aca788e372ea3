"""Image formation by exposure (paper section 2.1).

The intensity of a pixel is the mean over the exposure of the area of that pixel covered by a bright disk, times the
intensity of the disk, plus the background. Pixel centres lie at integer coordinates, x to the right and y down, so the
pixel (row j, column i) is the square [i − ½, i + ½] × [j − ½, j + ½].
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.compiled import njit

Array = NDArray[np.float64]
Path = Callable[[Array], Array]

# Bound on a pixel's error, as a share of the marker's intensity, that the number of instants is chosen for.
QUADRATURE_ERROR = 1e-3
# Fewest and most pieces of the exposure on which the path is looked at; a prime, as few vibrations alias with it.
FIRST_PIECES, MOST_PIECES = 61, 61 * 2**10
# Least density of instants relative to its mean, so that a turning point, where the speed is zero, stays resolved.
DENSITY_FLOOR = 0.25
BIT_DEPTHS = (None, *range(1, 17))


@dataclass(frozen=True)
class Marker:
    """Circular marker that emits constant light (paper section 2.1).

    Attributes
    ----------
    diameter : float
        Diameter of the disk in px, above zero (ValueError otherwise).
    intensity : float or tuple of three floats
        Grey levels that a pixel gains if always covered, three for a colour camera; below zero for a dark marker.
    """

    diameter: float = 30.0
    intensity: float | tuple[float, float, float] = 255.0

    def __post_init__(self) -> None:
        """Refuse a marker that is not a disk, or an intensity that is not a colour."""
        lit = np.shape(self.intensity) in ((), (3,)) and np.all(np.isfinite(self.intensity))
        if not (0.0 < self.diameter < np.inf and lit):
            raise ValueError(f"{self}: the diameter must be positive, the intensity one or three finite numbers")


@dataclass(frozen=True)
class FrameFormat:
    """Size and depth of the camera's images (paper section 2.1: 300 × 420 px).

    Attributes
    ----------
    height, width : int
        Number of rows and of columns, 1 or more (ValueError otherwise).
    background : float
        Grey level of a pixel that the marker never covers.
    bit_depth : int or None
        Bits of a pixel for `quantise`, 1 to 16 (ValueError otherwise); None for images that stay floating point.
    """

    height: int = 300
    width: int = 420
    background: float = 0.0
    bit_depth: int | None = 8

    def __post_init__(self) -> None:
        """Refuse a frame that no camera has."""
        if self.height < 1 or self.width < 1 or self.bit_depth not in BIT_DEPTHS:
            raise ValueError(f"{self}: the sizes must be 1 px or more, the bit depth 1 to 16 or None")


def circular_path(centre: tuple[float, float], diameter: float, frequency: float, phase: float = 0.0) -> Path:
    """Path on a circle at constant speed (paper figures 1 to 3: 160 px, 24 Hz and 5 Hz).

    Parameters
    ----------
    centre, diameter : tuple of two floats, float
        x and y of the circle's centre, and its diameter, in px.
    frequency, phase : float
        Hz, positive from x to y (clockwise on the screen), and angle from the x axis at time 0, in rad.

    Returns
    -------
    callable from times in s, shape (n,), to positions x, y in px, shape (n, 2)
    """

    def path(time: Array) -> Array:
        angle = 2.0 * np.pi * frequency * np.asarray(time) + phase
        return np.asarray(centre) + 0.5 * diameter * np.stack((np.cos(angle), np.sin(angle)), axis=-1)

    return path


def expose(path: Path, start: float, exposure: float, marker: Marker, frame: FrameFormat) -> Array:
    """Form one image by exposure, before quantisation (paper section 2.1).

    Parameters
    ----------
    path : callable
        Times in s, shape (n,), to the position of the marker's centre, shape (n, 2), x and y in px. A movement shorter
        than about 1/100 of the exposure that comes back to where it began can be overlooked.
    start, exposure : float
        Time at which the exposure begins and its duration, in s.
    marker, frame : Marker, FrameFormat
        The disk, and the size and background of the image; the bit depth is left to `quantise`.

    Returns
    -------
    ndarray of float64, shape (height, width), or (height, width, 3) for a marker with three colour components
        Grey levels, not rounded, each component formed independently; in error by less than 1e-3 of the intensity.

    Raises
    ------
    ValueError
        If the exposure is not positive, or the path gives another shape or a value that is not finite.
    """
    if not (np.isfinite(start) and 0.0 < exposure < np.inf):
        raise ValueError(f"an exposure of {exposure} s from {start} s; it must be finite and longer than zero")
    instants, weights = _instants(path, start, exposure)
    # From here on the pixel i is the interval [i, i + 1], which makes the pixel of an abscissa its floor.
    x, y = _positions(path, instants).T + 0.5
    radius = 0.5 * marker.diameter
    left, right = max(int(x.min() - radius), 0), min(int(x.max() + radius) + 1, frame.width)
    top, bottom = max(int(y.min() - radius), 0), min(int(y.max() + radius) + 1, frame.height)
    image = np.full((frame.height, frame.width, *np.shape(marker.intensity)), frame.background, dtype=float)
    if left < right and top < bottom:
        difference = np.zeros((bottom - top, right - left + 1))
        _accumulate(difference, x - left, y - top, weights, radius)
        # Rounding leaves some −1e-17 where the disk never was.
        coverage = np.maximum(np.cumsum(difference, axis=1)[:, :-1], 0.0)
        image[top:bottom, left:right] += np.multiply.outer(coverage, np.asarray(marker.intensity))
    return image


def quantise(
    image: Array, bit_depth: int | None = 8, noise_std: float = 0.0, generator: np.random.Generator | None = None
) -> NDArray[np.uint8 | np.uint16 | np.float64]:
    """Add pixel noise, round to whole grey levels and clip to the sensor's range.

    Parameters
    ----------
    image : ndarray of any shape
        Grey levels; left as it is.
    bit_depth : int or None
        Bits of a pixel, 1 to 16: the range is 0 to ``2**bit_depth - 1``. None neither rounds nor clips.
    noise_std, generator : float, numpy.random.Generator
        Standard deviation in grey levels of white Gaussian noise, independent from pixel to pixel, and its source,
        needed when there is noise, so that every image can be drawn again.

    Returns
    -------
    ndarray in the shape of the image; uint8 up to 8 bits, uint16 above, float64 without a bit depth

    Raises
    ------
    ValueError
        If the bit depth is outside 1 to 16, or there is noise that is negative or without a generator.
    """
    if bit_depth not in BIT_DEPTHS or not noise_std >= 0.0 or (noise_std > 0.0 and generator is None):
        raise ValueError(f"{bit_depth = } must be 1 to 16 or None, {noise_std = } 0 or positive with a Generator")
    levels = np.array(image, dtype=float)
    if generator is not None and noise_std > 0.0:
        levels += noise_std * generator.standard_normal(levels.shape)
    if bit_depth is None:
        return levels
    np.clip(np.rint(levels, out=levels), 0.0, 2.0**bit_depth - 1.0, out=levels)
    return levels.astype(np.uint8 if bit_depth <= 8 else np.uint16)


def _positions(path: Path, time: Array) -> Array:
    positions = np.asarray(path(time), dtype=float)
    if positions.shape != (time.size, 2) or not np.all(np.isfinite(positions)):
        raise ValueError(
            f"the path gives shape {positions.shape} for {time.size} times; it must give finite x, y for each"
        )
    return positions


def _instants(path: Path, start: float, exposure: float) -> tuple[Array, Array]:
    """Instants of the midpoint rule and their weights, which sum to one.

    An edge that sweeps over a pixel at speed v makes the slope of the covered area jump by at most v; leading and
    trailing edge make four jumps, each of which costs the midpoint rule with step τ at most vτ²/8. For an error ε
    after n passes over the pixel in the exposure T, that asks for a density of √(n v / (2εT)) instants.
    """
    pieces, length, coarse_length = FIRST_PIECES, 1.0, 0.0
    while length > 1.02 * coarse_length + 1e-6 and pieces < MOST_PIECES:
        pieces *= 2
        edges = start + exposure * np.linspace(0.0, 1.0, pieces + 1)
        positions = _positions(path, edges)
        steps = np.hypot(*np.diff(positions, axis=0).T)
        length, coarse_length = steps.sum(), np.hypot(*np.diff(positions[::2], axis=0).T).sum()
    if length == 0.0:
        return edges[:1], np.ones(1)
    passes = max(1.0, length / float(np.hypot(*np.ptp(positions, axis=0))))
    density = np.sqrt(steps) + DENSITY_FLOOR * np.sqrt(steps).mean()
    cumulated = np.concatenate(([0.0], np.cumsum(density)))
    count = int(np.ceil(cumulated[-1] * np.sqrt(passes / (2.0 * QUADRATURE_ERROR * steps.size))))
    borders = np.interp(np.linspace(0.0, cumulated[-1], count + 1), cumulated, edges)
    return 0.5 * (borders[1:] + borders[:-1]), np.diff(borders) / exposure


@njit(nogil=True)
def _accumulate(difference: Array, x: Array, y: Array, weights: Array, radius: float) -> None:
    """Add the exact covered areas to an image of differences along the rows."""
    for k in range(x.size):
        bottom = min(difference.shape[0], int(np.floor(y[k] + radius)) + 1)
        for j in range(max(0, int(y[k] - radius)), bottom):
            # Cut at the horizontal diameter: above and below it both edges of the disk are monotonic.
            low, high = max(j - y[k], -radius), min(j + 1 - y[k], radius)
            if low < 0.0:
                _add_strip(difference[j], x[k], max(-high, 0.0), -low, radius, weights[k])
            if high > 0.0:
                _add_strip(difference[j], x[k], max(low, 0.0), high, radius, weights[k])


@njit(nogil=True)
def _add_strip(row: Array, centre: float, near: float, far: float, radius: float, weight: float) -> None:
    """Add the part of the disk whose distance from its horizontal diameter is between ``near`` and ``far``."""
    wide, narrow = np.sqrt(radius**2 - near**2), np.sqrt(max(radius**2 - far**2, 0.0))
    inverse = 0.25 / radius**2  # the loop below is short of time for divisions
    for side in (-1.0, 1.0):
        # Walk along the arc towards the centre: add what lies right of the left edge, take off right of the right one.
        x, y, end = centre + side * wide, near, centre + side * narrow
        column = int(np.floor(x))
        while True:
            border = float(column + 1) if side < 0.0 else float(column)
            last = side * (border - end) <= 0.0
            next_x = end if last else border
            next_y = far if last else min(np.sqrt(max(radius**2 - (border - centre) ** 2, 0.0)), far)
            height = next_y - y
            # Segment between chord and arc, r²(asin s − s√(1 − s²)) with s = chord / diameter, or its faster series.
            square = ((next_x - x) ** 2 + height**2) * inverse
            sine = np.sqrt(square)
            if square < 0.01:
                segment = sine * square * (2 / 3 + square * (0.2 + square * (3 / 28 + square * (5 / 72))))
            else:
                segment = np.arcsin(sine) - sine * np.sqrt(1.0 - square)
            beyond = height * (0.5 * (x + next_x) - column) + side * segment * radius**2
            if column < 0:
                row[0] -= side * weight * height
            elif column < row.size - 1:
                row[column] -= side * weight * (height - beyond)
                row[column + 1] -= side * weight * beyond
            if last:
                break
            x, y, column = next_x, next_y, column - int(side)
