"""The share of outliers, of whatever shape, is estimated with the uncertainty that it has."""

import numpy as np
import pytest

from camid.effects.outlier_share import outlier_share

FAR, SAMPLES = 4.0, 60


def share_of(struck, seed, share, count):
    """Estimate and true number of those struck, of unit noise that ``struck`` replaces, by (generator, count)."""
    generator = np.random.default_rng([7, seed])
    values = generator.normal(size=count)
    rows = generator.random(count) < share
    values[rows] = struck(generator, int(rows.sum()))
    values -= np.median(values)
    return outlier_share(values, np.abs(values) > FAR, 1.4826 * float(np.median(np.abs(values))))


SHAPES = {
    "normal": lambda generator, count: 8.0 * generator.normal(size=count),
    "Laplacian": lambda generator, count: 8.0 * generator.laplace(size=count),
    "uniform": lambda generator, count: generator.uniform(-12.0, 12.0, count),
    "a second marker": lambda generator, count: np.full(count, 9.0),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("share", "count"), [(0.02, 3000), (0.12, 1500)])
def test_intervals_hold_the_true_share(shape, share, count):
    found = np.array([share_of(SHAPES[shape], seed, share, count) for seed in range(SAMPLES)])
    deviations = (found[:, 0] - share) / found[:, 1]
    assert np.mean(np.abs(deviations) < 1.96) >= 0.85
    assert abs(np.mean(found[:, 0]) / share - 1.0) < 0.1


def test_a_count_of_what_lies_far_off_misses_what_lies_near():
    generator = np.random.default_rng(3)
    values = np.where(generator.random(4000) < 0.15, 6.0 * generator.normal(size=4000), generator.normal(size=4000))
    far = np.abs(values) > FAR
    share, deviation = outlier_share(values, far, 1.0)
    assert np.mean(far) < 0.09
    assert abs(share - 0.15) < 3.0 * deviation
