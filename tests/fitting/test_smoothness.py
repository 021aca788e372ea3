"""How smooth a curve is, and whether there is one, by the evidence of the data."""

import numpy as np
import pytest

from camid.fitting.smoothness import smooth_curve

COUNT, WEIGHTS = 400, 15


def problem(size, noise, seed=0):
    """Hat functions over [-1, 1], rough second differences, and data on a curve of this size."""
    generator = np.random.default_rng(np.random.SeedSequence((5, seed)))
    knots, at = np.linspace(-1.0, 1.0, WEIGHTS), generator.uniform(-1.0, 1.0, COUNT)
    table = np.column_stack([np.interp(at, knots, row) for row in np.eye(WEIGHTS)])
    second = np.diff(np.eye(WEIGHTS), 2, axis=0)
    roughness = second.T @ second + 1e-6 * np.eye(WEIGHTS)
    truth = size * np.sin(3.0 * knots)
    return table, table @ truth + noise * generator.standard_normal(COUNT), roughness, truth


def marginal(table, data, roughness, ratio):
    """Logarithm of the marginal likelihood from the covariance of the data, the variance of the noise integrated."""
    covariance = np.eye(len(data)) + ratio * table @ np.linalg.solve(roughness, table.T)
    _, size = np.linalg.slogdet(covariance)
    return -0.5 * (size + len(data) * np.log(data @ np.linalg.solve(covariance, data)))


def test_evidence_is_the_marginal_likelihood_and_the_largest():
    table, data, roughness, _ = problem(1.0, 0.3)
    found = smooth_curve(table, data, roughness, len(data))
    assert found.log_evidence == pytest.approx(marginal(table, data, roughness, found.ratio), abs=1e-6)
    assert found.without == pytest.approx(marginal(table, data, roughness, 0.0), abs=1e-6)
    for factor in (0.2, 5.0):
        assert marginal(table, data, roughness, factor * found.ratio) < found.log_evidence


def test_there_is_no_curve_in_noise():
    gains = []
    for seed in range(40):
        table, data, roughness, _ = problem(0.0, 1.0, seed)
        found = smooth_curve(table, data, roughness, len(data))
        gains.append(found.log_evidence - found.without)
    assert max(gains) < 5.0
    assert np.median(gains) < 0.5


def test_a_curve_lies_within_its_deviations():
    inside = []
    for seed in range(40):
        table, data, roughness, truth = problem(1.0, 0.5, seed)
        found = smooth_curve(table, data, roughness, len(data))
        assert found.log_evidence - found.without > 20.0
        inside += (np.abs(found.values - truth) < 1.96 * np.sqrt(np.diag(found.covariance))).tolist()
    assert 0.88 < np.mean(inside) <= 1.0


def test_more_noise_asks_for_a_smoother_curve():
    ratios = [smooth_curve(*problem(1.0, noise)[:3], COUNT).ratio for noise in (0.05, 2.0)]
    assert ratios[0] > 10.0 * ratios[1]
