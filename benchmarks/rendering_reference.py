"""A slow, very exact image by exposure, independent of `camid.images.forming`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Path = Callable[[Array], Array]

# Disks that are worked on at once: a compromise between calls and memory.
BATCH = 256


def corner_area(x: Array, y: Array) -> Array:
    """Area of the part of the unit disk around 0 that lies left of ``x`` and below ``y`` (coordinates at most y).

    The edge x cuts the disk at ±h = ±√(1 − x²), the edge y at the abscissas ±w = ±√(1 − y²); the integral of the
    height of the disk below y from −1 to x is a sum of circle segments and rectangles in closed form.
    """
    x, y = np.broadcast_arrays(np.clip(x, -1.0, 1.0), np.clip(y, -1.0, 1.0))
    w = np.sqrt(1.0 - y**2)

    def half_disk(t: Array) -> Array:
        """Integral of √(1 − s²) from −1 to t."""
        return 0.5 * (t * np.sqrt(np.maximum(1.0 - t**2, 0.0)) + np.arcsin(t) + 0.5 * np.pi)

    # Between −w and w the disk reaches below y from −√(1 − s²) to y; beyond, wholly where y > 0 and not at all else.
    inner_end = np.clip(x, -w, w)
    inner = half_disk(inner_end) - half_disk(-w) + y * (inner_end + w)
    outer = 2.0 * (half_disk(np.minimum(x, -w)) + np.maximum(half_disk(x) - half_disk(w), 0.0))
    return inner + np.where(y > 0.0, outer, 0.0)


def coverage(x: float | Array, y: float | Array, radius: float, columns: Array, rows: Array) -> Array:
    """Exactly covered share of the pixels at integer coordinates.

    Parameters
    ----------
    x, y : float or ndarray, shape (n,)
        Centres of the disks in px.
    radius : float
        px.
    columns, rows : ndarray, shape (n, w) and (n, h), or (w,) and (h,)
        Coordinates of the pixels, in steps of one.

    Returns
    -------
    ndarray, shape (n, h, w)
    """
    x, y = np.reshape(x, (-1, 1)), np.reshape(y, (-1, 1))
    columns, rows = np.atleast_2d(columns), np.atleast_2d(rows)
    borders_x = (np.concatenate([columns - 0.5, columns[:, -1:] + 0.5], axis=1) - x) / radius
    borders_y = (np.concatenate([rows - 0.5, rows[:, -1:] + 0.5], axis=1) - y) / radius
    corners = corner_area(borders_x[:, None, :], borders_y[:, :, None])
    return radius**2 * np.diff(np.diff(corners, axis=1), axis=2)


def expose_reference(
    path: Path, start: float, exposure: float, radius: float, shape: tuple[int, int], instants: int
) -> Array:
    """Share of full scale of every pixel: the mean of the exact coverage over this many equidistant instants.

    For a path of length L px the error of this midpoint rule is about L / (2 · instants²), a pass.
    """
    height, width = shape
    margin = int(np.ceil(radius)) + 2
    # A frame so wide that no disk that touches the image falls over its border.
    image = np.zeros((height + 4 * margin, width + 4 * margin))
    centres = path(start + exposure * (np.arange(instants) + 0.5) / instants)
    offsets = np.arange(-margin, margin + 1)
    for first in range(0, instants, BATCH):
        x, y = centres[first : first + BATCH].T
        columns = np.floor(x).astype(int)[:, None] + offsets
        rows = np.floor(y).astype(int)[:, None] + offsets
        near = (columns[:, 0] >= -2 * margin) & (columns[:, -1] < width + 2 * margin)
        near &= (rows[:, 0] >= -2 * margin) & (rows[:, -1] < height + 2 * margin)
        covered = coverage(x[near], y[near], radius, columns[near], rows[near])
        np.add.at(
            image, (rows[near][:, :, None] + 2 * margin, columns[near][:, None, :] + 2 * margin), covered / instants
        )
    return image[2 * margin : 2 * margin + height, 2 * margin : 2 * margin + width]
