"""Rolling shutter: the effect of the marker's size, the motion between samples, and what identification makes of it."""

from __future__ import annotations

import numpy as np
import pytest

from camid.ablations.held_motion import HeldMotion
from camid.ablations.rolling_shutter import runs as rolling_shutter
from camid.ablations.rolling_shutter.drawing import draw
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.excitation import pseudo_random_binary_sequence
from camid.chain.plant import second_order
from camid.images.centroids import grey_level_centroid
from camid.images.forming import FrameFormat, Marker
from camid.images.rolling_shutter import expose_rolling, time_in_row
from camid.paper.marker_images import time_mean

PLANT = {"static_gain": 1.5, "natural_frequency": 10.0, "damping": 0.1}
SETTINGS = {
    "image_readout": 0.02,
    "exposures": [0.02, 0.001],
    "frequencies": [1, 5],
    "frequency_of_diameters": 5,
    "diameters": [15, 60],
    "starting_angles": 2,
    "periods": [0.1],
    "readouts": [0, 1],
    "reach": 0.4,
}


def size_effect(diameter, line_time, acceleration):
    """Displacement of the disk's centre of mass by the shutter to leading order, px, shape (2,)."""
    return line_time**2 * diameter**2 / 32.0 * np.asarray(acceleration) * np.array([1.0, 3.0])


@pytest.fixture(scope="module")
def table(configuration):
    shorter = configuration | {"excitation": configuration["excitation"] | {"order": 7}}
    return rolling_shutter.compute(SETTINGS, shorter)


@pytest.mark.parametrize("latency", [0.0, 0.013, 0.05])
def test_the_motion_between_samples_is_that_of_the_chain(latency):
    signal = pseudo_random_binary_sequence(6)
    motion, frames = HeldMotion(PLANT, signal, 0.05), 0.05 * np.arange(signal.size)
    expected = sample(second_order(1.5, 10.0, 0.1), signal, Acquisition(0.05, latency=latency))
    np.testing.assert_allclose(motion.mean(frames - latency - 0.05, frames - latency), expected, atol=1e-12)


def test_the_motion_satisfies_its_differential_equation():
    motion = HeldMotion(PLANT, np.array([1.0, -1.0, 0.5]), 0.2)
    time, step = np.linspace(0.01, 0.19, 50) + 0.2, 1e-4
    before, now, after = (motion.position(time + shift) for shift in (-step, 0.0, step))
    force = (after - 2.0 * now + before) / step**2 + 2.0 * (after - before) / (2.0 * step) + 100.0 * now
    np.testing.assert_allclose(force, -150.0, rtol=1e-4)
    np.testing.assert_allclose(motion.mean(time - step, time + step), now, atol=1e-5)


def test_the_size_effect_is_the_leading_order():
    """A disk at constant acceleration, short exposure: λ²d²/32 (a_x, 3 a_y) against the rendered image."""
    acceleration, line_time = np.array([8e5, 3e5]), 0.02 / 300

    def path(time):
        since = np.asarray(time) - 0.01
        return np.array([210.0, 150.0]) + 0.5 * np.multiply.outer(since**2, acceleration)

    image = expose_rolling(path, 0.0, 2e-4, line_time, Marker(40.0), FrameFormat())
    begin, end = time_in_row(path, 0.0, line_time), time_in_row(path, 2e-4, line_time)
    shift = np.array(grey_level_centroid(image.astype(np.float32), 0.0)) - time_mean(path, begin, end - begin)
    expected = size_effect(40.0, line_time, acceleration)
    assert expected.min() > 0.1
    np.testing.assert_allclose(shift, expected, rtol=0.1)


def test_a_sample_along_the_rows_solves_the_implicit_equation():
    signal = pseudo_random_binary_sequence(6)
    motion, frames = HeldMotion(PLANT, signal, 0.1), 0.1 * np.arange(signal.size)
    largest = np.abs(motion.position(np.linspace(0.0, frames[-1], 40 * frames.size))).max()
    samples = rolling_shutter.rolling_samples(motion, frames, 0.08, 0.4)[2:-1]
    # The row is read at the time t for which t + ℓ(y(t)) is that of the frame; look it up on a fine grid instead.
    fine = np.linspace(0.0, frames[-1], 400 * frames.size)
    arrival = fine + 0.08 * (0.5 - 0.4 * motion.position(fine) / largest)
    assert np.all(np.diff(arrival) > 0.0)
    begin, end = (np.interp(frames[2:-1] - before, arrival, fine) for before in (0.1, 0.0))
    np.testing.assert_allclose(samples, motion.mean(begin, end), atol=1e-4)


def test_a_fixed_row_is_a_latency_and_no_readout_is_a_global_shutter(table):
    runs = table[table["part"] == "identification"]
    errors = [f"error_{p}" for p in ("b0", "a1", "a0")]
    exact = (runs["readout"] == 0.0) | ((runs["motion"] == "at the middle row") & (runs["declared"] == "mean latency"))
    assert runs.loc[exact, errors].abs().max().max() < 1e-6
    assert runs.loc[~exact & (runs["declared"] == "no latency"), errors].abs().min().min() > 1.0


def test_the_row_at_begin_and_end_is_the_best_model(table):
    for _, runs in table[table["part"] == "speed"].groupby(["exposure", "frequency"]):
        distance = runs.set_index("model")["distance"]
        assert distance["row at begin and end"] < 1.05 * distance["row of the measurement"]
        assert distance["row of the measurement"] < 0.1 * distance["time of the middle row"]


def test_the_conclusion_follows_the_numbers(table):
    value = {name: number for name, (number, _) in rolling_shutter.quantities(table).items()}
    assert value["power_of_diameter"] == pytest.approx(2.0, abs=0.2)
    assert "takes away most" in rolling_shutter.conclusion({**value, "along_mean_latency_b0": 0.1})
    other = rolling_shutter.conclusion({**value, "along_mean_latency_b0": -40.0})
    assert "does not take it away" in other
    assert "-40.0" in other


def test_the_figure_and_its_numbers(table):
    figure, numbers = draw(table)
    assert sum(len(part.axes) for part in figure.subfigs) == 6
    assert len(numbers) == len(table)
