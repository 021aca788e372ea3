"""Assumption A4: a speed that changes within the exposure.

Equation (2) weighs a place by the speed there, the time mean (4), (5) by the time spent there. On a straight path of
length L the mean (2) is its middle as long as the marker does not turn, whatever the speed; the time mean lies nearer
to the slow end. The gradient centroid is neither: where the marker is fast it leaves little light, the gradient is
small, and a threshold that is a share of the largest gradient drops the fast part altogether.

Three families of motion along a line, each over the same length of path:
acceleration (the change of speed within the exposure over the mean speed: 0 at constant speed, 2 from rest), a turning
point (the share of the exposure that is over when a constant acceleration has turned the marker round), and a stop (the
share of the exposure that the marker rests at the end, after constant speed).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.ablations.rendered_images import even_fractions, grey_levels
from camid.images.centroids import gradient_centroid, grey_level_centroid
from camid.paper.marker_images import arc_length_mean, time_mean

Array = NDArray[np.float64]
Motion = Callable[[Array], Array]

# What still counts as following equation (2), px.
FOLLOWING = 1.0


def accelerated(change: float, length: float) -> Motion:
    """Place along the line, px, against the share of the exposure; the speed changes by ``change`` mean speeds."""
    return lambda share: length * ((1.0 - 0.5 * change) * share + 0.5 * change * share**2 - 0.5)


def turning(instant: float, length: float) -> Motion:
    """Constant acceleration that stops the marker at ``instant``, a share of the exposure, and takes it back."""
    scale = length / (instant**2 + (1.0 - instant) ** 2)
    return lambda share: scale * ((share - instant) ** 2 - 0.5 * (1.0 - instant) ** 2)


def stopping(rest: float, length: float) -> Motion:
    """Constant speed, and then rest for the share ``rest`` of the exposure."""
    return lambda share: length * (np.minimum(share / (1.0 - rest), 1.0) - 0.5)


MOTIONS: dict[str, Callable[[float, float], Motion]] = {
    "acceleration": accelerated,
    "turning point": turning,
    "stop": stopping,
}
SETTINGS = {"acceleration": "relative_changes", "turning point": "turning_instants", "stop": "rests"}


def compute(settings: Mapping[str, Any], shared: Mapping[str, Any]) -> pd.DataFrame:
    """Distance along the line of equation (2) and of both centroids from the time mean.

    Returns
    -------
    DataFrame
        ``motion`` (acceleration | turning point | stop), ``setting`` (see the module), ``diameter`` (px), ``length`` of
        the path (px), ``position`` (gradient | grey-level | arc-length mean), ``threshold`` (share of the largest
        gradient, 0 where there is none), ``ahead`` and ``spread`` (px: mean and standard deviation, over directions of
        the line and places on the grid of pixels, of the position minus the time mean, along the line).
    """
    imaging, count = shared["imaging"], settings["directions"]
    exposure, length = imaging["exposure"], float(settings["length"])
    centre = np.asarray(imaging["path_centre"], dtype=float)
    positions = [
        ("arc-length mean", 0.0),
        ("grey-level", 0.0),
        *(("gradient", float(t)) for t in settings["thresholds"]),
    ]
    angles = 2.0 * np.pi * even_fractions(count)
    rows = []
    for motion, family in MOTIONS.items():
        for setting in settings[SETTINGS[motion]]:
            along = family(float(setting), length)
            for diameter in settings["diameters"]:
                ahead: list[list[float]] = []
                for angle in angles:
                    direction = np.array([np.cos(angle), np.sin(angle)])

                    def path(time: Array, along: Motion = along, direction: Array = direction) -> Array:
                        # Off the grid of pixels by a fraction of its own for each direction.
                        return centre + direction + np.multiply.outer(along(np.asarray(time) / exposure), direction)

                    image, mean = grey_levels(imaging, path, diameter), time_mean(path, 0.0, exposure)
                    measured = [arc_length_mean(path, 0.0, exposure), grey_level_centroid(image, background=0.0)]
                    measured += [gradient_centroid(image, threshold) for _, threshold in positions[2:]]
                    ahead.append([float((np.asarray(m) - mean) @ direction) for m in measured])
                rows += [
                    {
                        "motion": motion,
                        "setting": float(setting),
                        "diameter": float(diameter),
                        "length": length,
                        "position": position,
                        "threshold": threshold,
                        "ahead": float(np.mean(column)),
                        "spread": float(np.std(column)),
                    }
                    for (position, threshold), column in zip(positions, np.transpose(ahead), strict=True)
                ]
    return pd.DataFrame(rows)


def quantities(table: pd.DataFrame) -> dict[str, tuple[float, str]]:
    """Distances from the time mean from rest and at the ends of the other two families, smallest marker."""
    small = table[table["diameter"] == table["diameter"].min()]
    thresholds = sorted(small.loc[small["position"] == "gradient", "threshold"].unique())
    middle = thresholds[len(thresholds) // 2]

    def curve(motion: str, position: str, threshold: float = 0.0) -> pd.DataFrame:
        chosen = (small["motion"] == motion) & (small["position"] == position) & (small["threshold"] == threshold)
        return small[chosen].sort_values("setting")

    result = {
        "length": (float(small["length"].iloc[0]), "px"),
        "diameter": (float(small["diameter"].iloc[0]), "px"),
        "threshold": (float(middle), ""),
        "arc_length_mean_constant_speed": (float(curve("acceleration", "arc-length mean")["ahead"].iloc[0]), "px"),
        "arc_length_mean_from_rest": (float(curve("acceleration", "arc-length mean")["ahead"].iloc[-1]), "px"),
        "arc_length_mean_turning_latest": (float(curve("turning point", "arc-length mean")["ahead"].iloc[-1]), "px"),
    }
    for threshold in thresholds:
        ahead = curve("acceleration", "gradient", threshold)["ahead"]
        result[f"gradient_constant_speed_threshold_{threshold:g}"] = (float(ahead.iloc[0]), "px")
        result[f"gradient_from_rest_threshold_{threshold:g}"] = (float(ahead.iloc[-1]), "px")
    gradient, arc = curve("acceleration", "gradient", middle), curve("acceleration", "arc-length mean")
    apart = np.abs(gradient["ahead"].to_numpy() - arc["ahead"].to_numpy())
    result["follows_arc_length_mean_up_to"] = (_first_reaching(gradient["setting"].to_numpy(), apart, FOLLOWING), "")
    for motion in ("turning point", "stop"):
        ahead = curve(motion, "gradient", middle)["ahead"]
        result[f"largest_gradient_{motion.replace(' ', '_')}"] = (float(ahead.abs().max()), "px")
    grey = table[table["position"] == "grey-level"]
    result["largest_grey_level"] = (float(grey["ahead"].abs().max()), "px")
    return result


def _first_reaching(settings: Array, values: Array, limit: float) -> float:
    """Setting at which the values first reach a limit, by a straight line; the last setting if they do not."""
    above = np.flatnonzero(values >= limit)
    if not above.size:
        return float(settings[-1])
    i = int(above[0])
    if i == 0:
        return float(settings[0])
    share = (limit - values[i - 1]) / (values[i] - values[i - 1])
    return float(settings[i - 1] + share * (settings[i] - settings[i - 1]))


def conclusion(value: Mapping[str, float]) -> str:
    """The answer in words that follow the numbers."""
    arc, gradient = value["arc_length_mean_from_rest"], value[f"gradient_from_rest_threshold_{value['threshold']:g}"]
    case = f"from rest over {value['length']:g} px ({value['diameter']:g} px marker, threshold {value['threshold']:g})"
    if abs(gradient - arc) <= 0.2 * abs(arc):
        first = (
            f"When the speed changes within an exposure the gradient centroid follows (2): {case} it lies "
            f"{gradient:+.1f} px and (2) {arc:+.1f} px from the time mean."
        )
    else:
        first = (
            "When the speed changes within an exposure the gradient centroid follows neither (2) nor the time mean: "
            f"{case} (2) lies {arc:+.1f} px and the gradient centroid {gradient:+.1f} px from the time mean, because a "
            "relative threshold drops what was passed fast; it keeps within "
            f"{FOLLOWING:g} px of (2) up to a change of {100.0 * value['follows_arc_length_mean_up_to']:.0f} % of the "
            "mean speed."
        )
    second = (
        "The grey-level centroid does not need A4: it is the time mean with acceleration, turning point and stop."
        if value["largest_grey_level"] < 0.01
        else f"The grey-level centroid is off the time mean by up to {value['largest_grey_level']:.2f} px."
    )
    return f"{first} {second}"
