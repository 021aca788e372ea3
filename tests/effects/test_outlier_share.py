"""The share of outliers, of whatever shape, is estimated with the uncertainty that it has."""

import numpy as np
import pytest

from camid.effects.outlier_share import outlier_share
from camid.effects.recognition import LEAST_EVIDENCE

FAR, SAMPLES = 4.0, 60


def share_of(struck, seed, share, count):
    """Estimate and true number of those struck, of unit noise that ``struck`` replaces, by (generator, count)."""
    generator = np.random.default_rng([7, seed])
    values = generator.normal(size=count)
    rows = generator.random(count) < share
    values[rows] = struck(generator, int(rows.sum()))
    values -= np.median(values)
    return estimated(values)


def estimated(values):
    """Of values of zero median, of which some lie far off."""
    return outlier_share(values, np.abs(values) > FAR, 1.4826 * float(np.median(np.abs(values))))


SHAPES = {
    "normal": lambda generator, count: 8.0 * generator.normal(size=count),
    "Laplacian": lambda generator, count: 8.0 * generator.laplace(size=count),
    "uniform": lambda generator, count: generator.uniform(-12.0, 12.0, count),
    "a second marker": lambda generator, count: np.full(count, 9.0),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("share", "count"), [pytest.param(0.02, 3000, marks=pytest.mark.slow), (0.12, 1500)])
@pytest.mark.slow
def test_intervals_hold_the_true_share(shape, share, count):
    shares = [share_of(SHAPES[shape], seed, share, count) for seed in range(SAMPLES)]
    found = np.array([(each.fraction, each.deviation) for each in shares])
    deviations = (found[:, 0] - share) / found[:, 1]
    assert np.mean(np.abs(deviations) < 1.96) >= 0.85
    assert abs(np.mean(found[:, 0]) / share - 1.0) < 0.1


def test_a_count_of_what_lies_far_off_misses_what_lies_near():
    generator = np.random.default_rng(3)
    values = np.where(generator.random(4000) < 0.15, 6.0 * generator.normal(size=4000), generator.normal(size=4000))
    far = np.abs(values) > FAR
    share = outlier_share(values, far, 1.0)
    assert np.mean(far) < 0.09
    assert abs(share.fraction - 0.15) < 3.0 * share.deviation


NOISES = {
    "nearly Gaussian": lambda generator, count: generator.standard_t(9.0, count),
    "heavy": lambda generator, count: generator.standard_t(4.0, count),
    "Laplacian": lambda generator, count: generator.laplace(size=count),
    "logistic": lambda generator, count: generator.logistic(size=count),
    "heavy on top of Gaussian": lambda generator, count: (
        generator.normal(size=count) + generator.standard_t(6.0, count)
    ),
}


def evidences(draw):
    """Of values that a function of a generator draws, with the median taken off; of those with some far off."""
    values = [draw(np.random.default_rng([17, seed])) for seed in range(SAMPLES)]
    centred = [v - np.median(v) for v in values]
    return np.array([estimated(v).evidence for v in centred if np.any(np.abs(v) > FAR * 1.4826 * np.median(np.abs(v)))])


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("count", [500, pytest.param(3000, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_noise_with_heavy_tails_has_no_outliers(noise, count):
    found = evidences(lambda generator: NOISES[noise](generator, count))
    assert len(found) > SAMPLES / 3
    assert np.all(found < LEAST_EVIDENCE)


@pytest.mark.slow
@pytest.mark.parametrize("shape", SHAPES)
def test_outliers_are_told_from_heavy_tails(shape):
    def struck(generator):
        values = generator.normal(size=2000)
        rows = generator.random(2000) < 0.02
        values[rows] = SHAPES[shape](generator, int(rows.sum()))
        return values

    assert np.all(evidences(struck) > LEAST_EVIDENCE)


@pytest.mark.slow
def test_tails_that_no_noise_of_a_sensor_has_are_outliers():
    """A Student distribution of two degrees of freedom has no variance."""
    assert np.all(evidences(lambda generator: generator.standard_t(2.0, 3000)) > LEAST_EVIDENCE)


@pytest.mark.parametrize("size", [0.5, 1.0])
@pytest.mark.slow
def test_tails_on_top_of_the_noise_are_outliers(size):
    """What lies near is the noise's, so that a Student distribution alone has lighter tails than these."""
    found = evidences(lambda generator: generator.normal(size=8000) + size * generator.standard_t(2.0, 8000))
    assert np.mean(found > LEAST_EVIDENCE) > 0.8
