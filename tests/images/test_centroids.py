"""Measurement of the marker's position: known positions, plain numpy counterparts, noise and the time mean."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from scipy.ndimage import convolve

from camid.images.centroids import (
    MarkerNotFound,
    RegionOfInterest,
    gradient_centroid,
    gradient_image,
    grey_level_centroid,
)
from camid.images.forming import FrameFormat, Marker, circular_path, expose, quantise

EXPOSURE = 0.02
POSITION = (201.3, 97.85)
MEASURES = {"gradient": lambda image, **k: gradient_centroid(image, 0.5, **k), "grey level": grey_level_centroid}


def disk(position=POSITION, marker=Marker(), frame=FrameFormat()):  # noqa: B008 - both are immutable
    return expose(lambda time: np.tile(position, (len(time), 1)), 0.0, EXPOSURE, marker, frame)


def textbook_gradient(image):
    smooth, slope = np.array([1.0, 2.0, 1.0]) / 4.0, np.array([1.0, 0.0, -1.0]) / 2.0
    horizontal = convolve(image.astype(float), np.outer(smooth, slope), mode="mirror")
    vertical = convolve(image.astype(float), np.outer(slope, smooth), mode="mirror")
    return np.hypot(horizontal, vertical)


def centre_of_mass(weights):
    rows, columns = np.indices(weights.shape)
    return (columns * weights).sum() / weights.sum(), (rows * weights).sum() / weights.sum()


@pytest.fixture(scope="module")
def noisy():
    return quantise(disk(frame=FrameFormat(background=20.0)), 8, 2.0, np.random.default_rng(3))


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.int32, np.float32, np.float64])
def test_gradient_is_the_textbook_sobel_in_grey_levels_per_pixel(noisy, kind):
    gradient = gradient_image(noisy.astype(kind))
    assert gradient.dtype == np.float32
    np.testing.assert_allclose(gradient, textbook_gradient(noisy), rtol=1e-5, atol=1e-4)


def test_gradient_of_a_ramp_is_its_slope_and_of_an_edge_half_its_height():
    columns = np.tile(np.arange(20.0), (10, 1))
    np.testing.assert_allclose(gradient_image(3.0 * columns)[:, 1:-1], 3.0)
    np.testing.assert_allclose(gradient_image(100.0 * (columns > 9.5))[:, 8:12], [[0.0, 50.0, 50.0, 0.0]] * 10)


@pytest.mark.parametrize(("threshold", "relative"), [(0.2, True), (0.5, True), (0.9, True), (6.0, False), (0.0, False)])
def test_gradient_centroid_counts_each_selected_pixel_once(noisy, threshold, relative):
    gradient = textbook_gradient(noisy)
    expected = centre_of_mass(gradient > threshold * (gradient.max() if relative else 1.0) + 1e-6)
    assert gradient_centroid(noisy, threshold, relative=relative) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("background", [None, 0.0, 19.5, -3.0])
@pytest.mark.parametrize("threshold", [0.0, 1.0, 7.3])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float64])
def test_grey_level_centroid_is_the_centre_of_mass_above_the_background(noisy, kind, threshold, background):
    region = RegionOfInterest.around(POSITION, 40, 50)
    view = noisy[region.top : region.top + 40, region.left : region.left + 50].astype(float)
    border = np.ones(view.shape, bool)
    border[1:-1, 1:-1] = False
    level = np.median(view[border]) if background is None else background
    weights = view - level
    if threshold > 0.0:
        weights[weights <= threshold] = 0.0
    x, y = centre_of_mass(weights)
    found = grey_level_centroid(noisy.astype(kind), background, threshold, region)
    assert found == pytest.approx((x + region.left, y + region.top), abs=1e-6)


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize("position", [(210.0, 150.0), (17.6, 18.2), (401.9, 280.7)])
def test_position_of_a_still_disk(measure, position):
    # What the pixel grid costs (assumption A3); by symmetry nothing at a pixel's centre.
    tolerance = 1e-9 if position == (210.0, 150.0) else {"grey level": 1e-3, "gradient": 0.3}[measure]
    assert MEASURES[measure](disk(position)) == pytest.approx(position, abs=tolerance)


@pytest.mark.parametrize("measure", MEASURES)
def test_a_region_hides_a_second_marker_and_keeps_the_coordinates(measure):
    two = np.maximum(disk((100.0, 80.0)), disk((300.0, 200.0)))
    region = RegionOfInterest.around((300.0, 200.0), 65)
    assert MEASURES[measure](two, region=region) == pytest.approx((300.0, 200.0), abs=1e-6)
    assert MEASURES[measure](two)[0] < 250.0


@pytest.mark.parametrize("measure", MEASURES)
def test_colour_component_or_mean(measure):
    image = quantise(np.stack([disk((50.0, 60.0)), disk((80.0, 90.0)), disk((50.0, 60.0))], axis=-1))
    find = MEASURES[measure]
    assert find(image, component=0) == pytest.approx((50.0, 60.0), abs=1e-6)
    assert find(image, component=1) == pytest.approx((80.0, 90.0), abs=1e-6)
    assert find(image) == pytest.approx(find(image.astype(float).mean(axis=2)), abs=1e-3)
    with pytest.raises(ValueError, match="component"):
        find(image, component=3)
    with pytest.raises(ValueError, match="component"):
        find(image[:, :, 0], component=0)


def test_noise_of_two_grey_levels_costs_a_fiftieth_of_a_pixel():
    # 200 + 20 grey levels do not saturate, which would bias the position.
    clean, generator = disk(marker=Marker(30.0, 200.0), frame=FrameFormat(background=20.0)), np.random.default_rng(8)
    region = RegionOfInterest.around(POSITION, 64)
    images = [quantise(clean, 8, 2.0, generator) for _ in range(200)]
    plain = np.array([grey_level_centroid(image, threshold=0.0, region=region) for image in images]) - POSITION
    assert plain.std(axis=0).max() < 0.02
    assert np.abs(plain.mean(axis=0)).max() < 0.005
    # With a threshold the whole frame does as well, which it cannot without.
    clipped = np.array([grey_level_centroid(image, threshold=10.0) for image in images]) - POSITION
    assert clipped.std(axis=0).max() < 0.01
    assert np.array([grey_level_centroid(image, 20.0, 0.0) for image in images]).std(axis=0).max() > 0.2


@pytest.mark.parametrize("background", [0.0, 2.5, 20.0])
@pytest.mark.parametrize("side", [48, 64, None])
def test_default_threshold_follows_the_noise(background, side):
    """Noise clipped at black is no longer centred on the background, and would draw the centroid to the middle."""
    frame = FrameFormat(background=background)
    clean, generator = disk(marker=Marker(30.0, 200.0), frame=frame), np.random.default_rng(9)
    region = None if side is None else RegionOfInterest.around((POSITION[0] + 4.0, POSITION[1] - 3.0), side)
    images = [quantise(clean, 8, 2.0, generator) for _ in range(60)]
    found = np.array([grey_level_centroid(image, region=region) for image in images]) - POSITION
    assert np.sqrt(np.mean(found**2, axis=0)).max() < 0.02
    assert grey_level_centroid(clean, region=region) == grey_level_centroid(clean, threshold=0.0, region=region)


@pytest.mark.parametrize("frequency", [1.0, 5.0, 12.0, 24.0])
def test_grey_level_centroid_is_the_time_mean_and_the_gradient_centroid_is_not(frequency):
    half_angle = np.pi * frequency * EXPOSURE
    angles = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False) + 0.1
    grey, gradient = [], []
    for angle in angles:
        # Paper equations (4) and (5) on a circle: the radius shrinks by sin(x)/x.
        mean = np.array([210.0, 150.0]) + 80.0 * np.sin(half_angle) / half_angle * np.array(
            [np.cos(angle), np.sin(angle)]
        )
        path = circular_path((210.0, 150.0), 160.0, frequency, angle - half_angle)
        image = expose(path, 0.0, EXPOSURE, Marker(), FrameFormat())
        grey.append(np.hypot(*(grey_level_centroid(image) - mean)))
        gradient.append(np.hypot(*(gradient_centroid(quantise(image), 0.2) - mean)))
    assert max(grey) < 1e-3
    assert 0.02 < np.sqrt(np.mean(np.square(gradient))) < 2.0


def test_buffers_do_not_leak_from_one_image_or_thread_to_another():
    positions = [(60.0 + 3.7 * k, 50.0 + 1.9 * k) for k in range(40)]
    images = [quantise(disk(position)) for position in positions]
    regions = [RegionOfInterest.around(position, 50 + 2 * (k % 3)) for k, position in enumerate(positions)]
    alone = [gradient_centroid(image, 0.5, region) for image, region in zip(images, regions, strict=True)]
    kept = gradient_image(images[0])
    before = kept.copy()
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda k: gradient_centroid(images[k % 40], 0.5, regions[k % 40]), range(400)))
    assert together == alone * 10
    assert np.array_equal(kept, before)


def test_background_is_the_median_of_all_four_borders():
    image = np.full((11, 11), 90.0)
    image[0], image[-1], image[1:-1, 0], image[1:-1, -1] = 10.0, 30.0, 30.0, 10.0
    image[0, 5] = image[-1, 5] = 20.0  # between as many darker as brighter border pixels
    weights = image - 20.0
    assert grey_level_centroid(image, threshold=0.0) == pytest.approx(centre_of_mass(weights), abs=1e-9)


def test_images_are_left_as_they_are(noisy):
    before = noisy.copy()
    gradient_centroid(noisy, 0.5)
    grey_level_centroid(noisy, threshold=5.0)
    assert np.array_equal(noisy, before)


def test_region_around_and_clip():
    assert RegionOfInterest.around((10.0, 20.0), 5) == RegionOfInterest(top=18, left=8, height=5, width=5)
    assert RegionOfInterest.around((10.5, 20.0), 7, 4) == RegionOfInterest(top=17, left=9, height=7, width=4)
    assert RegionOfInterest(-5, 410, 20, 30).clip(300, 420) == RegionOfInterest(0, 410, 15, 10)
    inside = RegionOfInterest(0, 0, 300, 420)
    assert inside.clip(300, 420) == inside
    for outside in (RegionOfInterest(298, 0, 10, 10), RegionOfInterest(0, -8, 10, 10), RegionOfInterest(500, 0, 9, 9)):
        with pytest.raises(ValueError, match="in common"):
            outside.clip(300, 420)
    with pytest.raises(ValueError, match="at least 3"):
        RegionOfInterest(0, 0, 2, 10)


@pytest.mark.parametrize(
    "measure",
    [
        lambda image: gradient_centroid(image, 0.5),
        lambda image: gradient_centroid(image, 1.0, relative=False),
        grey_level_centroid,
        lambda image: grey_level_centroid(image, threshold=5.0),
        lambda image: grey_level_centroid(image, background=50.0, threshold=5.0),
    ],
)
@pytest.mark.parametrize("level", [0.0, 0.1, 33.0])
def test_no_marker_is_said_so(measure, level):
    with pytest.raises(MarkerNotFound):
        measure(np.full((40, 50), level))
    assert issubclass(MarkerNotFound, ValueError)


@pytest.mark.parametrize(
    ("measure", "message"),
    [
        (lambda image: gradient_centroid(image, 1.0), "threshold"),
        (lambda image: gradient_centroid(image, 0.0), "threshold"),
        (lambda image: gradient_centroid(image, -1.0, relative=False), "threshold"),
        (lambda image: grey_level_centroid(image, threshold=-1.0), "threshold"),
        (lambda image: grey_level_centroid(image[0]), "shape"),
        (lambda image: gradient_image(image[:2]), "shape"),
        (lambda image: gradient_image(np.stack([image, image], axis=-1)), "shape"),
    ],
)
def test_what_cannot_be_measured_is_refused(measure, message):
    with pytest.raises(ValueError, match=message) as caught:
        measure(disk())
    assert not isinstance(caught.value, MarkerNotFound)
