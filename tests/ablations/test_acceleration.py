"""Motions whose speed changes within the exposure, against the integrals worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from camid.ablations.acceleration import runs as acceleration
from camid.ablations.acceleration.drawing import draw

SETTINGS = {
    "length": 120,
    "diameters": [8, 30],
    "thresholds": [0.05, 0.2, 0.5],
    "relative_changes": [0, 1, 2],
    "turning_instants": [0, 0.5],
    "rests": [0, 0.25, 0.5],
    "directions": 3,
}


@pytest.fixture(scope="module")
def table(imaging):
    return acceleration.compute(SETTINGS, {"imaging": imaging})


def ahead(table, motion, setting, position, threshold=0.0, diameter=8.0):
    chosen = (table["motion"] == motion) & (table["setting"] == setting) & (table["position"] == position)
    chosen &= (table["threshold"] == threshold) & (table["diameter"] == diameter)
    return table.loc[chosen, "ahead"].item()


@pytest.mark.parametrize(
    ("motion", "setting"),
    [("acceleration", 0.7), ("acceleration", 2.0), ("turning point", 0.3), ("stop", 0.25), ("stop", 0.0)],
)
def test_every_motion_covers_the_length(motion, setting):
    places = acceleration.MOTIONS[motion](setting, 120.0)(np.linspace(0.0, 1.0, 100_001))
    assert np.abs(np.diff(places)).sum() == pytest.approx(120.0, rel=1e-6)


def test_arc_length_mean_minus_time_mean(table):
    """L·change/12 without a turn; a rest at the end takes the time mean to rest·L/2, and (2) stays in the middle."""
    for change in (0, 1, 2):
        assert ahead(table, "acceleration", change, "arc-length mean") == pytest.approx(10.0 * change, abs=1e-3)
    assert ahead(table, "stop", 0.25, "arc-length mean") == pytest.approx(-15.0, abs=1e-2)
    # There and back over 60 px with constant acceleration: 30 px from the turning point against a third of 60 px.
    assert ahead(table, "turning point", 0.5, "arc-length mean") == pytest.approx(10.0, abs=1e-2)


def test_a_threshold_that_drops_the_moving_part_leaves_the_place_of_rest(table):
    assert ahead(table, "stop", 0.5, "gradient", 0.5) == pytest.approx(30.0, abs=0.3)


def test_the_grey_level_centroid_is_the_time_mean(table):
    assert table.loc[table["position"] == "grey-level", "ahead"].abs().max() < 0.002


def test_the_conclusion_follows_the_numbers(table):
    value = {name: number for name, (number, _) in acceleration.quantities(table).items()}
    sentence = acceleration.conclusion(value)
    assert "neither (2) nor the time mean" in sentence
    assert "does not need A4" in sentence
    other = acceleration.conclusion({**value, "gradient_from_rest_threshold_0.2": 19.0, "largest_grey_level": 0.4})
    assert "follows (2)" in other
    assert "0.40 px" in other


def test_where_a_limit_is_first_reached():
    settings = np.array([0.0, 1.0, 2.0])
    assert acceleration._first_reaching(settings, np.array([0.0, 2.0, 0.0]), 1.0) == pytest.approx(0.5)
    assert acceleration._first_reaching(settings, np.array([0.0, 0.1, 0.2]), 1.0) == 2.0


def test_the_figure_and_its_numbers(table):
    figure, numbers = draw(table)
    assert len(figure.axes) == 6
    assert len(numbers) == len(table)
