"""Recordings measured in images: a marker that moves during the exposure, pixel noise, and its grey-level centroid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.images.centroids import grey_level_centroid
from camid.images.forming import FrameFormat, Marker, expose, quantise
from camid.proof.concealed.camera_readings import position_at
from camid.proof.concealed.machine_integrator import Trajectory
from camid.proof.concealed.rig_setup import Setup

Array = NDArray[np.float64]

STROKE = 16.0  # px from rest to the largest excursion
DIAMETER = 7.0  # px
MARGIN = 3  # px around the marker at its largest excursion
# Share of the sensor's range for the background, so that noise is not cut off at black, and for the marker.
BACKGROUND, INTENSITY = 0.2, 0.6


def image_readings(
    setup: Setup, trajectory: Trajectory, largest: float, noise_std: float, generator: np.random.Generator
) -> Array:
    """Frame values measured in rendered images.

    Parameters
    ----------
    setup : Setup
        Of a camera with an exposure above zero.
    trajectory : Trajectory
    largest : float
        Excursion in the output's units that is `STROKE` pixels in the image.
    noise_std : float
        Wanted standard deviation of the readings in the output's units; the pixels' noise is chosen for it.
    generator : numpy.random.Generator
        Draws the pixels' noise.

    Returns
    -------
    ndarray, shape (N,)
        In the output's units.
    """
    pixels = STROKE / largest
    reach = float(np.max(np.abs(trajectory.position))) * setup.rig.output_scale * pixels
    half = int(np.ceil(reach + 0.5 * DIAMETER)) + MARGIN
    height, width = 2 * (int(np.ceil(0.5 * DIAMETER)) + MARGIN) + 1, 2 * half + 1
    # Noise of a centre of mass: of the sum of (column - centre) times the noise of every pixel, over the disk's mass.
    lever = np.sqrt(height * width * ((width**2 - 1) / 12.0 + float(np.mean(_squared(setup, trajectory, pixels)))))
    relative = noise_std * pixels * np.pi * DIAMETER**2 / 4.0 / lever
    bits = 8 if relative * INTENSITY * 255.0 > 1.0 else 14
    full = 2.0**bits - 1.0
    marker = Marker(DIAMETER, INTENSITY * full)
    frame = FrameFormat(height, width, BACKGROUND * full, bits)
    middle_row = float(height // 2)

    def path(time: Array) -> Array:
        column = half + pixels * position_at(setup, trajectory, time)
        return np.stack((column, np.full_like(column, middle_row)), axis=-1)

    result = np.empty(setup.frames)
    for k in range(setup.frames):
        start = k * setup.period - setup.latency - setup.exposure
        image = expose(path, start, setup.exposure, marker, frame)
        seen = quantise(image, bits, relative * INTENSITY * full, generator)
        column, _ = grey_level_centroid(seen, background=BACKGROUND * full, threshold=0.0)
        result[k] = (column - half) / pixels
    return result


def _squared(setup: Setup, trajectory: Trajectory, pixels: float) -> Array:
    """Squares of the marker's distances from the image's centre in px."""
    return np.asarray((trajectory.position * setup.rig.output_scale * pixels) ** 2)
