"""Coarse, shallow and noisy images, against the theory of the centroid's noise."""

from __future__ import annotations

import numpy as np
import pytest

from camid.ablations.image_quality import runs as image_quality
from camid.ablations.image_quality.drawing import draw

SETTINGS = {
    "frequency": 24,
    "threshold": 0.2,
    "diameters": [30, 5],
    "bit_depths": [4, 8],
    "noises": [0, 2],
    "margin": 15,
    "images": 4,
    "regions": [48, 96],
    "region_noise": 2.0,
    "region_images": 200,
}


@pytest.fixture(scope="module")
def table(imaging):
    return image_quality.compute(SETTINGS, {"imaging": imaging, "seed": 2008})


def error(table, varied, setting, motion, centroid):
    chosen = (table["varied"] == varied) & (table["setting"] == setting)
    chosen &= (table["motion"] == motion) & (table["centroid"] == centroid)
    return table.loc[chosen, "error"].item()


def test_noise_without_threshold_grows_with_the_area(table, imaging):
    """White noise σ in N × N pixels moves each coordinate of the centre of mass M by σN²/(√12 M)."""
    mass = np.pi * (imaging["marker_diameter"] / 2) ** 2 * (255.0 - 20.0)
    for side in (48, 96):
        expected = np.sqrt(2.0) * 2.0 * side**2 / np.sqrt(12.0) / mass
        assert error(table, "region", side, "static", "grey-level") == pytest.approx(expected, rel=0.25)
        assert error(table, "region", side, "static", "grey-level, threshold") < 0.01


def test_the_gradient_centroid_is_that_of_plain_opencv(table):
    for side in (48, 96):
        plain = error(table, "region", side, "static", "gradient, plain OpenCV")
        assert error(table, "region", side, "static", "gradient") == pytest.approx(plain, rel=1e-6)


def test_errors_of_a_coarse_camera_are_in_pixels_of_the_fine_one(table):
    """A whole-pixel count is off by a like number of pixels at both resolutions, six times as many fine ones."""
    fine, coarse = (error(table, "resolution", d, "static", "gradient") for d in (30, 5))
    assert 2.0 < coarse / fine < 10.0
    assert error(table, "resolution", 30, "moving", "grey-level") < 0.001


def test_fewer_bits_hurt_the_dim_image_of_a_moving_marker(table):
    assert error(table, "bit depth", 4, "moving", "grey-level") > 10 * error(
        table, "bit depth", 8, "moving", "grey-level"
    )


def test_the_conclusion_follows_the_numbers(table):
    value = {name: number for name, (number, _) in image_quality.quantities(table).items()}
    steady = {**value, "gradient_over_plain_opencv": 1.0, "grey_level_border_median_worst": 3.0}
    steady["grey_level_black_known_worst"] = 0.2
    sentence = image_quality.conclusion(steady)
    assert "(as with plain OpenCV calls)" in sentence
    assert "can cost 3.0 px" in sentence
    other = image_quality.conclusion(
        {**steady, "gradient_over_plain_opencv": 1.5, "grey_level_border_median_worst": 0.2}
    )
    assert "(more than with plain OpenCV calls)" in other
    assert "can cost" not in other


def test_the_figure_and_its_numbers(table):
    figure, numbers = draw(table)
    assert len(figure.axes) == 4
    assert len(numbers) == len(table)
