"""Rendered images of the marker, their measurement, and what happens when an assumption of section 2.2 fails."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.images.centroids import gradient_centroid, gradient_image, grey_level_centroid
from camid.images.forming import FrameFormat, Marker, circular_path, expose, quantise

Array = NDArray[np.float64]
Path = Callable[[Array], Array]

# Instants of the midpoint rule for integrals along a smooth path; the error is far below a thousandth of a pixel.
INSTANTS = 20_000
# Where the assumptions are made to fail: diameters in px, thresholds as shares of the largest gradient, turns in an
# exposure, a distance in px.
A1_DIAMETERS = (8.0, 15.0, 30.0, 45.0)
A1_THRESHOLDS = (0.05, 0.2, 0.5)
A2_DIAMETER = 8.0
A2_TURNS = (0.5, 0.75, 1.25, 1.5)
A4_DISTANCE = 60.0


def frame_format(imaging: Mapping[str, Any]) -> FrameFormat:
    """Frame of the configuration."""
    return FrameFormat(imaging["height"], imaging["width"])


def marker(imaging: Mapping[str, Any], diameter: float | None = None) -> Marker:
    """Marker of the configuration, in three colour components."""
    red, green, blue = imaging["marker_intensity"]
    return Marker(diameter or imaging["marker_diameter"], (red, green, blue))


def configured_path(imaging: Mapping[str, Any], frequency: float) -> Path:
    """Circular path of the configuration at a frequency in Hz."""
    centre = (imaging["path_centre"][0], imaging["path_centre"][1])
    return circular_path(centre, imaging["path_diameter"], frequency, imaging["path_phase"])


def time_mean(path: Path, start: float, exposure: float) -> Array:
    """Equations (4) and (5): mean position over the exposure, shape (2,), px."""
    instants = start + exposure * (np.arange(INSTANTS) + 0.5) / INSTANTS
    return path(instants).mean(axis=0)


def arc_length_mean(path: Path, start: float, exposure: float) -> Array:
    """Equations (2) and (3): centre of mass of the curve, the mean weighted by the speed, shape (2,), px."""
    edges = path(start + exposure * np.arange(INSTANTS + 1) / INSTANTS)
    middles = path(start + exposure * (np.arange(INSTANTS) + 0.5) / INSTANTS)
    lengths = np.linalg.norm(np.diff(edges, axis=0), axis=1)
    return lengths @ middles / lengths.sum()


def fast_marker_image(imaging: Mapping[str, Any]) -> dict[str, Array]:
    """Everything that Figs. 1 and 2 show: image, trajectory, gradient, selected pixels and centres.

    Returns
    -------
    dict of ndarray
        ``image`` (height, width, 3) float grey levels, ``quantised`` (8 bit), ``trajectory`` (M, 2), ``gradient``
        (height, width), ``selected`` (bool), ``centroid``, ``arc_length_mean``, ``time_mean`` (2,) each, in px.
    """
    path = configured_path(imaging, imaging["fast_frequency"])
    exposure = imaging["exposure"]
    image = expose(path, 0.0, exposure, marker(imaging), frame_format(imaging))
    quantised = quantise(image)
    gradient = gradient_image(quantised)
    return {
        "image": image,
        "quantised": quantised,
        "trajectory": path(np.linspace(0.0, exposure, 401)),
        "gradient": np.asarray(gradient),
        "selected": np.asarray(gradient > imaging["threshold"] * gradient.max()),
        "centroid": np.array(gradient_centroid(quantised, imaging["threshold"])),
        "arc_length_mean": arc_length_mean(path, 0.0, exposure),
        "time_mean": time_mean(path, 0.0, exposure),
    }


def slow_marker_trajectory(imaging: Mapping[str, Any]) -> pd.DataFrame:
    """Fig. 3: image-processing measurements of the slow circle beside the simplified model.

    Returns
    -------
    DataFrame
        A row a frame: ``k``, ``time`` (s, end of the exposure), ``measured_x``, ``measured_y`` (gradient centroid),
        ``half_threshold_x``, ``half_threshold_y`` (the same with a threshold of 0.5), ``grey_level_x``,
        ``grey_level_y``, ``model_x``, ``model_y`` (equations (4), (5)); px; and
        ``signal_to_noise`` of the whole (dB).
    """
    path = configured_path(imaging, imaging["slow_frequency"])
    rows = []
    for k in range(imaging["slow_frames"]):
        start = k * imaging["period"] + imaging["period"] - imaging["exposure"]
        image = quantise(expose(path, start, imaging["exposure"], marker(imaging), frame_format(imaging)))
        measured = gradient_centroid(image, imaging["threshold"])
        other = gradient_centroid(image, 0.5)
        grey = grey_level_centroid(image, background=0.0)
        model = time_mean(path, start, imaging["exposure"])
        rows.append(
            {
                "k": k,
                "time": (k + 1) * imaging["period"],
                "measured_x": measured[0],
                "measured_y": measured[1],
                "half_threshold_x": other[0],
                "half_threshold_y": other[1],
                "grey_level_x": grey[0],
                "grey_level_y": grey[1],
                "model_x": model[0],
                "model_y": model[1],
            }
        )
    table = pd.DataFrame(rows)
    return table.assign(signal_to_noise=signal_to_noise_decibels(table))


def signal_to_noise_decibels(trajectory: pd.DataFrame, measured: str = "measured") -> float:
    """Power of the model's motion about its mean over that of the measurement error, both coordinates, in dB."""
    model = trajectory[["model_x", "model_y"]].to_numpy()
    error = trajectory[[f"{measured}_x", f"{measured}_y"]].to_numpy() - model
    return float(10.0 * np.log10(np.sum((model - model.mean(axis=0)) ** 2) / np.sum(error**2)))


def assumption_failures(imaging: Mapping[str, Any]) -> pd.DataFrame:
    """What the gradient centroid does when A1, A2 or A4 fails, each against the formula that the assumption leads to.

    The images stay floating point here: a dim, fast marker has few grey levels, and rounding is assumption A3.

    Returns
    -------
    DataFrame
        Columns ``assumption``, ``quantity``, ``setting`` (marker diameter in px, turns an exposure, …), ``threshold``
        and ``value`` (px).
    """
    exposure, fast = imaging["exposure"], imaging["fast_frequency"]
    rows = [
        ("A1", "outward shift from (1)", diameter, threshold, _outward_shift(imaging, fast, diameter, threshold))
        for threshold in A1_THRESHOLDS
        for diameter in A1_DIAMETERS
    ]
    for turns in A2_TURNS:
        path = configured_path(imaging, turns / exposure)
        measured = gradient_centroid(_grey_image(imaging, path, A2_DIAMETER), imaging["threshold"])
        distance = float(np.linalg.norm(np.array(measured) - arc_length_mean(path, 0.0, exposure)))
        rows.append(("A2", "distance from (1)", turns, imaging["threshold"], distance))
    centre = np.array(imaging["path_centre"])

    def accelerated(time: Array) -> Array:
        share = np.asarray(time) / exposure
        return centre + np.stack([A4_DISTANCE * share**2, np.zeros_like(share)], axis=-1)

    for name, path in (("constant speed", configured_path(imaging, fast)), ("from rest", accelerated)):
        difference = arc_length_mean(path, 0.0, exposure) - time_mean(path, 0.0, exposure)
        rows.append(("A4", f"distance of (2) from the time mean, {name}", fast, 0.0, float(np.linalg.norm(difference))))
    path = configured_path(imaging, fast)
    colour = expose(path, 0.0, exposure, marker(imaging), frame_format(imaging))[:, :, 0]
    grey = expose(
        path,
        0.0,
        exposure,
        Marker(imaging["marker_diameter"], float(imaging["marker_intensity"][0])),
        frame_format(imaging),
    )
    rows.append(("colour", "largest difference from a grey camera", fast, 0.0, float(np.max(np.abs(colour - grey)))))
    return pd.DataFrame(rows, columns=["assumption", "quantity", "setting", "threshold", "value"])


def _grey_image(imaging: Mapping[str, Any], path: Path, diameter: float) -> NDArray[np.float32]:
    image = expose(path, 0.0, imaging["exposure"], Marker(diameter), frame_format(imaging))
    return image.astype(np.float32)


def _outward_shift(imaging: Mapping[str, Any], frequency: float, diameter: float, threshold: float) -> float:
    """Displacement of the gradient centroid from (1) away from the circle's centre, mean over four starting angles."""
    centre = np.array(imaging["path_centre"])
    shifts = []
    for turn in np.arange(4) / 4.0:
        path = configured_path({**imaging, "path_phase": 2.0 * np.pi * turn}, frequency)
        expected = arc_length_mean(path, 0.0, imaging["exposure"])
        outward = (expected - centre) / np.linalg.norm(expected - centre)
        measured = np.array(gradient_centroid(_grey_image(imaging, path, diameter), threshold))
        shifts.append(float((measured - expected) @ outward))
    return float(np.mean(shifts))
