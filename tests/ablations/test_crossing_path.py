"""Paths that cross or cover themselves, against what counting once and counting each time must give."""

from __future__ import annotations

import numpy as np
import pytest

from camid.ablations.crossing_path import runs as crossing_path
from camid.ablations.crossing_path.drawing import draw
from camid.paper.marker_images import arc_length_mean, time_mean

SETTINGS = {
    "passes": [0.4, 0.75, 1.0, 1.5, 2.0],
    "diameters": [3, 8, 30],
    "thresholds": [0.01, 0.2, 0.5],
    "starting_points": 3,
}


@pytest.fixture(scope="module")
def table(imaging):
    return crossing_path.compute(SETTINGS, {"imaging": imaging})


def test_the_figure_of_eight_has_constant_speed_and_crosses_in_the_centre(imaging):
    path = crossing_path.figure_of_eight(imaging, 1.0, 1)[0]
    time = np.linspace(0.0, imaging["exposure"], 2001)
    steps = np.linalg.norm(np.diff(path(time), axis=0), axis=1)
    assert steps.sum() == pytest.approx(np.pi * imaging["path_diameter"], rel=1e-4)
    assert np.ptp(steps) < 1e-3 * steps.mean()
    np.testing.assert_allclose(
        path(np.array([0.25, 0.75]) * imaging["exposure"]), [imaging["path_centre"]] * 2, atol=0.02
    )
    np.testing.assert_allclose(
        arc_length_mean(path, 0.0, 0.3 * imaging["exposure"]),
        time_mean(path, 0.0, 0.3 * imaging["exposure"]),
        atol=1e-3,
    )


def test_a_low_threshold_counts_a_retraced_circle_once(table):
    """The pixels of one and a half turns are the whole ring, whose centre is the circle's, R·sinc(1.5) from (1)."""
    chosen = (table["path"] == "circle") & (table["passes"] == 1.5) & (table["threshold"] == 0.01)
    distance = table[chosen & (table["diameter"] == 3)]["distance"].item()
    assert distance == pytest.approx(80.0 * abs(np.sinc(1.5)), rel=0.1)


def test_whole_passes_are_symmetric(table):
    assert table.loc[table["passes"].isin([1.0, 2.0]), "distance"].max() < 0.2


def test_the_grey_level_centroid_counts_each_time(table):
    assert table.loc[table["centroid"] == "grey-level", "distance"].max() < 0.005


def test_the_conclusion_follows_the_numbers(table):
    value = {name: number for name, (number, _) in crossing_path.quantities(table).items()}
    changed = {**value, "largest_eight_before_crossing": 1.5, "largest_eight_crossing_once": 1.4}
    changed |= {"largest_circle_before_a_turn": 1.9, "largest_circle_covering_itself": 8.0, "largest_grey_level": 0.0}
    sentence = crossing_path.conclusion(changed)
    assert "nothing that shows" in sentence
    assert "does not need A2" in sentence
    other = crossing_path.conclusion({**changed, "largest_eight_crossing_once": 9.0, "largest_grey_level": 0.3})
    assert "nothing that shows" not in other
    assert "0.30 px" in other


def test_the_figure_and_its_numbers(table):
    figure, numbers = draw(table)
    assert len(figure.axes) == 2
    assert len(numbers) == len(table)
