import itertools

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction, second_order
from camid.identification.estimate import estimate
from camid.identification.experiment import Experiment
from camid.identification.predictor import Predictor
from camid.identification.safeguarded import safeguarded_srivc
from camid.identification.srivc import least_squares_state_variable_filter, plain_srivc, reflect
from camid.identification.structure import Structure

PLANT = second_order(1.0, 10.0, 0.1)
TRUTH = np.array([100.0, 2.0, 100.0])


def experiment(excitation, acquisition, plant=PLANT, noise=0.0, seed=0, initial_state=None):
    output = sample(plant, excitation, acquisition, initial_state)
    output = output + noise * np.random.default_rng(seed).standard_normal(len(output))
    return Experiment(excitation, output, acquisition, np.ones(len(output), bool), initial_state is not None)


def predictor_for(one, structure=None):
    return Predictor.around(structure or Structure.of_order(2, 0), [one], np.array([1.0, 2.0, 100.0]))


@pytest.mark.parametrize("acquisition", [Acquisition(0.1), Acquisition(0.1, "foh", "camera", 0.03, 0.16)])
@pytest.mark.parametrize("initial", [None, np.array([0.4, -1.0])])
def test_sensitivities_are_the_derivatives_of_the_output(acquisition, initial, excitation):
    structure = Structure.of_order(2, 1)
    one = experiment(excitation, acquisition, initial_state=initial)
    predictor = predictor_for(one, structure)
    parameters = predictor.from_physical(np.array([3.0, 100.0, 2.0, 100.0]), initial)
    residual, sensitivities = predictor.linearise(parameters)
    for i in range(len(parameters)):
        step = 1e-6
        ahead, behind = parameters.copy(), parameters.copy()
        ahead[i] += step
        behind[i] -= step
        numeric = (predictor.simulate(ahead)[0] - predictor.simulate(behind)[0]) / (2.0 * step)
        assert np.allclose(sensitivities[:, i], numeric, atol=1e-6)
    assert np.allclose(residual, one.output - predictor.simulate(parameters)[0], atol=1e-12)


def test_plain_srivc_reaches_the_truth_below_shannon_and_fails_near_it(excitation):
    near = {}
    for period in (0.02, 0.1, 0.2, 0.3):
        one = experiment(excitation, Acquisition(period))
        predictor = predictor_for(one)
        fit = plain_srivc(predictor, least_squares_state_variable_filter(predictor, 10.0))
        error = np.max(np.abs(predictor.to_physical(fit.parameters) / TRUTH - 1.0))
        near[period] = fit.converged and error < 1e-6
    assert near == {0.02: True, 0.1: True, 0.2: True, 0.3: False}


def test_safeguarded_srivc_holds_where_plain_srivc_leaves_from_the_truth(excitation):
    """Tω0 = 3.0 with noise: plain SRIVC does not settle even when started at the truth."""
    acquisition = Acquisition(0.3)
    left, held = 0, 0
    for seed in range(10):
        level = np.std(sample(PLANT, excitation, acquisition)) / np.sqrt(10.0)
        predictor = predictor_for(experiment(excitation, acquisition, noise=level, seed=seed))
        start = predictor.from_physical(TRUTH)
        left += not plain_srivc(predictor, start).converged
        safe = safeguarded_srivc(predictor, start)
        held += safe.converged and np.max(np.abs(predictor.to_physical(safe.parameters) / TRUTH - 1.0)) < 0.2
    assert left >= 8
    assert held == 10


def test_safeguarded_iteration_never_raises_the_output_error(excitation):
    predictor = predictor_for(experiment(excitation, Acquisition(0.1), noise=0.3))
    start = predictor.from_physical(np.array([60.0, 5.0, 130.0]))
    costs = [safeguarded_srivc(predictor, start, maximum_iterations=i).cost for i in range(1, 9)]
    assert costs[0] > 1.01 * costs[-1]
    assert all(after <= before for before, after in itertools.pairwise(costs))


def test_progress_is_reported_without_changing_the_result(excitation):
    predictor = predictor_for(experiment(excitation, Acquisition(0.1), noise=0.3))
    start = predictor.from_physical(np.array([60.0, 5.0, 130.0]))
    reports = []
    told = safeguarded_srivc(predictor, start, on_iteration=lambda i, cost: reports.append((i, cost)))
    silent = safeguarded_srivc(predictor, start)
    assert reports[-1] == (told.iterations, told.cost)
    assert told.cost == silent.cost


def test_undetermined_coefficients_are_not_called_converged():
    """A constant input says nothing of a plant that is already at rest in it."""
    signal = np.ones(200)
    acquisition = Acquisition(0.1)
    one = Experiment(signal, np.ones(200), acquisition, np.arange(200) > 150)
    predictor = predictor_for(one)
    fit = safeguarded_srivc(predictor, predictor.from_physical(TRUTH))
    assert not fit.converged


def test_one_sample_shift_belongs_to_the_camera(excitation):
    """u[k], w[k+1] under a first-order hold is the camera sensor under a zero-order hold."""
    output = sample(PLANT, excitation, Acquisition(0.1))
    shifted = np.concatenate([[0.0], excitation[:-1]])
    rows = np.ones(len(output), bool)
    argument = Experiment(shifted, output, Acquisition(0.1, "foh", "instant"), rows)
    result = estimate(Structure.of_order(2, 0), [argument])
    found = np.array([*result.plant.numerator, *result.plant.denominator[1:]])
    assert np.max(np.abs(found / TRUTH - 1.0)) < 1e-12


def test_fixed_coefficients_stay(excitation):
    one = experiment(excitation, Acquisition(0.1), noise=0.05)
    structure = Structure(
        np.array([100.0]), np.array([1.0, 3.0, 100.0]), np.array([True]), np.array([False, False, True])
    )
    result = estimate(structure, [one], nominal=TransferFunction((90.0,), (1.0, 3.0, 110.0)))
    assert result.plant.denominator[1] == pytest.approx(3.0, rel=1e-12)
    assert result.standard_deviations[1] == 0.0
    assert result.standard_deviations[2] > 0.0


def test_unknown_initial_state_is_estimated(excitation):
    acquisition = Acquisition(0.05, latency=0.02)
    one = experiment(excitation, acquisition, initial_state=np.array([2.0, -3.0]))
    result = estimate(Structure.of_order(2, 0), [one])
    found = np.array([*result.plant.numerator, *result.plant.denominator[1:]])
    assert result.converged
    assert np.max(np.abs(found / TRUTH - 1.0)) < 1e-9


def test_several_recordings_with_their_own_initial_states(excitation):
    acquisition = Acquisition(0.1)
    first = experiment(excitation, acquisition, noise=0.1, initial_state=np.array([1.0, 1.0]))
    second = experiment(-excitation[100:], acquisition, noise=0.1, seed=1, initial_state=np.array([-2.0, 0.0]))
    both = estimate(Structure.of_order(2, 0), [first, second])
    alone = estimate(Structure.of_order(2, 0), [first])
    assert both.converged
    assert np.all(both.standard_deviations < alone.standard_deviations)


def test_output_error_by_a_general_optimiser_agrees(excitation):
    one = experiment(excitation, Acquisition(0.2), noise=0.2)
    ours = estimate(Structure.of_order(2, 0), [one])
    theirs = estimate(Structure.of_order(2, 0), [one], method="output-error")
    assert np.allclose(ours.plant.denominator, theirs.plant.denominator, rtol=1e-5)
    assert np.allclose(ours.plant.numerator, theirs.plant.numerator, rtol=1e-5)


def test_reflection_keeps_the_modulus_of_the_roots():
    mirrored = reflect(np.array([1.0, -2.0, 100.0]))
    assert np.allclose(mirrored, [1.0, 2.0, 100.0])
    assert np.allclose(reflect(np.array([1.0, 2.0, 100.0])), [1.0, 2.0, 100.0])


def test_alias_is_not_taken_for_a_wrong_model(excitation):
    """A model that cannot fit (hold declared wrongly) must not be explained by a mode past the Shannon frequency."""
    output = sample(PLANT, excitation, Acquisition(0.1))
    wrong = Experiment(excitation, output, Acquisition(0.1, "zoh", "instant"), np.ones(len(output), bool))
    result = estimate(Structure.of_order(2, 0), [wrong])
    assert np.max(np.abs(result.plant.poles())) < np.pi / 0.1


def test_unknown_method_is_refused(excitation):
    with pytest.raises(ValueError, match="must be one of"):
        estimate(Structure.of_order(2, 0), [experiment(excitation, Acquisition(0.1))], method="magic")


def test_integrator_in_noise_ends_at_the_limit_of_stability_and_converges(excitation):
    """The unconstrained optimum may lie in the unstable region; the bound is then an answer and no failure."""
    plant = TransferFunction((2.0,), (1.0, 2.0, 0.0))
    acquisition = Acquisition(0.1)
    output = sample(plant, excitation, acquisition)
    held = 0
    for seed in range(12):
        noisy = output + 0.03 * np.std(output) * np.random.default_rng(seed).standard_normal(len(output))
        result = estimate(
            Structure.of_order(2, 0), [Experiment(excitation, noisy, acquisition, np.ones(len(output), bool))]
        )
        assert result.converged
        assert result.plant.denominator[1] == pytest.approx(2.0, rel=0.2)
        assert 0.0 <= result.plant.denominator[2] < 0.2
        held += result.plant.denominator[2] == 0.0
    assert 0 < held < 12


def test_undamped_mode_in_noise_converges(excitation):
    acquisition = Acquisition(0.1)
    output = sample(TransferFunction((9.0,), (1.0, 0.006, 9.0)), excitation, acquisition)
    for seed in range(6):
        noisy = output + 0.3 * np.std(output) * np.random.default_rng(seed).standard_normal(len(output))
        rows = np.ones(len(output), bool)
        result = estimate(Structure.of_order(2, 0), [Experiment(excitation, noisy, acquisition, rows)])
        assert result.converged
        assert np.abs(result.plant.poles()[0]) == pytest.approx(3.0, rel=0.01)


@pytest.mark.parametrize("latency", [0.0, 1.8, 2.8])
def test_fast_pole_and_unknown_initial_state(latency, excitation):
    """The fast part of the initial motion is gone before the first fitted frame; the plant is still determined."""
    plant = TransferFunction((7.5,), (1.0, 15.5, 7.5))
    acquisition = Acquisition(1.0, "foh", "instant", None, latency)
    output = sample(plant, excitation, acquisition)[60:]
    rows = np.ones(len(output), bool)
    rows[: acquisition.window()[0]] = False
    one = Experiment(excitation[60:], output, acquisition, rows, estimate_initial_state=True)
    result = estimate(Structure.of_order(2, 0), [one], nominal=plant)
    assert result.converged
    assert np.allclose(result.plant.denominator, plant.denominator, rtol=1e-9)


@pytest.mark.parametrize(
    ("omega", "exposure", "noise"), [(36.0, 0.05, 0.003), (60.0, 0.005, 0.003), (50.0, 0.005, 0.03)]
)
def test_heavily_damped_mode_near_and_past_shannon_without_any_start(omega, exposure, noise):
    """The sampled pole lies near the negative real axis, where discrete-time starts are blind."""
    plant = TransferFunction((omega**2,), (1.0, 40.0, omega**2))
    acquisition = Acquisition(0.1, exposure=exposure)
    for seed in range(5):
        generator = np.random.default_rng(seed)
        signal = generator.choice([-1.0, 1.0], 1000)
        output = sample(plant, signal, acquisition)
        output = output + noise * np.std(output) * generator.standard_normal(1000)
        result = estimate(Structure.of_order(2, 0), [Experiment(signal, output, acquisition, np.ones(1000, bool))])
        assert result.converged
        assert abs(result.plant.denominator[2] - omega**2) < 5.0 * result.standard_deviations[2]


def test_what_cannot_be_told_apart_is_named(excitation):
    """A plant with a zero behind a held input and before an instant sensor is its own alias, exactly."""
    plant = TransferFunction((3.0, 100.0), (1.0, 4.0, 100.0))
    acquisition = Acquisition(0.2, sensor="instant")
    output = sample(plant, excitation, acquisition)
    noisy = output + 0.1 * np.std(output) * np.random.default_rng(0).standard_normal(len(output))
    alias = np.abs(plant.poles()[0] + 1j * (2.0 * np.pi / 0.2 - 2.0 * plant.poles()[0].imag))
    one = Experiment(excitation, noisy, acquisition, np.ones(len(output), bool))
    result = estimate(Structure.of_order(2, 1), [one])
    assert np.abs(result.plant.poles()[0]) == pytest.approx(10.0, rel=0.05)
    assert any(abs(r.natural_frequencies[0] / alias - 1.0) < 0.05 for r in result.rivals)
    assert 0.3 < sum(r.weight for r in result.rivals) < 0.9


def test_plain_srivc_starts_from_a_nominal_plant_whatever_the_structure_holds(excitation):
    data = [experiment(excitation, Acquisition(0.05))]
    result = estimate(Structure.of_order(2, 0), data, nominal=second_order(1.1, 9.5, 0.12), method="plain-srivc")
    assert result.converged
    np.testing.assert_allclose([*result.plant.numerator, *result.plant.denominator[1:]], TRUTH, rtol=1e-6)
