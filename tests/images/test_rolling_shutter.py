"""Images with a rolling shutter against rows of images with a global one, and against geometry."""

from __future__ import annotations

import numpy as np
import pytest

from camid.images.centroids import grey_level_centroid
from camid.images.forming import FrameFormat, Marker, circular_path, expose
from camid.images.rolling_shutter import expose_rolling, time_in_row

LINE_TIME = 0.02 / 300
WHITE = Marker(intensity=1.0)
CIRCLE = circular_path((210.3, 150.7), 160.0, 12.0, 1.0)
SMALL = FrameFormat(120, 140, background=3.0)


def straight(start, velocity):
    return lambda time: np.asarray(start, float) + np.multiply.outer(time, np.asarray(velocity, float))


def test_without_a_line_time_the_shutter_is_global():
    rolling = expose_rolling(CIRCLE, 0.1, 0.02, 0.0, WHITE, FrameFormat())
    np.testing.assert_allclose(rolling, expose(CIRCLE, 0.1, 0.02, WHITE, FrameFormat()), rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("line_time", [LINE_TIME, -LINE_TIME])
def test_every_row_is_that_of_a_global_shutter_at_its_own_time(line_time):
    rolling = expose_rolling(CIRCLE, 0.0, 0.005, line_time, WHITE, FrameFormat())
    seen = np.flatnonzero(rolling.any(axis=1))
    assert seen.size > 20
    for row in (0, 299, *seen[::6], seen[0] - 1, seen[-1] + 1):
        own = expose(CIRCLE, row * line_time, 0.005, WHITE, FrameFormat())[row]
        np.testing.assert_allclose(rolling[row], own, rtol=0.0, atol=1e-9)


def test_colour_components_are_formed_independently():
    path = straight((60.0, 50.0), (1000.0, 500.0))
    colour = expose_rolling(path, 0.0, 0.005, LINE_TIME, Marker(20.0, (250.0, 0.0, 40.0)), SMALL)
    alone = expose_rolling(path, 0.0, 0.005, LINE_TIME, Marker(20.0, 40.0), SMALL)
    assert colour.shape == (120, 140, 3)
    np.testing.assert_allclose(colour[:, :, 2], alone, rtol=0.0, atol=1e-9)
    assert np.all(colour[:, :, 1] == 3.0)


def test_a_marker_that_runs_with_the_shutter_is_stretched():
    """At half a row in a line time every row shows the disk a half row further: twice as long, twice the light."""
    speed = 0.5 / LINE_TIME
    path = straight((60.0, 20.0), (0.0, speed))
    image = expose_rolling(path, 0.0, 1e-4, LINE_TIME, Marker(20.0, 1.0), FrameFormat(120, 140))
    assert image.sum() == pytest.approx(2.0 * np.pi * 100.0, rel=0.01)
    assert np.count_nonzero(image.max(axis=1) > 0.5) == pytest.approx(40, abs=2)
    # The middle of the exposure of the row that the centre is then in: y = 20 + v (λy + τ/2).
    assert grey_level_centroid(image.astype(np.float32), 0.0)[1] == pytest.approx(2.0 * (20.0 + speed * 5e-5), abs=0.05)


def test_a_marker_that_runs_across_is_sheared():
    path = straight((30.0, 50.0), (6000.0, 0.0))
    image = expose_rolling(path, 0.0, 1e-4, LINE_TIME, Marker(30.0, 1.0), FrameFormat(120, 140))
    columns = np.arange(140)
    rows = np.arange(40, 61)
    middles = image[rows] @ columns / image[rows].sum(axis=1)
    np.testing.assert_allclose(middles, 30.0 + 6000.0 * (LINE_TIME * rows + 5e-5), atol=0.02)


def test_time_in_row_solves_its_equation():
    for start, line_time in ((0.0, LINE_TIME), (0.3, -LINE_TIME), (0.1, 0.0)):
        time = time_in_row(CIRCLE, start, line_time)
        assert time == pytest.approx(start + line_time * CIRCLE(np.array([time]))[0, 1], abs=1e-12)


def test_a_marker_as_fast_as_the_shutter_has_no_single_time():
    with pytest.raises(ValueError, match="line time"):
        time_in_row(straight((0.0, 10.0), (0.0, 1.5 / LINE_TIME)), 0.0, LINE_TIME)


@pytest.mark.parametrize(
    ("path", "line_time", "message"),
    [
        (CIRCLE, np.nan, "line time"),
        (lambda time: time, LINE_TIME, "shape"),
        (straight((np.nan, 0.0), (1.0, 0.0)), LINE_TIME, "finite"),
    ],
)
def test_what_makes_no_image_is_refused(path, line_time, message):
    with pytest.raises(ValueError, match=message):
        expose_rolling(path, 0.0, 0.01, line_time, WHITE, SMALL)
