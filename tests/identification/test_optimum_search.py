from dataclasses import replace

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction, polynomial_roots, second_order
from camid.identification.discrete_time_start import alias_angles, alias_denominators
from camid.identification.estimate import estimate
from camid.identification.experiment import Experiment
from camid.identification.optimum_search import Search
from camid.identification.records import Records
from camid.identification.structure import Structure

STRUCTURE = Structure.of_order(2, 0)


def noisy(plant, product, excitation, ratio=10.0, seed=0, **acquisition):
    chosen = Acquisition(product / 10.0, **acquisition)
    output = sample(plant, excitation, chosen)
    noise = np.sqrt(np.var(output) / ratio) * np.random.default_rng(seed).standard_normal(len(output))
    return Experiment(excitation, output + noise, chosen, np.ones(len(output), bool))


def test_alias_angles_have_one_cosine():
    for angle in (0.3, 2.0, 4.0, 7.3):
        angles = alias_angles(angle)
        np.testing.assert_allclose(np.cos(angles), np.cos(angle), atol=1e-12)
        assert any(np.isclose(a, angle) for a in angles)


def test_alias_denominators_have_the_same_sampled_poles():
    poles = np.array([-1.0 + 12.0j, -1.0 - 12.0j, -3.0])
    found = alias_denominators(poles, 0.2)
    assert len(found) > 0
    for denominator in found:
        moved = np.roots(denominator)
        np.testing.assert_allclose(np.sort_complex(np.exp(0.2 * moved)), np.sort_complex(np.exp(0.2 * poles)))
        assert not np.allclose(np.sort_complex(moved), np.sort_complex(poles))


@pytest.mark.parametrize("product", [3.0, 3.4, 4.0, 4.8])
def test_true_frequency_is_found_from_nothing_near_and_past_the_shannon_limit(excitation, product):
    for seed in range(5):
        result = estimate(STRUCTURE, [noisy(second_order(1.0, 10.0, 0.1), product, excitation, seed=seed)])
        assert result.plant.denominator[2] == pytest.approx(100.0, rel=0.1)


def test_an_exact_alias_is_named_as_a_rival(excitation):
    """Two poles, one zero, held input, instant sensor: the sampled model has a twin of the same likelihood."""
    plant = TransferFunction((3.0, 100.0), (1.0, 2.0, 100.0))
    experiment = noisy(plant, 2.0, excitation, ratio=1000.0, sensor="instant")
    result = estimate(Structure.of_order(2, 1), [experiment])
    assert result.plant.denominator[2] == pytest.approx(100.0, rel=0.05)
    alias = 2.0 * np.pi / experiment.acquisition.period - np.sqrt(99.0)
    assert any(abs(r.natural_frequencies[-1] / alias - 1.0) < 0.05 and r.weight > 0.2 for r in result.rivals)


def test_a_belief_below_the_shannon_frequency_rules_faster_twins_out(excitation):
    plant = TransferFunction((3.0, 100.0), (1.0, 2.0, 100.0))
    experiment = noisy(plant, 2.0, excitation, ratio=1000.0, sensor="instant")
    assert estimate(Structure.of_order(2, 1), [experiment], nominal=plant).rivals == []


def test_a_wrong_frequency_is_never_stated_with_confidence(excitation):
    """Far past the limit, without any model: the true mode is found, is named as a rival, or no number is stated."""
    for seed in range(40):
        result = estimate(STRUCTURE, [noisy(second_order(1.0, 10.0, 0.1), 7.3, excitation, seed=seed)])
        frequency = np.sqrt(result.plant.denominator[2])
        deviation = result.standard_deviations[2] / (2.0 * frequency)
        named = any(abs(r.natural_frequencies[-1] / 10.0 - 1.0) < 0.05 for r in result.rivals)
        assert named or not result.converged or abs(frequency - 10.0) < max(0.5, 3.5 * deviation), (seed, frequency)


@pytest.mark.parametrize(
    "coefficients",
    [(1.0, 2.0, 100.0), (2.0, 3.0, 1.0), (1.0, 1e8, 1.0), (1.0, 0.0, 0.0), (3.0, -6.0), (5.0,), (1.0, 6.0, 11.0, 6.0)],
)
def test_roots_in_closed_form_are_those_of_the_companion_matrix(coefficients):
    roots = polynomial_roots(coefficients)
    np.testing.assert_allclose(np.sort_complex(roots), np.sort_complex(np.roots(coefficients)), rtol=1e-7, atol=1e-12)
    for root in roots:  # a small root keeps its digits beside a large one
        scale = sum(abs(c) * abs(root) ** (len(coefficients) - 1 - i) for i, c in enumerate(coefficients))
        assert abs(np.polyval(coefficients, root)) <= 1e-14 * scale


@pytest.mark.filterwarnings("error")
def test_a_recording_that_only_judges_has_no_part_in_what_cannot_be_predicted(excitation):
    fitted = replace(noisy(second_order(1.0, 10.0, 0.1), 1.0, excitation), estimate_offset=True)
    judging = replace(fitted, output=fitted.output + 7.0, used=np.zeros(len(excitation), bool))
    alone, both = (
        Search(STRUCTURE, experiments, Records.of(experiments), None, print).unpredictable
        for experiments in ([fitted], [fitted, judging])
    )
    assert alone == both > 0.0
