"""Intervals from the likelihood, against a profile computed by a general optimiser."""

import numpy as np
import pytest
from scipy.optimize import brentq, least_squares

from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction, second_order
from camid.identification.estimate import estimate
from camid.identification.experiment import Experiment
from camid.identification.structure import Structure

STRUCTURE = Structure.of_order(2, 0)
WIDTH = 1.959964  # 95 % of a normal distribution, in standard deviations


def noisy(acquisition, excitation, level, seed=0):
    output = sample(second_order(1.0, 10.0, 0.1), excitation, acquisition)
    noise = np.random.default_rng(seed).standard_normal(len(output))
    return Experiment(excitation, output + level * np.std(output) * noise, acquisition, np.ones(len(output), bool))


def profile_bound(experiment, result, index, side):
    """Where the deviance has risen to the 95 % point, by a general optimiser on the plain simulation."""
    best = np.array([result.plant.numerator[0], *result.plant.denominator[1:]])
    others = [i for i in range(3) if i != index]

    def residual(values, fixed):
        coefficients = best.copy()
        coefficients[index], coefficients[others] = fixed, np.abs(values) * best[others]
        plant = TransferFunction((coefficients[0],), (1.0, *coefficients[1:]))
        return experiment.output - sample(plant, experiment.signal, experiment.acquisition)

    noise = result.noise_variance
    cost = np.sum(result.residuals[0] ** 2)

    def excess(factor):
        fit = least_squares(residual, np.ones(2), args=(best[index] * factor,), xtol=1e-10, ftol=1e-12)
        return np.sqrt(max(2.0 * fit.cost - cost, 0.0) / noise) - WIDTH

    return best[index] * brentq(excess, 1.0, 1.0 + side * 0.9 if side < 0 else 6.0, xtol=1e-4)


def test_a_parabola_keeps_its_first_order(excitation):
    assert estimate(STRUCTURE, [noisy(Acquisition(0.1), excitation, 0.3)]).intervals == []


def test_weak_information_gets_the_interval_of_the_likelihood(excitation):
    experiment = noisy(Acquisition(0.1), excitation[:30], 0.9, seed=3)
    result = estimate(STRUCTURE, [experiment])
    assert result.converged
    damping = next(i for i in result.intervals if i.coefficient == 1)
    assert damping.low < result.plant.denominator[1] < damping.high
    expected = profile_bound(experiment, result, 1, 1.0)
    assert damping.high == pytest.approx(expected, rel=0.05)
    assert result.standard_deviations[1] >= 0.95 * (expected - result.plant.denominator[1]) / WIDTH


def test_damping_that_the_data_do_not_limit_is_undetermined(excitation):
    """Past the second Shannon limit some noise samples leave the damping open, and none states a wrong one."""
    undetermined = 0
    for seed in range(12):
        experiment = noisy(Acquisition(0.73), excitation, np.sqrt(0.1), seed)
        result = estimate(STRUCTURE, [experiment], nominal=second_order(1.0, 10.0, 0.1))
        undetermined += bool(np.isinf(result.standard_deviations[1]))
        error = abs(result.plant.denominator[1] - 2.0)
        assert error < 3.5 * result.standard_deviations[1] or result.rivals or not result.converged
    assert undetermined > 0


def test_intervals_follow_the_units_of_the_recording(excitation):
    experiment = noisy(Acquisition(0.1), excitation[:30], 0.9, seed=3)
    large = Experiment(experiment.signal * 1e3, experiment.output * 1e-2, experiment.acquisition, experiment.used)
    intervals, of_large = estimate(STRUCTURE, [experiment]).intervals, estimate(STRUCTURE, [large]).intervals
    assert {i.coefficient for i in intervals} >= {1}
    for ours, theirs in zip(intervals, of_large, strict=True):
        factor = 1e-5 if ours.coefficient == 0 else 1.0
        assert theirs.high == pytest.approx(factor * ours.high, rel=1e-2)
