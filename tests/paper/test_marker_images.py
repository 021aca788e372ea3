import numpy as np
import pytest
from ruamel.yaml import YAML

from camid.paper import marker_images as images
from camid.paper.fig1_marker_image.runs import fast_marker_image
from camid.paper.fig3_marker_trajectory.runs import signal_to_noise_decibels, slow_marker_trajectory
from tests.support import ROOT


@pytest.fixture(scope="module")
def imaging():
    return YAML(typ="safe").load(ROOT / "config/config.yaml")["imaging"]


def test_means_on_the_circle_against_the_formula(imaging):
    """The mean of an arc of angle a on a circle lies at the radius times sin(a/2)/(a/2)."""
    path = images.configured_path(imaging, 24.0)
    angle = 2.0 * np.pi * 24.0 * 0.02
    expected = 80.0 * np.sin(angle / 2.0) / (angle / 2.0)
    for mean in (images.time_mean, images.arc_length_mean):
        assert np.linalg.norm(mean(path, 0.0, 0.02) - imaging["path_centre"]) == pytest.approx(expected, abs=1e-5)


def test_arc_length_mean_weighs_by_speed():
    def accelerated(time):
        return np.stack([np.asarray(time) ** 2, np.zeros_like(time)], axis=-1)

    assert images.time_mean(accelerated, 0.0, 1.0)[0] == pytest.approx(1.0 / 3.0, abs=1e-6)
    assert images.arc_length_mean(accelerated, 0.0, 1.0)[0] == pytest.approx(0.5, abs=1e-6)


def test_fast_image_and_its_measurement(imaging):
    content = fast_marker_image(imaging)
    assert content["image"].shape == (300, 420, 3)
    assert np.linalg.norm(content["centroid"] - content["time_mean"]) < 3.0
    assert content["selected"].sum() > 1000


def test_slow_trajectory_has_a_high_signal_to_noise_ratio(imaging):
    table = slow_marker_trajectory(imaging)
    assert len(table) == 10
    assert signal_to_noise_decibels(table) > 35.0
    assert signal_to_noise_decibels(table, "grey_level") > 80.0
