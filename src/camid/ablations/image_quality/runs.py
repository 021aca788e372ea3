"""Assumption A3: coarse pixels, few bits and noise.

Every setting is tried with the marker on the configured circle and with a marker at rest, at places spread over the
pixel. Errors are in px of the configured camera, so a coarser one is not flattered by its larger pixels. Where there is
noise, the black level lies five standard deviations above 0 and full light as many below full scale, so that nothing is
clipped (what clipping does is in the ablation `centroids`); where there is none, black is 0. The black level is taken
from the median of the region's border, or known.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.ablations.rendered_images import Path, even_fractions, root_mean_square, swept_region
from camid.images.centroids import RegionOfInterest, gradient_centroid, grey_level_centroid
from camid.images.forming import FrameFormat, Marker, circular_path, expose, quantise
from camid.paper.marker_images import time_mean

Array = NDArray[np.float64]
Image = NDArray[Any]

# Standard deviations of the noise between black and 0, and of the threshold of the grey-level centroid.
CLEARANCE = 5.0
BITS = 8
# What a centroid may be off before it counts, px.
ACCURACY = 0.05
# Irrational steps through the pixel (Roberts' sequence in two dimensions).
STEPS = np.array([0.7548776662466927, 0.5698402909980532])


@dataclass(frozen=True)
class Camera:
    """A camera worse than the configured one: ``scale`` of its resolution, bits (None: not rounded), noise."""

    scale: float = 1.0
    bits: int | None = None
    noise: float = 0.0

    def picture(
        self, imaging: Mapping[str, Any], path: Path, generator: np.random.Generator, size: tuple[int, int]
    ) -> Image:
        """One image of a path given in this camera's pixels."""
        full = 2.0 ** (self.bits or BITS) - 1.0
        black = CLEARANCE * self.noise
        marker = Marker(self.scale * imaging["marker_diameter"], full - 2.0 * black)
        image = expose(path, 0.0, imaging["exposure"], marker, FrameFormat(*size, background=black))
        return quantise(image, self.bits, self.noise, generator) if self.bits else image.astype(np.float32)


def plain_gradient_centroid(image: Image, threshold: float, region: RegionOfInterest) -> tuple[float, float]:
    """The paper's three steps by bare OpenCV calls, to compare with."""
    import cv2

    view = image[region.top : region.top + region.height, region.left : region.left + region.width]
    magnitude = cv2.magnitude(cv2.Sobel(view, cv2.CV_32F, 1, 0), cv2.Sobel(view, cv2.CV_32F, 0, 1))
    _, selected = cv2.threshold(magnitude, threshold * float(magnitude.max()), 255.0, cv2.THRESH_BINARY)
    moments = cv2.moments(selected.astype(np.uint8), binaryImage=True)
    return region.left + moments["m10"] / moments["m00"], region.top + moments["m01"] / moments["m00"]


def _paths(imaging: Mapping[str, Any], scale: float, frequency: float, count: int) -> list[Path]:
    """The configured circle in a camera of another resolution, at rest if the frequency is 0."""
    centre = scale * (np.asarray(imaging["path_centre"], dtype=float) + 0.5) - 0.5
    paths = []
    for i, turn in enumerate(even_fractions(count)):
        x, y = centre + (i * STEPS) % 1.0 - 0.5
        if frequency > 0.0:
            path = circular_path((x, y), scale * imaging["path_diameter"], frequency, 2.0 * np.pi * float(turn))
        else:
            path = circular_path((x, y), 0.0, 0.0)
        paths.append(path)
    return paths


def _errors(
    settings: Mapping[str, Any],
    imaging: Mapping[str, Any],
    camera: Camera,
    frequency: float,
    generator: np.random.Generator,
) -> dict[str, float]:
    """Root mean square errors of the centroids, px of the configured camera."""
    size = tuple(int(np.ceil(camera.scale * imaging[side])) for side in ("height", "width"))
    margin, exposure = max(2.0, camera.scale * settings["margin"]), imaging["exposure"]
    errors: dict[str, list[Array]] = {}
    for path in _paths(imaging, camera.scale, frequency, settings["images"]):
        image = camera.picture(imaging, path, generator, (size[0], size[1]))
        region = swept_region(path, exposure, camera.scale * imaging["marker_diameter"], margin)
        mean = time_mean(path, 0.0, exposure)
        measured = {
            "gradient": gradient_centroid(image, settings["threshold"], region),
            "grey-level": grey_level_centroid(image, None, 0.0, region),
        }
        if camera.noise > 0.0:
            measured["grey-level, black known"] = grey_level_centroid(image, CLEARANCE * camera.noise, 0.0, region)
        for name, value in measured.items():
            errors.setdefault(name, []).append(np.array(value) - mean)
    return {name: root_mean_square(np.array(values)) / camera.scale for name, values in errors.items()}


def _region_errors(
    settings: Mapping[str, Any], imaging: Mapping[str, Any], side: int, generator: np.random.Generator
) -> dict[str, float]:
    """Root mean square errors for a marker at rest, with noise, in a square region of ``side`` px around it."""
    noise, threshold = settings["region_noise"], settings["threshold"]
    camera = Camera(1.0, BITS, noise)
    frame = side + 8
    local = {**imaging, "path_centre": [0.5 * frame, 0.5 * frame]}
    errors: dict[str, list[Array]] = {}
    for path in _paths(local, 1.0, 0.0, settings["region_images"]):
        place = time_mean(path, 0.0, imaging["exposure"])
        region = RegionOfInterest.around((float(place[0]), float(place[1])), side)
        image = camera.picture(imaging, path, generator, (frame, frame))
        measured = {
            "gradient": gradient_centroid(image, threshold, region),
            "gradient, plain OpenCV": plain_gradient_centroid(image, threshold, region),
            "grey-level": grey_level_centroid(image, None, 0.0, region),
            "grey-level, threshold": grey_level_centroid(image, None, CLEARANCE * noise, region),
        }
        for name, value in measured.items():
            errors.setdefault(name, []).append(np.array(value) - place)
    return {name: root_mean_square(np.array(values)) for name, values in errors.items()}


def compute(settings: Mapping[str, Any], shared: Mapping[str, Any]) -> pd.DataFrame:
    """Errors against resolution, bit depth, noise and size of the region of interest.

    Returns
    -------
    DataFrame
        ``varied`` (resolution | bit depth | noise | region), ``setting`` (marker diameter in pixels of the camera,
        bits, standard deviation in grey levels, side of the region in px), ``motion`` (moving | static), ``centroid``
        and ``error`` (root mean square, px of the configured camera).
    """
    imaging = shared["imaging"]
    cameras = {
        "resolution": [(d, Camera(scale=d / imaging["marker_diameter"])) for d in settings["diameters"]],
        "bit depth": [(b, Camera(bits=b)) for b in settings["bit_depths"]],
        "noise": [(n, Camera(bits=BITS, noise=n)) for n in settings["noises"]],
    }
    rows = []
    for i, (varied, cases) in enumerate(cameras.items()):
        for j, (setting, camera) in enumerate(cases):
            for k, (motion, frequency) in enumerate((("moving", settings["frequency"]), ("static", 0.0))):
                generator = np.random.default_rng(np.random.SeedSequence(shared["seed"], spawn_key=(i, j, k)))
                errors = _errors(settings, imaging, camera, frequency, generator)
                rows += [(varied, float(setting), motion, name, error) for name, error in errors.items()]
    for j, side in enumerate(settings["regions"]):
        generator = np.random.default_rng(np.random.SeedSequence(shared["seed"], spawn_key=(len(cameras), j)))
        errors = _region_errors(settings, imaging, side, generator)
        rows += [("region", float(side), "static", name, error) for name, error in errors.items()]
    return pd.DataFrame(rows, columns=["varied", "setting", "motion", "centroid", "error"])


def quantities(table: pd.DataFrame) -> dict[str, tuple[float, str]]:
    """Where the grey-level centroid becomes inaccurate, errors at the paper's camera, worst up to noise of 2."""
    errors = table.set_index(["varied", "setting", "motion", "centroid"])["error"]

    def accurate(varied: str) -> pd.Series:
        """Whether the grey-level centroid is accurate, moving and static, against the setting."""
        runs = table[(table["varied"] == varied) & (table["centroid"] == "grey-level")]
        return (runs.groupby("setting")["error"].max() <= ACCURACY).sort_index(ascending=False)

    def last_accurate(varied: str) -> float:
        """Setting down to which it stays so from the best on."""
        series = accurate(varied)
        good = series.index[series.to_numpy().cumprod().astype(bool)]
        return float(good[-1]) if len(good) else float("nan")

    regions = table[table["varied"] == "region"].pivot_table(index="setting", columns="centroid", values="error")
    plain = regions["gradient"] / regions["gradient, plain OpenCV"]
    without = regions.index[regions["grey-level"] <= 0.02]
    result = {
        "smallest_accurate_diameter": (last_accurate("resolution"), "px"),
        "fewest_accurate_bits": (last_accurate("bit depth"), "bit"),
        "gradient_static_8_bit": (float(errors["bit depth", 8.0, "static", "gradient"]), "px"),
        "gradient_moving_8_bit": (float(errors["bit depth", 8.0, "moving", "gradient"]), "px"),
        "grey_level_moving_8_bit": (float(errors["bit depth", 8.0, "moving", "grey-level"]), "px"),
        "grey_level_moving_fewest_bits": (
            float(errors["bit depth"].xs(("moving", "grey-level"), level=("motion", "centroid")).sort_index().iloc[0]),
            "px",
        ),
        "static_grey_level_threshold_largest_in_regions": (float(regions["grey-level, threshold"].max()), "px"),
        "static_grey_level_without_threshold_accurate_to": (
            float(without.max()) if len(without) else float("nan"),
            "px",
        ),
        "gradient_over_plain_opencv": (float(plain.max()), ""),
        "static_gradient_largest_in_regions": (float(regions["gradient"].max()), "px"),
    }
    runs = table[(table["varied"] == "noise") & (table["motion"] == "moving") & (table["setting"] == 2.0)]
    for centroid, error in zip(runs["centroid"], runs["error"], strict=True):
        name = centroid.replace(", ", "_").replace("-", "_").replace(" ", "_")
        result[f"{name}_moving_noise_2"] = (float(error), "px")
    noisy = table[(table["varied"] == "noise") & (table["setting"] > 0.0) & (table["setting"] <= 2.0)]
    worst = noisy.groupby("centroid")["error"].max()
    result["grey_level_border_median_worst"] = (float(worst["grey-level"]), "px")
    result["grey_level_black_known_worst"] = (float(worst["grey-level, black known"]), "px")
    resolution = errors["resolution"].xs(("moving", "gradient"), level=("motion", "centroid"))
    result["gradient_moving_smallest_over_resolutions"] = (float(resolution.min()), "px")
    result["gradient_moving_largest_over_resolutions"] = (float(resolution.max()), "px")
    return result


def conclusion(value: Mapping[str, float]) -> str:
    """The answer in words that follow the numbers."""
    threshold, plain = value["static_grey_level_threshold_largest_in_regions"], value["gradient_over_plain_opencv"]
    median, known = value["grey_level_border_median_worst"], value["grey_level_black_known_worst"]
    first = (
        f"The grey-level centroid stays within {ACCURACY:g} px down to a marker of "
        f"{value['smallest_accurate_diameter']:g} pixels and {value['fewest_accurate_bits']:g} bits; the gradient "
        f"centroid counts whole pixels, is off by {value['gradient_static_8_bit']:.2f} px even for a still marker "
        f"({'as' if plain < 1.001 else 'more than'} with plain OpenCV calls), and for the moving one anywhere from "
        f"{value['gradient_moving_smallest_over_resolutions']:.1f} to "
        f"{value['gradient_moving_largest_over_resolutions']:.1f} px by resolution."
    )
    second = (
        f"With noise of 2 grey levels the grey-level centroid finds a still marker to {threshold:.3f} px above a "
        "threshold of five standard deviations, in regions of interest of any size tried"
    )
    third = f"a moving one needs the whole region and a known black level ({known:.2f} px)"
    if median > 2.0 * known:
        third += f", as the border's median is a whole grey level and can cost {median:.1f} px"
    return f"{first} {second}; {third}."
