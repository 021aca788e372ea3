import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction, second_order
from camid.identification.accuracy import characteristics, cramer_rao_bound, innovation_variance
from camid.identification.discrete_time import least_squares
from camid.identification.estimate import estimate
from camid.identification.experiment import Experiment
from camid.identification.structure import Structure

PLANT = second_order(1.0, 10.0, 0.1)
TRUTH = np.array([100.0, 2.0, 100.0])


@pytest.mark.parametrize(
    ("period", "expected"),
    # Computed for this project by code that shares nothing with camid; per cent of b0, a1, a0.
    [(0.02, (2.04, 2.94, 0.43)), (0.1, (2.01, 2.90, 0.40)), (0.2, (2.01, 2.90, 0.42)), (0.3, (2.02, 2.37, 0.46))],
)
def test_cramer_rao_bound_against_independent_numbers(period, expected, excitation):
    acquisition = Acquisition(period)
    variance = np.var(sample(PLANT, excitation, acquisition)) / 10.0
    bound = cramer_rao_bound(PLANT, excitation, acquisition, variance)
    assert np.allclose(100.0 * np.sqrt(np.diag(bound)) / TRUTH, expected, atol=0.011)


@pytest.mark.parametrize("period", [0.3, 0.34, 0.4])
def test_bound_stays_finite_past_the_shannon_limit(period, excitation):
    acquisition = Acquisition(period)
    variance = np.var(sample(PLANT, excitation, acquisition)) / 10.0
    deviation = np.sqrt(cramer_rao_bound(PLANT, excitation, acquisition, variance)[2, 2]) / 100.0
    assert 0.001 < deviation < 0.01


@pytest.mark.parametrize("period", [0.02, 0.15, 0.3])
def test_errors_and_stated_deviations_agree_with_the_bound(period, excitation):
    acquisition = Acquisition(period)
    clean = sample(PLANT, excitation, acquisition)
    level = np.std(clean) / np.sqrt(10.0)
    bound = cramer_rao_bound(PLANT, excitation, acquisition, level**2)
    errors, covered = [], 0
    for seed in range(60):
        output = clean + level * np.random.default_rng(seed).standard_normal(len(clean))
        result = estimate(Structure.of_order(2, 0), [Experiment(excitation, output, acquisition, clean < np.inf)])
        error = np.array([*result.plant.numerator, *result.plant.denominator[1:]]) - TRUTH
        errors.append(error)
        covered += np.sum(np.abs(error) < 1.96 * result.standard_deviations)
        assert result.converged
        assert np.sqrt(result.noise_variance) == pytest.approx(level, rel=0.15)
    ratio = np.sqrt(np.mean(np.square(errors), axis=0) / np.diag(bound))
    assert np.all(ratio < 1.3)  # 60 seeds: a standard deviation of 9 %
    assert np.all(ratio > 0.7)
    assert 160 <= covered <= 178  # of 180; 95 % is 171, standard deviation 3


def test_characteristics_and_their_deviations_by_monte_carlo():
    plant = TransferFunction((100.0,), (1.0, 2.0, 100.0))
    # Correlated, so that the signs of the derivatives count.
    covariance = np.array([[4.0, 0.1, 0.6], [0.1, 0.01, 0.02], [0.6, 0.02, 0.25]])
    assert np.all(np.linalg.eigvalsh(covariance) > 0.0)
    rows = {row["name"]: row for row in characteristics(plant, covariance)}
    generator = np.random.default_rng(0)
    draws = generator.multivariate_normal(TRUTH, covariance, size=20_000)
    omega = np.sqrt(draws[:, 2])
    for name, values in {
        "static gain": draws[:, 0] / draws[:, 2],
        "natural frequency": omega,
        "damping ratio": draws[:, 1] / (2.0 * omega),
    }.items():
        assert rows[name]["value"] == pytest.approx(np.mean(values), rel=1e-3)
        assert rows[name]["standard_deviation"] == pytest.approx(np.std(values), rel=0.03)


def test_real_poles_and_an_integrator_have_characteristics():
    rows = characteristics(TransferFunction((1.0,), (1.0, 3.0, 0.0)), np.diag([0.1, 0.2, 0.0]))
    assert [row["name"] for row in rows] == ["real pole", "real pole"]
    assert rows[1]["standard_deviation"] == pytest.approx(np.sqrt(0.2))


def test_innovation_variance_is_the_noise_variance(excitation):
    signal = np.tile(excitation, 4)
    acquisition = Acquisition(0.1)
    output = sample(PLANT, signal, acquisition)
    noisy = output + 0.2 * np.random.default_rng(0).standard_normal(len(output))
    rows = np.ones(len(output), bool)
    assert innovation_variance(Experiment(signal, noisy, acquisition, rows)) == pytest.approx(0.04, rel=0.15)
    assert innovation_variance(Experiment(signal, output, acquisition, rows)) < 1e-18


@pytest.mark.parametrize("period", [0.02, 0.1, 0.3])
def test_discrete_time_model_of_section_3_1(period, excitation):
    from camid.chain.camera_models import closed_form

    output = sample(PLANT, excitation, Acquisition(period))
    model = least_squares(excitation, output, poles=2, zeros=2, delay=1)
    written = closed_form(1.0, 10.0, 0.1, period)
    assert np.allclose(model.numerator, written.beta, atol=1e-12)
    assert np.allclose(model.denominator, [1.0, -written.alpha[0], written.alpha[1]], atol=1e-12)
    with pytest.raises(ValueError, match="too few"):
        least_squares(excitation[:4], output[:4], poles=2, zeros=2, delay=1)


@pytest.mark.parametrize("driven", [True, False])
def test_unpredictable_part_is_that_of_a_long_regression(driven):
    """The lagged products by recursion against a table of lagged columns; a masked row takes the other way."""
    generator = np.random.default_rng(3)
    count, length = 400, 30
    signal = generator.standard_normal(count) if driven else np.zeros(count)
    output = np.convolve(generator.standard_normal(count) + signal, [1.0, 0.7, 0.3], "same")
    rows = np.arange(length, count)
    columns = [output[rows - i] for i in range(1, length + 1)]
    columns += [signal[rows - i] for i in range(length + 1)] if driven else []
    table = np.column_stack(columns)
    residual = output[rows] - table @ np.linalg.lstsq(table, output[rows], rcond=None)[0]
    expected = residual @ residual / (len(rows) - table.shape[1])
    used = np.ones(count, bool)
    whole = Experiment(signal, output, Acquisition(0.1), used)
    assert innovation_variance(whole) == pytest.approx(expected, rel=1e-9)
    gap = used.copy()
    gap[length] = False
    masked = Experiment(signal, output, Acquisition(0.1), gap)
    assert innovation_variance(masked) == pytest.approx(expected, rel=0.05)
