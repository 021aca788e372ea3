"""Assumption A1: what a marker that is not small does to the gradient centroid.

The paper says that the outer part of the contour is longer than the inner one, so the centre of mass is shifted in the
centrifugal direction. Two more things happen. The two ends of the blurred image, half a marker each, lengthen the arc
and pull its centre of mass inward; their gradient is small, so a low threshold counts them and a high one does not. And
the marker spends less time over the outer rim than over the inner one, so the outer gradient is smaller, and the
highest thresholds leave the inner rim alone. The threshold therefore decides the sign.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.ablations.rendered_images import circles, grey_levels, outward
from camid.images.centroids import gradient_centroid, grey_level_centroid
from camid.paper.marker_images import arc_length_mean

Array = NDArray[np.float64]

# What is quoted: the paper's marker on the paper's fast circle.
QUOTED_THRESHOLDS = (0.05, 0.2, 0.5)


def compute(settings: Mapping[str, Any], shared: Mapping[str, Any]) -> pd.DataFrame:
    """Outward shift of both centroids from equation (1).

    Returns
    -------
    DataFrame
        ``frequency`` (Hz), ``diameter`` (px), ``configured`` (whether it is the paper's marker), ``centroid`` (gradient
        | grey-level), ``threshold`` (share of the largest gradient, 0 for the grey-level centroid), ``outward`` and
        ``spread`` (px: mean and standard deviation over the starting angles), ``vanishing_threshold`` (of the gradient
        centroid at this frequency and diameter, NaN without one).
    """
    imaging = shared["imaging"]
    thresholds = [float(t) for t in settings["thresholds"]]
    rows = []
    for frequency in settings["frequencies"]:
        for diameter in settings["diameters"]:
            shifts: list[list[float]] = []
            for path in circles(imaging, frequency, settings["starting_angles"]):
                expected = arc_length_mean(path, 0.0, imaging["exposure"])
                direction = outward(imaging, expected)
                image = grey_levels(imaging, path, diameter)
                measured = [grey_level_centroid(image, background=0.0)]
                measured += [gradient_centroid(image, threshold) for threshold in thresholds]
                shifts.append([float((np.array(m) - expected) @ direction) for m in measured])
            mean, spread = np.mean(shifts, axis=0), np.std(shifts, axis=0)
            vanishing = vanishing_threshold(np.array(thresholds), mean[1:])
            rows += [
                {
                    "frequency": float(frequency),
                    "diameter": float(diameter),
                    "configured": bool(diameter == imaging["marker_diameter"]),
                    "centroid": "gradient" if threshold > 0.0 else "grey-level",
                    "threshold": threshold,
                    "outward": float(mean[i]),
                    "spread": float(spread[i]),
                    "vanishing_threshold": vanishing,
                }
                for i, threshold in enumerate([0.0, *thresholds])
            ]
    return pd.DataFrame(rows)


def vanishing_threshold(thresholds: Array, shifts: Array) -> float:
    """Lowest threshold at which the shift turns from inward to outward, between two of those tried; NaN without one."""
    rising = np.flatnonzero((shifts[:-1] < 0.0) & (shifts[1:] >= 0.0))
    if not rising.size:
        return float("nan")
    i = int(rising[0])
    return float(np.interp(0.0, shifts[i : i + 2], thresholds[i : i + 2]))


def quantities(table: pd.DataFrame) -> dict[str, tuple[float, str]]:
    """Shifts of the paper's marker, where they vanish, and the grey-level centroid's."""
    fastest, slowest = float(table["frequency"].max()), float(table["frequency"].min())
    gradient = table[table["centroid"] == "gradient"].sort_values("threshold")
    paper, smallest = gradient[gradient["configured"]], gradient[gradient["diameter"] == gradient["diameter"].min()]

    def at(runs: pd.DataFrame, frequency: float, threshold: float) -> float:
        runs = runs[runs["frequency"] == frequency]
        return float(np.interp(threshold, runs["threshold"], runs["outward"]))

    result = {
        "diameter": (float(paper["diameter"].iloc[0]), "px"),
        "fast_frequency": (fastest, "Hz"),
        "slow_frequency": (slowest, "Hz"),
    }
    result |= {f"outward_shift_fast_threshold_{t:g}": (at(paper, fastest, t), "px") for t in QUOTED_THRESHOLDS}
    result["outward_shift_fast_highest_threshold"] = (at(paper, fastest, 1.0), "px")
    result["outward_shift_slow_threshold_0.2"] = (at(paper, slowest, 0.2), "px")
    result["outward_shift_smallest_marker_threshold_0.2"] = (at(smallest, fastest, 0.2), "px")
    zeros = gradient.loc[gradient["frequency"] == fastest, "vanishing_threshold"]
    paper_zeros = paper.loc[paper["frequency"] == fastest, "vanishing_threshold"]
    result["vanishing_threshold_fast"] = (float(paper_zeros.iloc[0]), "")
    result["lowest_vanishing_threshold_fast"] = (float(zeros.min()), "")
    result["highest_vanishing_threshold_fast"] = (float(zeros.max()), "")
    grey = table[table["centroid"] == "grey-level"]
    result["largest_shift_grey_level"] = (float(grey["outward"].abs().max()), "px")
    return result


def conclusion(value: Mapping[str, float]) -> str:
    """The answer in words that follow the numbers."""

    def words(shift: float) -> str:
        return f"{abs(shift):.1f} px {'outward' if shift > 0.0 else 'inward'}"

    low, middle, high = (value[f"outward_shift_fast_threshold_{t:g}"] for t in QUOTED_THRESHOLDS)
    case = f"the paper's {value['diameter']:g} px marker at {value['fast_frequency']:g} Hz"
    if low < 0.0 < high:
        first = (
            f"The threshold decides the sign of the shift that a large marker causes: for {case} it is {words(low)} at "
            f"a threshold of 0.05 of the largest gradient, {words(middle)} at 0.2 and {words(high)} at 0.5, and it "
            f"vanishes at {value['vanishing_threshold_fast']:.2f}; no one threshold serves all markers, as the "
            f"vanishing one runs from {value['lowest_vanishing_threshold_fast']:.2f} to "
            f"{value['highest_vanishing_threshold_fast']:.2f} with the diameter."
        )
    else:
        first = (
            f"The shift that a large marker causes does not turn from inward to outward as the threshold rises: for "
            f"{case} it is {words(low)}, {words(middle)} and {words(high)} at 0.05, 0.2 and 0.5 of the largest "
            "gradient."
        )
    second = (
        "The grey-level centroid does not need A1: its shift stays below 0.01 px."
        if value["largest_shift_grey_level"] < 0.01
        else f"The grey-level centroid shifts too, by up to {value['largest_shift_grey_level']:.2f} px."
    )
    return f"{first} {second}"
