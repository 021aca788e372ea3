"""Position of a marker in a frame: frames per second and error, against a plain OpenCV pipeline."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from benchmarks.report import Goal, Report, number
from benchmarks.task import MEASUREMENT, configuration, generator
from benchmarks.timing import alternate
from camid.images.centroids import RegionOfInterest, gradient_centroid, grey_level_centroid
from camid.images.forming import FrameFormat, Marker, expose, quantise

Image = NDArray[np.uint8]
Measure = Callable[[Image, RegionOfInterest | None], tuple[float, float]]

REGION = 64  # px
NOISE = 2.0  # grey levels
# Grey levels above the background below which a pixel counts as noise: five standard deviations, as marker.py advises.
NOISE_THRESHOLD = 5.0 * NOISE
POSITIONS = 200  # of the disk, redrawn with sub-pixel coordinates
ROUNDS = 300
LARGEST_ERROR = 0.02  # px
PLAIN = "OpenCV Sobel, threshold, moments"


def view(image: Image, region: RegionOfInterest | None) -> tuple[Image, int, int]:
    """The region's pixels, its left and its top."""
    if region is None:
        return image, 0, 0
    rows, columns = slice(region.top, region.top + region.height), slice(region.left, region.left + region.width)
    return image[rows, columns], region.left, region.top


def plain_opencv(image: Image, threshold: float, region: RegionOfInterest | None) -> tuple[float, float]:
    """Sobel, magnitude, relative threshold and moments, as one writes them with OpenCV."""
    pixels, left, top = view(image, region)
    horizontal = cv2.Sobel(pixels, cv2.CV_32F, 1, 0)
    vertical = cv2.Sobel(pixels, cv2.CV_32F, 0, 1)
    gradient = cv2.magnitude(horizontal, vertical)
    _, mask = cv2.threshold(gradient, threshold * cv2.minMaxLoc(gradient)[1], 1.0, cv2.THRESH_BINARY)
    moments = cv2.moments(mask)
    return left + moments["m10"] / moments["m00"], top + moments["m01"] / moments["m00"]


def plain_moments(image: Image, region: RegionOfInterest | None) -> tuple[float, float]:
    """Threshold to zero and moments, as one writes them with OpenCV."""
    pixels, left, top = view(image, region)
    _, kept = cv2.threshold(pixels, NOISE_THRESHOLD, 0.0, cv2.THRESH_TOZERO)
    moments = cv2.moments(kept)
    return left + moments["m10"] / moments["m00"], top + moments["m01"] / moments["m00"]


def tools() -> dict[str, Measure]:
    """What is compared, by name."""
    threshold = float(configuration()["imaging"]["threshold"])
    return {
        "camid gradient_centroid": lambda image, region: gradient_centroid(image, threshold, region),
        PLAIN: lambda image, region: plain_opencv(image, threshold, region),
        "camid grey_level_centroid": lambda image, region: grey_level_centroid(image, region=region),
        f"camid grey_level_centroid, threshold {NOISE_THRESHOLD:g}": lambda image, region: grey_level_centroid(
            image, threshold=NOISE_THRESHOLD, region=region
        ),
        f"OpenCV threshold {NOISE_THRESHOLD:g}, moments": plain_moments,
    }


def noisy_frames(count: int) -> tuple[list[Image], np.ndarray]:
    """Frames of a static disk somewhere near the middle, and its true positions x, y in px, shape (count, 2)."""
    imaging = configuration()["imaging"]
    frame = FrameFormat(imaging["height"], imaging["width"])
    marker = Marker(imaging["marker_diameter"], float(imaging["marker_intensity"][0]))
    noise = generator(MEASUREMENT)
    positions = np.array(imaging["path_centre"]) + noise.uniform(-5.0, 5.0, (count, 2))
    images = []
    for position in positions:
        still = expose(lambda time, p=position: np.tile(p, (len(time), 1)), 0.0, imaging["exposure"], marker, frame)
        images.append(quantise(still, 8, NOISE, noise))
    return images, positions


def run(positions: int = POSITIONS, rounds: int = ROUNDS) -> Report:
    """Measure the same frames with every tool, in the whole frame and in a region around the marker."""
    images, truth = noisy_frames(positions)
    imaging = configuration()["imaging"]
    around = RegionOfInterest.around((imaging["path_centre"][0], imaging["path_centre"][1]), REGION)
    areas = {f"{imaging['height']} × {imaging['width']}": None, f"{REGION} × {REGION}": around}
    rows = []
    for area, region in areas.items():
        calls = {
            name: (lambda k, measure=measure, region=region: measure(images[k % positions], region))
            for name, measure in tools().items()
        }
        times = alternate(calls, rounds)
        for name, measure in tools().items():
            errors = np.array([measure(image, region) for image in images]) - truth
            rows.append(
                {
                    "area": area,
                    "tool": name,
                    "frames_per_second": 1.0 / times[name],
                    "rms_error": float(np.sqrt(np.mean(np.sum(errors**2, axis=1)))),
                    "mean_error_x": float(errors[:, 0].mean()),
                    "mean_error_y": float(errors[:, 1].mean()),
                }
            )
    table = pd.DataFrame(rows)
    shown = pd.DataFrame(
        {
            "area in px": table["area"],
            "tool": table["tool"],
            "frames/s": [number(f) for f in table["frames_per_second"]],
            "RMS error in px": [number(e, 2) for e in table["rms_error"]],
        }
    )
    return Report(
        "measurement",
        "Position of a marker in a frame",
        f"A motionless disk of {imaging['marker_diameter']:g} px at {positions} sub-pixel positions in 8-bit frames "
        f"with pixel noise of {NOISE:g} grey levels, clipped at black and white; the tools take turns on the same "
        f"frames, median over {rounds} frames. RMS error: of the distance from the true position. Gradient threshold: "
        f"{imaging['threshold']:g} of the largest gradient, in all tools.",
        table,
        shown,
        [goal for area in areas.values() for goal in goals(table, areas, area)],
    )


def goals(table: pd.DataFrame, areas: dict, region: RegionOfInterest | None) -> list[Goal]:
    """The goals in one area."""
    area = next(name for name, value in areas.items() if value is region)
    part = table[table["area"] == area].set_index("tool")
    own, plain = part.loc["camid gradient_centroid"], part.loc[PLAIN]
    result = [
        Goal(
            f"gradient centroid as fast as the plain OpenCV pipeline or faster, {area} px (ratio of the times)",
            plain["frames_per_second"] / own["frames_per_second"],
            1.0,
        ),
        Goal(
            f"gradient centroid no worse than the plain OpenCV pipeline, {area} px (ratio of the RMS errors)",
            round(own["rms_error"] / plain["rms_error"], 6),
            1.0,
        ),
    ]
    grey = part[part.index.str.startswith("camid grey_level")]
    return result + [
        Goal(f"{name}: RMS error of {LARGEST_ERROR:g} px or less, {area} px", error, LARGEST_ERROR)
        for name, error in grey["rms_error"].items()
    ]
