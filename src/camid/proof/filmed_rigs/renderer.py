"""Pictures of a disc that moves: mean over the exposure, row by row, with the noise of pixels, in 8 bits.

Nothing here imports camid. The time stamp of a frame is the end of the exposure of the row in which the rig rests; with
a rolling shutter rows below it follow later, and those above came earlier.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from .rigs import DECIMALS, PERSPECTIVE, ROLLING_SHUTTER, Rig, Run

Array = NDArray[np.float64]

# Along and across the motion, px.
LENGTH, WIDTH = 420, 160
# Pictures that an exposure is the mean of: with so many the mean is off by less than 3e-4 px where the motion turns.
PARTS = 48
# Px around the disc that are looked at, too.
EDGE = 3.0
BRIGHT, DARK = 205.0, 45.0


def obliqueness(rig: Rig, motion: Run) -> float:
    """Coefficient c of pixel = p / (1 + c p), 1/px; zero where the plane of the motion is not oblique.

    The scale along the motion is 1 / (1 + c p)^2, and it differs by ``rig.size`` between the ends of the motion.
    """
    if rig.concealed != PERSPECTIVE:
        return 0.0
    ratio = np.sqrt(1.0 + rig.size)
    low, high = float(motion.position.min()), float(motion.position.max())
    return float((ratio - 1.0) / (high - ratio * low))


def line_time(rig: Rig) -> float:
    """Seconds from the exposure of a row to that of the next one."""
    return rig.size / (rig.frame_rate * rig.motion) if rig.concealed == ROLLING_SHUTTER else 0.0


def rest(rig: Rig, motion: Run) -> float:
    """Pixel along the motion in which the rig rests."""
    slant = obliqueness(rig, motion)
    ends = [p / (1.0 + slant * p) for p in (float(motion.position.min()), float(motion.position.max()))]
    return 0.5 * (LENGTH - 1) + rig.aside - 0.5 * sum(ends)


def coverage(rig: Rig, motion: Run, stamp: float) -> tuple[Array, int]:
    """Share of each pixel that the disc covers, on average over an exposure.

    Parameters
    ----------
    rig, motion
    stamp : float
        Time stamp of the frame on the clock of the camera, s.

    Returns
    -------
    shares : ndarray, shape (along, WIDTH)
        Of the part of the image in which the disc is.
    begin : int
        Pixel along the motion of the first row of ``shares``.
    """
    slant, line, home = obliqueness(rig, motion), line_time(rig), rest(rig, motion)
    ends = stamp - rig.exposure * (np.arange(PARTS) + 0.5) / PARTS
    # Every row that may be reached is looked at: it has times of its own.
    pixel = np.arange(LENGTH, dtype=float) - home
    centres = motion.at(rig.to_drive(ends + line * pixel[:, None]))
    seen = centres / (1.0 + slant * centres)
    reach = rig.radius * 1.3 + EDGE
    touched = np.flatnonzero(np.any(np.abs(seen - pixel[:, None]) <= reach, axis=1))
    rows = slice(int(touched[0]), int(touched[-1]) + 1)
    across = np.arange(WIDTH, dtype=float) - 0.5 * (WIDTH - 1)
    near = np.flatnonzero(np.abs(across) <= reach)
    # Back from the image to the plane of the motion, where the disc is round.
    along = pixel[rows] / (1.0 - slant * pixel[rows])
    growth = 1.0 + slant * along
    dx = along[:, None, None] - centres[rows][:, None, :]
    dy = across[None, near, None] * growth[:, None, None]
    distance = (np.sqrt(dx**2 + dy**2) - rig.radius) / growth[:, None, None]
    shares = np.zeros((rows.stop - rows.start, WIDTH))
    shares[:, near] = np.clip(0.5 - distance, 0.0, 1.0).mean(axis=-1)
    return shares, rows.start


def pictures(rig: Rig, motion: Run, rng: np.random.Generator) -> Iterator[NDArray[np.uint8]]:
    """Frames in their order, shape (rows, columns)."""
    disc, behind = (BRIGHT, DARK) if rig.bright else (DARK, BRIGHT)
    for stamp in rig.stamps:
        picture = behind + rig.noise * rng.standard_normal((LENGTH, WIDTH))
        shares, begin = coverage(rig, motion, float(stamp))
        picture[begin : begin + len(shares)] += (disc - behind) * shares
        eight_bits = np.clip(np.rint(picture), 0.0, 255.0).astype(np.uint8)
        yield eight_bits if rig.vertical else np.ascontiguousarray(eight_bits.T)


def film(rig: Rig, motion: Run, folder: Path, rng: np.random.Generator) -> None:
    """Write the frames as PNG images, and their time stamps beside them, into a folder that is made."""
    import cv2

    folder.mkdir()
    for number, picture in enumerate(pictures(rig, motion, rng)):
        # Noise does not compress, so little is tried.
        cv2.imwrite(str(folder / f"frame_{number:04d}.png"), picture, [cv2.IMWRITE_PNG_COMPRESSION, 1])
    stamps = pd.DataFrame({"t": np.round(rig.stamps, DECIMALS)})
    stamps.to_csv(folder / "timestamps.csv", index=False)
