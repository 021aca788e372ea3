"""The two centroids in clean and spoilt images."""

from __future__ import annotations

import numpy as np
import pytest

from camid.ablations.centroids import runs as centroids
from camid.ablations.centroids.drawing import draw

SETTINGS = {
    "frequencies": [1, 5, 24],
    "threshold": 0.2,
    "fixed_threshold": 3.0,
    "noise": 2.0,
    "black_level": 10.0,
    "light": 20.0,
    "gains": [2, 8],
    "margin": 15,
    "starting_angles": 3,
}


@pytest.fixture(scope="module")
def table(imaging):
    return centroids.compute(SETTINGS, {"imaging": imaging, "seed": 2008})


def error(table, condition, centroid, frequency):
    chosen = (table["condition"] == condition) & (table["centroid"] == centroid) & (table["frequency"] == frequency)
    return table.loc[chosen, "error"].item()


def test_an_unspoilt_grey_level_centroid_is_the_time_mean(table):
    for frequency in SETTINGS["frequencies"]:
        assert error(table, "floating point", "grey-level", frequency) < 0.001


def test_peak_is_the_share_of_the_exposure_that_a_pixel_is_covered(table, imaging):
    """On the path a pixel sees the marker for diameter / speed; 8 × full scale reaches it just at 24 Hz."""
    speed = np.pi * imaging["path_diameter"] * 24.0
    expected = imaging["marker_diameter"] / speed / imaging["exposure"]
    peaks = table[table["frequency"] == 24.0].set_index("condition")["peak"]
    assert peaks["8 bit"].iloc[0] == pytest.approx(expected, rel=0.01)
    assert peaks["8 × full scale"].iloc[0] == pytest.approx(8.0 * expected, rel=0.01)


def test_saturation_spoils_only_what_reaches_full_scale(table):
    assert error(table, "8 × full scale", "grey-level", 24.0) < 0.01
    assert error(table, "8 × full scale", "grey-level", 5.0) > 0.2


def test_uniform_light_pulls_towards_the_middle_of_the_region_until_it_is_removed(table):
    assert error(table, "uniform light", "grey-level", 24.0) > 5.0
    assert error(table, "uniform light", "grey-level, border removed", 24.0) < 0.02


def test_the_conclusion_follows_the_numbers(table):
    value = {name: number for name, (number, _) in centroids.quantities(table).items()}
    sentence = centroids.conclusion(value)
    assert "saturation (" in sentence
    assert "at every speed" in sentence
    harmless = {"grey_level_noise": 0.01, "grey_level_light_left": 0.02, "grey_level_ramp": 0.0}
    other = centroids.conclusion({**value, **harmless, "grey_level_largest_saturated": 0.03, "grey_level_8_bit": 0.9})
    assert "Nothing tried here" in other
    assert "0.90 px" in other


def test_the_figure_and_its_numbers(table):
    figure, numbers = draw(table)
    assert len(figure.axes) == 4
    assert len(numbers) == len(table)
