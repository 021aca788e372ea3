import numpy as np
import pytest

from camid.ablations.two_amplitudes.drawing import draw
from camid.ablations.two_amplitudes.runs import SIGNALS, compute, conclusion, film, quantities
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.excitation import multilevel, pseudo_random_binary_sequence
from camid.chain.plant import second_order
from tests.support.ablations import shared

SHARED = shared()
SETTINGS = {
    "period": 0.05,
    "order": 7,
    "ratio": 2.0,
    "levels": 5,
    "highest_frequency": 25.0,
    "stiffness": 0.02,
    "half_width": 0.2,
    "signal_to_noise_ratio": 100.0,
    "noise_samples": 2,
    "integration_steps": 20,
}


@pytest.fixture(scope="module")
def table():
    return compute(SETTINGS, SHARED)


def test_the_integrator_agrees_with_the_exact_chain_where_the_plant_is_linear():
    signal = multilevel(7, 4, np.random.default_rng(1))
    exact = sample(second_order(1.0, 10.0, 0.1), signal, Acquisition(0.05))
    assert film(signal, 0.05, 40, 100.0, 2.0, 100.0, 0.0, 0.0) == pytest.approx(exact, abs=1e-7)


def test_the_cubic_stiffness_agrees_with_scipy():
    from scipy.integrate import solve_ivp

    def motion(_, state):
        y, v, _ = state
        return [v, 100.0 * (1.0 - 0.3 * y**3) - 2.0 * v - 100.0 * y, y]

    solution = solve_ivp(motion, (0.0, 1.0), [0.0, 0.0, 0.0], t_eval=np.arange(21) * 0.05, rtol=1e-10, atol=1e-12)
    means = np.diff(solution.y[2]) / 0.05
    assert film(np.ones(21), 0.05, 40, 100.0, 2.0, 100.0, 0.3, 0.0)[1:] == pytest.approx(means, abs=1e-6)


def test_a_dead_zone_is_a_smaller_gain_to_two_levels():
    signal = pseudo_random_binary_sequence(7)
    dead = film(signal, 0.05, 20, 100.0, 2.0, 100.0, 0.0, 0.3)
    assert dead == pytest.approx(film(0.7 * signal, 0.05, 20, 100.0, 2.0, 100.0, 0.0, 0.0), abs=1e-12)


def test_two_amplitudes_tell_what_one_cannot(table):
    found = {name: value for name, (value, _) in quantities(table).items()}
    assert found["distortion_prbs_dead-zone"] < 1e-6
    assert found["gain_error_prbs_dead-zone"] == pytest.approx(-20.0, abs=1e-3)
    assert found["distortion_two-amplitudes_dead-zone"] > 0.03
    assert found["detected_two-amplitudes_dead-zone"] == 100.0
    assert found["detected_prbs_dead-zone"] == 0.0
    assert found["bound_two-amplitudes"] == pytest.approx(1.0, abs=0.1)


def test_conclusion_follows_the_numbers(table):
    value = {name: number for name, (number, _) in quantities(table).items()}
    assert "the dead zone is invisible" in conclusion(value)
    other = conclusion({**value, "distortion_prbs_dead-zone": 0.05, "bound_two-amplitudes": 0.5})
    assert "invisible" not in other
    assert "at most 50 % smaller" in other


def test_figure_draws_bounds_residuals_and_differences(table):
    figure, drawn = draw(table)
    assert len(figure.axes) == 3
    assert set(drawn["signal"]) == set(SIGNALS)
