"""The regression of the noise's variance on the square of a speed or a position."""

from types import SimpleNamespace

import numpy as np
import pytest

from camid.effects.variance_regression import scatters_from_frame_to_frame, variance_regression

BASE, SLOPE = 4.0, 0.25


def uneven_noise(count: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(3)
    regressor = random.standard_normal(count) ** 2
    return (BASE + SLOPE * regressor) * random.standard_normal(count) ** 2, regressor


def test_the_slope_is_found_within_its_deviation():
    square, regressor = uneven_noise()
    _, slope, deviation, score = variance_regression(square, 100.0 * regressor)
    assert abs(slope - SLOPE / 100.0) < 2.5 * deviation
    assert score > 2.0


@pytest.mark.parametrize("unit", [1e-18, 1e-9, 1e8, 1e15])
def test_units_change_nothing(unit):
    """Speeds of thousands of pixels per second have squares beside which a constant of one is lost."""
    square, regressor = uneven_noise()
    gain, slope, deviation, score = variance_regression(square, regressor)
    other = variance_regression(1e-6 * square, unit * regressor)
    assert other == pytest.approx((gain, 1e-6 * slope / unit, 1e-6 * deviation / unit, score), rel=1e-6)


def test_a_regressor_that_never_changes_says_nothing():
    square, _ = uneven_noise()
    assert variance_regression(square, np.full(len(square), 0.3))[:2] == (0.0, 0.0)


@pytest.mark.parametrize("scatters", [True, False])
def test_an_error_that_goes_on_does_not_scatter_from_frame_to_frame(scatters):
    """Coefficients that err do so most in fast motion, over many frames; times that scatter do it frame by frame."""
    random = np.random.default_rng(9)
    time = 0.01 * np.arange(2000)
    velocity = np.where(time < 10.0, 0.2, 2.0) * np.cos(2.0 * time)
    error = random.standard_normal(2000) if scatters else np.sin(1.3 * time)
    residual = random.standard_normal(2000) + 0.6 * velocity * error
    everything = np.ones(2000, bool)
    assert variance_regression(residual**2, velocity**2)[3] > 4.0
    assert scatters_from_frame_to_frame(SimpleNamespace(residual=residual, velocity=velocity), everything) == scatters


def test_the_score_of_second_differences_is_in_its_standard_deviations():
    """Neighbouring differences of frames have frames in common; as if independent the score would spread by 1.4."""
    random = np.random.default_rng(17)
    scores = []
    for _ in range(400):
        speed = np.convolve(random.standard_normal(639), np.hanning(40), "valid") ** 2
        difference = np.diff(random.standard_normal(len(speed)), 2)
        scores.append(variance_regression(difference**2, speed[1:-1])[3])
    assert np.std(scores) == pytest.approx(1.0, abs=0.1)
