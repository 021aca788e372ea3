"""Images formed by exposure against a brute-force reference, and the properties they must have."""

from __future__ import annotations

import numpy as np
import pytest

from camid.images.forming import FrameFormat, Marker, circular_path, expose, quantise

EXPOSURE = 0.02
WHITE = Marker(intensity=1.0)


def straight(start, velocity):
    return lambda time: np.asarray(start, float) + np.multiply.outer(time, np.asarray(velocity, float))


def sinusoidal(time):
    # Stands still at 40 % of the exposure.
    return np.stack((200.3 + 80.0 * np.cos(np.pi * (time - 0.008) / EXPOSURE), np.full_like(time, 150.2)), axis=-1)


def start_and_stop(time):
    # Still, then 60 px within about a tenth of the exposure, then still again.
    return np.stack((200.0 + 30.0 * np.tanh((time - 0.011) / 5e-4), 150.0 + 10.0 * np.tanh((time - 0.011) / 5e-4)), -1)


def vibrating(time):
    # Fifty passes over the same pixels, whose errors add up.
    return np.stack((200.5 + 0.5 * np.sin(2.0 * np.pi * 2500.0 * time), np.full_like(time, 150.0)), axis=-1)


PATHS = {
    "paper's circle at 24 Hz": circular_path((210.0, 150.0), 160.0, 24.0),
    "circle at 24 Hz, off the grid": circular_path((210.3, 150.7), 160.0, 24.0, 1.0),
    "two turns": circular_path((210.0, 150.0), 160.0, 100.0),
    "horizontal, constant speed": straight((100.5, 120.5), (5000.0, 0.0)),
    "vertical, edges on pixel borders": straight((100.5, 60.5), (0.0, 2500.0)),
    "diagonal": straight((100.0, 60.0), (3000.0, 3000.0)),
    "one pixel": straight((100.5, 60.5), (50.0, 0.0)),
    "very slow": straight((100.5, 60.5), (0.5, 0.2)),
    "sinusoidal with a stop": sinusoidal,
    "start and stop": start_and_stop,
    "vibration": vibrating,
    "leaves at the left": straight((40.0, 30.0), (-4000.0, -2500.0)),
    "leaves at the right and below": straight((380.0, 270.0), (4000.0, 2500.0)),
    "enters and leaves": circular_path((210.0, -60.0), 160.0, 24.0, 0.6),
}


def chord_reference(path, radius, shape, instants, lines):
    """Mean coverage from dense instants, each disk cut into chords by ``lines`` scan lines per pixel row.

    The lines move by the golden ratio of their spacing from one instant to the next, so that their error averages out.
    """
    height, width = shape
    centres = path(EXPOSURE * (np.arange(instants) + 0.5) / instants)
    shift = (np.arange(instants) * 0.6180339887498949) % 1.0
    offsets = np.arange(-int((radius + 1) * lines), int((radius + 1) * lines) + 1)
    ends = np.zeros((height, width + 1))
    for part in np.array_split(np.arange(instants), max(1, instants * offsets.size // 1_000_000)):
        centre = centres[part]
        line = (np.floor(centre[:, 1:] * lines) + offsets + shift[part, None]) / lines
        square = radius**2 - (line - centre[:, 1:]) ** 2
        row = np.floor(line + 0.5).astype(int)
        used = (square > 0.0) & (row >= 0) & (row < height)
        middle = np.broadcast_to(centre[:, :1], line.shape)[used]
        for side in (-1.0, 1.0):
            x = np.clip(middle + side * np.sqrt(square[used]) + 0.5, 0.0, width)
            column = np.minimum(x.astype(int), width - 1)
            for cell, share in ((column, 1.0 - (x - column)), (column + 1, x - column)):
                index = row[used] * (width + 1) + cell
                ends -= side * np.bincount(index, share, minlength=ends.size).reshape(ends.shape)
    return np.cumsum(ends, axis=1)[:, :width] / (instants * lines)


@pytest.mark.parametrize("name", PATHS)
def test_every_pixel_is_within_a_thousandth_of_the_reference(name):
    reference = chord_reference(PATHS[name], 15.0, (300, 420), instants=8000, lines=16)
    image = expose(PATHS[name], 0.0, EXPOSURE, WHITE, FrameFormat())
    assert reference.max() > 0.05
    assert np.abs(image - reference).max() < 1e-3


@pytest.mark.parametrize("diameter", [30.0, 7.3, 1.0, 0.4])
@pytest.mark.parametrize("centre", [(20.0, 20.0), (20.5, 19.5), (20.37, 19.81), (0.2, 39.9), (39.6, 3.0)])
def test_still_marker_covers_the_exact_area(diameter, centre):
    path = straight(centre, (0.0, 0.0))
    reference = chord_reference(path, diameter / 2, (40, 40), instants=1, lines=20_000)
    image = expose(path, 0.0, EXPOSURE, Marker(diameter, 1.0), FrameFormat(40, 40))
    assert np.abs(image - reference).max() < 1e-4


def test_area_of_a_border_pixel_by_hand():
    # The disk of radius 10 about (20, 20) covers of pixel (10, 20) what lies under its arc, above y = 10.5.
    image = expose(straight((20.0, 20.0), (0.0, 0.0)), 0.0, EXPOSURE, Marker(20.0, 1.0), FrameFormat(40, 40))
    under_the_arc = 0.5 * np.sqrt(100.0 - 0.25) + 100.0 * np.arcsin(0.05)
    assert image[10, 20] == pytest.approx(under_the_arc - 9.5, abs=1e-13)
    assert image[20, 20] == pytest.approx(1.0, abs=1e-13)
    assert image[8, 20] == 0.0


@pytest.mark.parametrize("name", [name for name in PATHS if "leaves" not in name])
def test_total_intensity_is_that_of_the_disk(name):
    image = expose(PATHS[name], 0.0, EXPOSURE, Marker(30.0, 200.0), FrameFormat())
    assert image.sum() == pytest.approx(np.pi * 15.0**2 * 200.0, rel=1e-12)
    assert image.min() == 0.0


@pytest.mark.parametrize("name", [name for name in PATHS if "leaves" not in name])
def test_centre_of_mass_is_the_time_mean_of_the_path(name):
    image = expose(PATHS[name], 0.0, EXPOSURE, WHITE, FrameFormat())
    time_mean = PATHS[name](EXPOSURE * (np.arange(100_000) + 0.5) / 100_000).mean(axis=0)
    rows, columns = np.indices(image.shape)
    centre = np.array([(columns * image).sum(), (rows * image).sum()]) / image.sum()
    assert np.abs(centre - time_mean).max() < 1e-3


def test_the_exposure_begins_where_it_is_told():
    path, frame = circular_path((210.0, 150.0), 160.0, 24.0), FrameFormat()
    later = circular_path((210.0, 150.0), 160.0, 24.0, phase=2.0 * np.pi * 24.0 * 0.37)
    np.testing.assert_allclose(
        expose(path, 0.37, EXPOSURE, WHITE, frame), expose(later, 0.0, EXPOSURE, WHITE, frame), rtol=0.0, atol=1e-9
    )


def test_still_marker_is_evaluated_once_however_long_the_exposure():
    asked = []

    def path(time):
        asked.append(len(time))
        return np.tile((50.0, 60.0), (len(time), 1))

    expose(path, 0.0, 1000.0, WHITE, FrameFormat())
    assert asked[-1] == 1
    assert sum(asked) < 1000


def test_marker_outside_the_frame_leaves_the_background():
    image = expose(
        straight((-40.0, 50.0), (0.0, 100.0)), 0.0, EXPOSURE, Marker(), FrameFormat(100, 100, background=7.0)
    )
    assert image.shape == (100, 100)
    assert np.all(image == 7.0)


def test_colour_components_are_formed_independently():
    path, intensities = PATHS["paper's circle at 24 Hz"], (250.0, 0.0, 40.0)
    image = expose(path, 0.0, EXPOSURE, Marker(30.0, intensities), FrameFormat(background=3.0))
    assert image.shape == (300, 420, 3)
    for component, intensity in enumerate(intensities):
        alone = expose(path, 0.0, EXPOSURE, Marker(30.0, intensity), FrameFormat(background=3.0))
        np.testing.assert_allclose(image[:, :, component], alone, rtol=0.0, atol=1e-12)


def test_circular_path_turns_from_x_to_y():
    path = circular_path((10.0, 20.0), 8.0, 2.0, phase=np.pi)
    np.testing.assert_allclose(
        path(np.array([0.0, 0.125, 0.25])), [(6.0, 20.0), (10.0, 16.0), (14.0, 20.0)], atol=1e-12
    )


def test_quantise_rounds_and_clips():
    levels = np.array([[-3.0, 0.4, 0.6, 254.7, 300.0, 70_000.0]])
    eight, twelve = quantise(levels), quantise(levels, 12)
    assert eight.dtype == np.uint8
    assert twelve.dtype == np.uint16
    assert eight.tolist() == [[0, 0, 1, 255, 255, 255]]
    assert twelve.tolist() == [[0, 0, 1, 255, 300, 4095]]
    assert quantise(levels, 1).max() == 1
    assert quantise(levels, None).tolist() == levels.tolist()
    assert levels[0, 0] == -3.0


def test_noise_has_the_asked_deviation_and_can_be_drawn_again():
    level = np.full((200, 200), 100.0)
    noisy = quantise(level, None, 2.0, np.random.default_rng(5))
    assert noisy.std() == pytest.approx(2.0, rel=0.02)
    assert noisy.mean() == pytest.approx(100.0, abs=0.05)
    assert quantise(level, 8, 2.0, np.random.default_rng(5)).tolist() == np.rint(noisy).tolist()
    with pytest.raises(ValueError, match="Generator"):
        quantise(level, 8, 2.0)
    with pytest.raises(ValueError, match="noise_std"):
        quantise(level, 8, -1.0, np.random.default_rng(5))


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Marker(0.0), "diameter"),
        (lambda: Marker(30.0, (1.0, 2.0)), "one or three"),  # type: ignore[arg-type]
        (lambda: FrameFormat(0, 10), "sizes"),
        (lambda: FrameFormat(bit_depth=17), "bit depth"),
        (lambda: quantise(np.zeros((2, 2)), 0), "bit_depth"),
        (lambda: expose(PATHS["diagonal"], 0.0, 0.0, WHITE, FrameFormat()), "exposure"),
        (lambda: expose(lambda time: time, 0.0, 1.0, WHITE, FrameFormat()), "shape"),
        (lambda: expose(straight((np.nan, 0.0), (1.0, 0.0)), 0.0, 1.0, WHITE, FrameFormat()), "finite"),
    ],
)
def test_what_makes_no_image_is_refused(build, message):
    with pytest.raises(ValueError, match=message):
        build()
