import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.identification.experiment import Experiment
from camid.identification.least_squares import BLOCK, fold
from camid.identification.predictor import Predictor
from camid.identification.records import Records
from camid.identification.structure import Structure
from camid.identification.variable_projection import output_error_costs

ACQUISITIONS = [
    Acquisition(0.1),
    Acquisition(0.1, "foh", "instant"),
    Acquisition(0.1, "foh", "camera", 0.03, 0.02),
    Acquisition(0.1, "zoh", "camera", 0.07, 0.05),
    Acquisition(0.1, "zoh", "camera", 0.1, 0.25),
]


def experiment(acquisition, count=2 * BLOCK + 7, seed=0, initial=False, gaps=True):
    generator = np.random.default_rng(seed)
    used = np.ones(count, bool)
    if gaps:
        used[generator.integers(10, count, 20)] = False
    if initial:
        used[: acquisition.window()[0]] = False
    return Experiment(generator.standard_normal(count), generator.standard_normal(count), acquisition, used, initial)


@pytest.mark.parametrize("acquisition", ACQUISITIONS)
@pytest.mark.parametrize("initial", [False, True])
@pytest.mark.parametrize(("poles", "zeros"), [(1, 0), (2, 0), (2, 2), (4, 1)])
def test_triangle_has_the_normal_equations_of_the_sensitivities(acquisition, initial, poles, zeros):
    """The reference runs all sensitivities at once and keeps them."""
    experiments = [experiment(acquisition, seed=1, initial=initial), experiment(acquisition, 60, 2, initial=initial)]
    structure = Structure.of_order(poles, zeros)
    denominator = np.poly(-np.linspace(1.0, 6.0, poles))
    predictor = Predictor.around(structure, experiments, denominator)
    generator = np.random.default_rng(3)
    parameters = predictor.from_physical(np.concatenate([generator.standard_normal(zeros + 1), denominator[1:]]))
    parameters[len(structure.free) :] = generator.standard_normal(predictor.linear_unknowns)
    triangle, cost, residual = predictor.factorise(parameters)
    expected_residual, table = predictor.linearise(parameters)
    whole = np.column_stack([table, expected_residual])
    np.testing.assert_allclose(triangle.T @ triangle, whole.T @ whole, rtol=1e-9, atol=1e-11 * np.max(whole.T @ whole))
    assert np.all(np.tril(triangle, -1) == 0.0)
    assert cost == pytest.approx(expected_residual @ expected_residual, rel=1e-12)
    used = np.concatenate([e.used for e in experiments])
    np.testing.assert_allclose(residual[used], expected_residual, rtol=1e-9, atol=1e-12)


def test_folding_in_pieces_is_folding_at_once():
    rows = np.random.default_rng(4).standard_normal((40, 5))
    rows[:, 2] = 0.0  # a parameter that does nothing
    triangle, block = np.zeros((5, 5)), np.zeros((5, BLOCK))
    for begin in range(0, 40, 8):
        block[:, :8] = rows[begin : begin + 8].T
        fold(triangle, block, 8)
    np.testing.assert_allclose(triangle.T @ triangle, rows.T @ rows, atol=1e-12)


@pytest.mark.parametrize("initial", [False, True])
def test_costs_of_many_denominators_are_those_of_one_after_the_other(initial):
    experiments = [experiment(Acquisition(0.1), initial=initial)]
    structure = Structure.of_order(2, 1)
    records = Records.of(experiments)
    denominators = np.array([[1.0, 2.0, 30.0], [1.0, 0.5, 4.0], [1.0, 40.0, 900.0]])
    costs = output_error_costs(
        denominators, structure.numerator, structure.free_numerator, 2 if initial else 0, records
    )
    for denominator, cost in zip(denominators, costs, strict=True):
        predictor = Predictor.around(structure, experiments, denominator)
        scaled = denominator * predictor.time_unit ** np.arange(3)
        assert cost == pytest.approx(predictor.solve_numerator(scaled)[1], rel=1e-9)


def test_a_simulation_that_overflows_costs_infinitely_much():
    experiments = [experiment(Acquisition(1e4))]
    predictor = Predictor(Structure.of_order(2, 0), experiments, 1.0)
    assert predictor.factorise(np.array([1.0, -1.0, 1.0]))[1] == np.inf
