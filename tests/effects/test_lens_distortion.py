"""A lens whose centre does not show the place where the plant rests, as cameras usually stand."""

import numpy as np
import pandas as pd
import pytest
from scipy.signal import cont2discrete

import camid
from camid.effects.extent import Extent
from camid.effects.lens_distortion import (
    LensDistortion,
    LensDistortionOffCentre,
    LensDistortionOfFourthOrder,
    LensDistortionOfFourthOrderOffCentre,
)
from camid.effects.perspective import Perspective
from tests.support.mass_on_spring import PERIOD, PLANT, command, simulation


@pytest.mark.parametrize("centre", [-1.3, 0.4])
def test_the_image_is_that_of_the_way_from_the_centre(centre):
    position = np.linspace(-2.0, 2.0, 9)
    way = position - centre
    cases = (
        (LensDistortionOffCentre(k1=-0.05, centre=centre), way - 0.05 * way**3),
        (LensDistortionOfFourthOrderOffCentre(k1=-0.05, k2=0.003, centre=centre), way - 0.05 * way**3 + 0.003 * way**5),
    )
    for law, image in cases:
        seen = law.distorted(position)
        assert np.ptp(seen - image) < 1e-12
        assert seen[4] == 0.0  # at the plant's zero the sensor reads its offset


def test_about_the_plants_zero_it_is_the_plain_law():
    position = np.linspace(-2.0, 2.0, 9)
    plain, fourth = LensDistortion(k1=0.1), LensDistortionOfFourthOrder(k1=0.1, k2=-0.02)
    np.testing.assert_allclose(
        LensDistortionOffCentre(k1=0.1, centre=0.0).distorted(position), plain.distorted(position), atol=1e-15
    )
    np.testing.assert_allclose(
        LensDistortionOfFourthOrderOffCentre(k1=0.1, k2=-0.02, centre=0.0).distorted(position),
        fourth.distorted(position),
        atol=1e-15,
    )
    assert type(LensDistortionOffCentre(k1=0.1, centre=2.0).simplified()) is LensDistortion
    assert type(LensDistortion.with_keys(["k1", "centre"])(k1=0.1, centre=1.0)) is LensDistortionOffCentre


def test_its_centre_is_where_a_camera_that_films_the_motion_can_have_it():
    assert LensDistortionOffCentre(k1=0.1, centre=0.7).is_plausible(Extent(1.0, 10.0))
    assert not LensDistortionOfFourthOrderOffCentre(k1=0.1, k2=0.1, centre=-0.8).is_plausible(Extent(1.0, 10.0))


def filmed(image, noise, count=1500):
    """Recording of the mass on its spring by an image of its position, by another simulation."""
    system = np.array([[0.0, 1.0], [-PLANT.denominator[2], -PLANT.denominator[1]]])
    step, push, *_ = cont2discrete(
        (system, np.array([[0.0], [PLANT.numerator[0]]]), np.eye(2), np.zeros((2, 1))), PERIOD
    )
    state, positions = np.zeros(2), []
    signal = command(count)
    for level in signal:
        positions.append(state[0])
        state = step @ state + push[:, 0] * level
    random = np.random.default_rng(5)
    reading = image(np.array(positions)) + noise * random.standard_normal(count)
    return pd.DataFrame({"t": PERIOD * np.arange(count), "u": signal, "y": reading})


@pytest.mark.parametrize(("k1", "centre"), [pytest.param(-0.03, 0.8, marks=pytest.mark.slow), (0.04, -1.6)])
def test_it_is_found_by_way_of_an_oblique_view(k1, centre):
    recording = filmed(lambda y: (y - centre) * (1.0 + k1 * (y - centre) ** 2) + 3.0, noise=0.002)
    believed = simulation(sensor={"column": "y", "kind": "instant"})
    found = camid.diagnose(recording, believed)
    assert [f.identifier for f in found.findings] == ["lens-distortion"]
    for name, truth in (("k1", k1), ("centre", centre)):
        estimate = found.findings[0].parameters[name]
        assert abs(estimate.value - truth) < 4.0 * estimate.standard_deviation < 0.3 * abs(truth)


def test_an_oblique_view_is_told_from_it():
    recording = filmed(lambda y: y / (1.0 + 0.06 * y) + 3.0, noise=0.002)
    found = camid.diagnose(recording, simulation(sensor={"column": "y", "kind": "instant"}))
    assert found.findings[0].identifier == "perspective"
    assert found.findings[0].parameters["obliqueness"].value == pytest.approx(0.06, rel=0.02)
    (start, other) = Perspective(obliqueness=0.06).relatives(type("Seen", (), {"largest": lambda *_: 2.0})())
    for law in (start, other):  # the same square of the position
        assert -3.0 * law.values["k1"] * law.values["centre"] == pytest.approx(-0.06)
