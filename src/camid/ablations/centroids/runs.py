"""Grey-level against gradient centroid on the circle, from an ideal image to a bad one.

The grey-level centroid is linear in the light, so without noise it is the time mean (4), (5) whatever the path and the
speed. What breaks that is what is not linear or not the marker's: whole grey levels (little if rounded, more if
truncated), noise clipped at black, light that is not removed, and saturation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.ablations.rendered_images import circles, grey_levels, root_mean_square, swept_region
from camid.images.centroids import RegionOfInterest, gradient_centroid, grey_level_centroid
from camid.images.forming import quantise
from camid.paper.marker_images import time_mean

Array = NDArray[np.float64]
Measure = Callable[[NDArray[Any], RegionOfInterest], tuple[float, float]]

BIT_DEPTH = 8
# From where on an error of the grey-level centroid is called one, px.
VISIBLE = 0.05
# The frequencies for which an independent computation is known, Hz.
KNOWN = (1.0, 5.0, 12.0, 24.0)


@dataclass(frozen=True)
class Condition:
    """How an ideal image is spoilt: intensity times ``gain``, light, noise, and how it becomes whole grey levels."""

    gain: float = 1.0
    light: float = 0.0
    ramp: float = 0.0
    noise: float = 0.0
    digits: str = "rounded"  # rounded | truncated | kept

    def spoil(self, image: NDArray[np.float32], generator: np.random.Generator) -> NDArray[Any]:
        """The image as the camera gives it."""
        ramp = self.ramp * np.arange(image.shape[1]) / image.shape[1]
        levels = self.gain * image.astype(float) + self.light + ramp
        if self.digits == "kept":
            return levels.astype(np.float32)
        if self.digits == "truncated":
            # A hair more, so that 255 summed up from areas does not become 254.
            levels = np.floor(levels + 1e-6)
        return quantise(levels, BIT_DEPTH, self.noise, generator)


def conditions(settings: Mapping[str, Any]) -> dict[str, Condition]:
    """The conditions by name."""
    noise, black = float(settings["noise"]), float(settings["black_level"])
    return {
        "floating point": Condition(digits="kept"),
        "8 bit": Condition(),
        "8 bit, truncated": Condition(digits="truncated"),
        "noise": Condition(noise=noise),
        "noise, black level": Condition(noise=noise, light=black),
        "uniform light": Condition(light=float(settings["light"])),
        "ramp of light": Condition(ramp=float(settings["light"])),
        **{f"{gain:g} × full scale": Condition(gain=float(gain)) for gain in settings["gains"]},
    }


def measures(settings: Mapping[str, Any]) -> dict[str, Measure]:
    """The centroids by name."""
    cut = 5.0 * float(settings["noise"])
    return {
        "gradient": lambda image, region: gradient_centroid(image, settings["threshold"], region),
        "gradient, fixed threshold": lambda image, region: gradient_centroid(
            image, settings["fixed_threshold"], region, relative=False
        ),
        "grey-level": lambda image, region: grey_level_centroid(image, 0.0, 0.0, region),
        "grey-level, border removed": lambda image, region: grey_level_centroid(image, None, 0.0, region),
        "grey-level, border removed, threshold": lambda image, region: grey_level_centroid(image, None, cut, region),
    }


def compute(settings: Mapping[str, Any], shared: Mapping[str, Any]) -> pd.DataFrame:
    """Error of the centroids against the time mean.

    Returns
    -------
    DataFrame
        ``condition``, ``centroid``, ``frequency`` (Hz), ``peak`` (largest grey level of an unclipped image over full
        scale) and ``error`` (px, root mean square over the starting angles).
    """
    imaging = shared["imaging"]
    spoilt, centroids, frequencies = conditions(settings), measures(settings), settings["frequencies"]
    diameter, exposure = imaging["marker_diameter"], imaging["exposure"]
    rows = []
    for i, frequency in enumerate(frequencies):
        paths = circles(imaging, frequency, settings["starting_angles"])
        images = [grey_levels(imaging, path, diameter) for path in paths]
        means = np.array([time_mean(path, 0.0, exposure) for path in paths])
        regions = [swept_region(path, exposure, diameter, settings["margin"]) for path in paths]
        for j, (name, condition) in enumerate(spoilt.items()):
            generator = np.random.default_rng(np.random.SeedSequence(shared["seed"], spawn_key=(i, j)))
            frames = [condition.spoil(image, generator) for image in images]
            peak = condition.gain * max(float(image.max()) for image in images) / (2.0**BIT_DEPTH - 1.0)
            for centroid, measure in centroids.items():
                measured = np.array([measure(f, region) for f, region in zip(frames, regions, strict=True)])
                rows.append(
                    {
                        "condition": name,
                        "centroid": centroid,
                        "frequency": float(frequency),
                        "peak": peak,
                        "error": root_mean_square(measured - means),
                    }
                )
    return pd.DataFrame(rows)


def quantities(table: pd.DataFrame) -> dict[str, tuple[float, str]]:
    """Errors at the known frequencies, and the largest of each way in which the grey-level centroid fails."""
    errors = table.set_index(["condition", "centroid", "frequency"])["error"].to_dict()
    quoted = {
        "gradient_at": ("8 bit", "gradient"),
        "gradient_fixed_threshold_at": ("8 bit", "gradient, fixed threshold"),
        "grey_level_floating_point_at": ("floating point", "grey-level"),
        "grey_level_rounded_at": ("8 bit", "grey-level"),
        "grey_level_truncated_at": ("8 bit, truncated", "grey-level"),
    }
    result = {
        f"{name}_{frequency:g}": (float(errors[*case, frequency]), "px")
        for name, case in quoted.items()
        for frequency in KNOWN
        if (*case, frequency) in errors
    }
    fastest = table["frequency"].max()

    def worst(condition: str, centroid: str) -> tuple[float, str]:
        runs = table[(table["condition"] == condition) & (table["centroid"] == centroid)]
        return float(runs["error"].max()), "px"

    result["fastest"] = (float(fastest), "Hz")
    result["gradient_noise_at_fastest"] = (float(errors["noise", "gradient", fastest]), "px")
    result["gradient_fixed_threshold_noise_at_fastest"] = (
        float(errors["noise", "gradient, fixed threshold", fastest]),
        "px",
    )
    removed, cut = "grey-level, border removed", "grey-level, border removed, threshold"
    result["grey_level_8_bit"] = worst("8 bit", "grey-level")
    result["grey_level_noise"] = worst("noise", "grey-level")
    result["grey_level_noise_black_level"] = worst("noise, black level", removed)
    result["grey_level_noise_threshold_at_fastest"] = (float(errors["noise", cut, fastest]), "px")
    result["grey_level_noise_threshold_at_slowest"] = (float(errors["noise", cut, table["frequency"].min()]), "px")
    result["grey_level_light_left"] = worst("uniform light", "grey-level")
    result["grey_level_light_removed"] = worst("uniform light", removed)
    result["grey_level_ramp"] = worst("ramp of light", removed)
    saturating = table[table["condition"].str.contains("full scale") & (table["centroid"] == "grey-level")]
    below, above = saturating[saturating["peak"] <= 1.0], saturating[saturating["peak"] > 1.0]
    result["grey_level_largest_before_saturation"] = (float(below["error"].max()), "px")
    result["grey_level_largest_saturated"] = (float(above["error"].max()), "px")
    off = saturating[saturating["error"] > VISIBLE]
    result["lowest_peak_with_error"] = (float(off["peak"].min()) if len(off) else float("inf"), "of full scale")
    return result


def conclusion(value: Mapping[str, float]) -> str:
    """The answer in words that follow the numbers."""
    exact = value["grey_level_8_bit"]
    gradient = value["gradient_at_5"]
    if exact < 0.1 * gradient:
        first = (
            f"In a clean 8 bit image the grey-level centroid is the time mean to {exact:.3f} px at every speed, where "
            f"the gradient centroid is off by {gradient:.2f} px at 5 Hz."
        )
    else:
        first = (
            f"In a clean 8 bit image the grey-level centroid is off the time mean by up to {exact:.2f} px, the "
            f"gradient centroid by {gradient:.2f} px at 5 Hz."
        )
    causes = {
        "noise clipped at black": value["grey_level_noise"],
        "uniform light left in": value["grey_level_light_left"],
        "light that rises across the frame": value["grey_level_ramp"],
        "saturation": value["grey_level_largest_saturated"],
    }
    harmful = [f"{cause} ({error:.1f} px)" for cause, error in causes.items() if error > VISIBLE]
    if not harmful:
        return f"{first} Nothing tried here takes it off by more than {VISIBLE:g} px."
    words = f"{', '.join(harmful[:-1])} and {harmful[-1]}" if len(harmful) > 1 else harmful[0]
    return (
        f"{first} It stops being the time mean with {words}; a black level above the noise, with the border's median "
        f"removed, leaves {value['grey_level_noise_black_level']:.2f} px at most, and saturation shows from "
        f"{value['lowest_peak_with_error']:.1f} times full scale on."
    )
