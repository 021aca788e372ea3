"""Assumption A2: a path that meets itself within an exposure.

Equation (1) counts a place as often as the marker passes it, the gradient centroid once. Two closed paths tell apart
what A2 throws together: a circle, which covers itself from one turn in an exposure on, and a figure of eight, which
from half a pass on also crosses itself in one point. Both are run through at constant speed (A4 holds), by a small
marker (A1 nearly holds) and by the paper's.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from camid.ablations.rendered_images import Path, circles, even_fractions, grey_levels, root_mean_square
from camid.images.centroids import gradient_centroid, grey_level_centroid
from camid.paper.marker_images import arc_length_mean

# Points from which the arc length of the figure of eight is inverted; they are a fortieth of a pixel apart.
KNOTS = 20_001


def figure_of_eight(imaging: Mapping[str, Any], passes: float, count: int) -> list[Path]:
    """Lemniscate of Bernoulli at constant speed, as long as the configured circle, from ``count`` starting points.

    Parameters
    ----------
    imaging : mapping
        Section ``imaging`` of the configuration.
    passes : float
        How often the path is run through in an exposure.
    """
    turn = np.linspace(0.0, 2.0 * np.pi, KNOTS)
    curve = np.stack((np.cos(turn), np.sin(turn) * np.cos(turn)), axis=1) / (1.0 + np.sin(turn) ** 2)[:, None]
    length = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))))
    centre, size = np.asarray(imaging["path_centre"], dtype=float), np.pi * imaging["path_diameter"] / length[-1]
    rate = passes / imaging["exposure"]

    def from_start(start: float) -> Path:
        def path(time: np.ndarray) -> np.ndarray:
            place = ((rate * np.asarray(time) + start) % 1.0) * length[-1]
            return centre + size * np.stack([np.interp(place, length, curve[:, i]) for i in (0, 1)], axis=-1)

        return path

    return [from_start(float(start)) for start in even_fractions(count)]


def compute(settings: Mapping[str, Any], shared: Mapping[str, Any]) -> pd.DataFrame:
    """Distance of both centroids from equation (1).

    Returns
    -------
    DataFrame
        ``path`` (circle | eight), ``passes`` in an exposure, ``diameter`` (px), ``centroid`` (gradient | grey-level),
        ``threshold`` (share of the largest gradient, 0 for the grey-level centroid) and ``distance`` (px, root mean
        square over the starting points).
    """
    imaging, count = shared["imaging"], settings["starting_points"]
    thresholds = [float(t) for t in settings["thresholds"]]
    rows = []
    for passes in settings["passes"]:
        paths = {
            "circle": circles(imaging, passes / imaging["exposure"], count),
            "eight": figure_of_eight(imaging, passes, count),
        }
        for name, started in paths.items():
            expected = [arc_length_mean(path, 0.0, imaging["exposure"]) for path in started]
            for diameter in settings["diameters"]:
                images = [grey_levels(imaging, path, diameter) for path in started]
                for threshold in (0.0, *thresholds):
                    measured = [
                        gradient_centroid(image, threshold) if threshold else grey_level_centroid(image, background=0.0)
                        for image in images
                    ]
                    rows.append(
                        {
                            "path": name,
                            "passes": float(passes),
                            "diameter": float(diameter),
                            "centroid": "gradient" if threshold else "grey-level",
                            "threshold": threshold,
                            "distance": root_mean_square(np.array(measured) - np.array(expected)),
                        }
                    )
    return pd.DataFrame(rows)


def quantities(table: pd.DataFrame) -> dict[str, tuple[float, str]]:
    """Largest distances of the smallest marker's centroid on parts of the range of passes."""
    small = table[(table["diameter"] == table["diameter"].min()) & (table["centroid"] == "gradient")]
    low, high = small["threshold"].min(), small["threshold"].max()

    def largest(path: str, threshold: float, above: float, below: float) -> tuple[float, str]:
        between = (small["passes"] > above) & (small["passes"] < below)
        runs = small[between & (small["path"] == path) & (small["threshold"] == threshold)]
        return float(runs["distance"].max()), "px"

    return {
        "diameter": (float(small["diameter"].iloc[0]), "px"),
        "threshold": (float(low), ""),
        "higher_threshold": (float(high), ""),
        "largest_eight_before_crossing": largest("eight", low, 0.0, 0.5),
        "largest_eight_crossing_once": largest("eight", low, 0.5, 1.0),
        "largest_eight_covering_itself": largest("eight", low, 1.0, np.inf),
        "largest_circle_before_a_turn": largest("circle", low, 0.0, 1.0),
        "largest_circle_covering_itself": largest("circle", low, 1.0, np.inf),
        "largest_circle_covering_itself_higher_threshold": largest("circle", high, 1.0, np.inf),
        "largest_grey_level": (float(table.loc[table["centroid"] == "grey-level", "distance"].max()), "px"),
    }


def conclusion(value: Mapping[str, float]) -> str:
    """The answer in words that follow the numbers."""
    before, crossing = value["largest_eight_before_crossing"], value["largest_eight_crossing_once"]
    covering, turn = value["largest_circle_covering_itself"], value["largest_circle_before_a_turn"]
    other = value["largest_circle_covering_itself_higher_threshold"]
    case = f"{value['diameter']:g} px marker, threshold {value['threshold']:g}"
    if crossing < 1.5 * before and covering > 2.0 * turn:
        first = (
            "Crossing its own path in one point costs the gradient centroid nothing that shows: at most "
            f"{crossing:.1f} px from (1) on a figure of eight, {before:.1f} px where it does not cross ({case}). "
            f"Running over it again does: up to {covering:.1f} px on a circle past one turn in an exposure"
        )
        if other > 2.0 * covering:
            first += (
                f" (at a threshold of {value['higher_threshold']:g}, which drops what was passed once, {other:.0f} px)"
            )
        first += "."
    else:
        first = (
            f"On a figure of eight the gradient centroid is at most {before:.1f} px from (1) where it does not cross "
            f"itself and {crossing:.1f} px where it does; on a circle {turn:.1f} px before and {covering:.1f} px past "
            f"one turn in an exposure ({case})."
        )
    second = (
        "The grey-level centroid does not need A2."
        if value["largest_grey_level"] < 0.01
        else f"The grey-level centroid is off by up to {value['largest_grey_level']:.2f} px, too."
    )
    return f"{first} {second}"
