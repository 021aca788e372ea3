"""Shift of the centroids by a large marker, against the geometry of the covered area."""

from __future__ import annotations

import numpy as np
import pytest

from camid.ablations.marker_size import runs as marker_size
from camid.ablations.marker_size.drawing import draw

SETTINGS = {
    "diameters": [4, 30],
    "frequencies": [5, 24],
    "thresholds": [0.005, 0.05, 0.2, 0.5, 0.9],
    "starting_angles": 3,
}


def footprint_shift(diameter, path_diameter, angle):
    """Outward shift from (1) of the centre of mass of everything that the disk covers, threshold 0 in the limit.

    Parameters
    ----------
    diameter, path_diameter : float
        Marker and circle, px; the marker is the smaller.
    angle : float
        Arc in an exposure, rad, below a turn.

    Returns
    -------
    float
        px; a ring sector between the radii R ± r and half a disk at either end. Below zero is inward.
    """
    radius, outer, inner = 0.5 * path_diameter, 0.5 * (path_diameter + diameter), 0.5 * (path_diameter - diameter)
    arc = radius * np.sinc(angle / (2.0 * np.pi))
    sector = 0.5 * angle * (outer**2 - inner**2)
    sector_place = arc / radius * (2.0 / 3.0) * (outer**3 - inner**3) / (outer**2 - inner**2)
    ends = 0.25 * np.pi * diameter**2
    ends_place = radius * np.cos(0.5 * angle) - 2.0 * diameter / (3.0 * np.pi) * np.sin(0.5 * angle)
    return float((sector * sector_place + ends * ends_place) / (sector + ends) - arc)


@pytest.fixture(scope="module")
def table(imaging):
    return marker_size.compute(SETTINGS, {"imaging": imaging})


def test_footprint_against_counted_pixels():
    """The closed form against the centre of mass of a fine grid of points within 15 px of the arc."""
    angle = 2.0 * np.pi * 24.0 * 0.02
    x, y = np.meshgrid(np.arange(-120.0, 120.0, 0.25), np.arange(-120.0, 120.0, 0.25))
    turn = np.abs(np.arctan2(y, x))
    ends = [np.hypot(x - 80.0 * np.cos(a), y - 80.0 * np.sin(a)) < 15.0 for a in (-angle / 2, angle / 2)]
    covered = ((turn < angle / 2) & (np.abs(np.hypot(x, y) - 80.0) < 15.0)) | ends[0] | ends[1]
    expected = x[covered].mean() - 80.0 * np.sin(angle / 2) / (angle / 2)
    assert footprint_shift(30.0, 160.0, angle) == pytest.approx(expected, abs=0.01)


def test_a_low_threshold_leaves_the_footprint(table, imaging):
    """Nearly everything covered has a gradient; the 3 × 3 filter widens it by up to a pixel and a half."""
    angle = 2.0 * np.pi * 24.0 * imaging["exposure"]
    runs = table[(table["threshold"] == 0.005) & (table["frequency"] == 24) & (table["diameter"] == 30)]
    bare, widened = (footprint_shift(d, imaging["path_diameter"], angle) for d in (30.0, 33.0))
    assert widened < runs["outward"].item() < bare < 0.0


def test_the_grey_level_centroid_does_not_shift(table):
    assert table.loc[table["centroid"] == "grey-level", "outward"].abs().max() < 0.005


def test_vanishing_threshold_lies_on_the_line_between_two_points():
    thresholds = np.array([0.1, 0.2, 0.4, 0.6])
    assert marker_size.vanishing_threshold(thresholds, np.array([-2.0, -1.0, 1.0, -1.0])) == pytest.approx(0.3)
    assert np.isnan(marker_size.vanishing_threshold(thresholds, np.array([2.0, 1.0, -1.0, -2.0])))


def test_the_conclusion_follows_the_numbers(table):
    value = {name: number for name, (number, _) in marker_size.quantities(table).items()}
    assert value["outward_shift_fast_threshold_0.05"] < 0.0 < value["outward_shift_fast_threshold_0.5"]
    sentence = marker_size.conclusion(value)
    assert "decides the sign" in sentence
    assert "does not need A1" in sentence
    other = marker_size.conclusion({**value, "outward_shift_fast_threshold_0.05": 3.0, "largest_shift_grey_level": 0.5})
    assert "does not turn" in other
    assert "3.0 px outward" in other
    assert "0.50 px" in other


def test_the_figure_and_its_numbers(table):
    figure, numbers = draw(table)
    assert len(figure.axes) == 4
    assert set(numbers["centroid"]) == {"gradient", "grey-level"}
