import numpy as np
import pandas as pd
import pytest

from camid.ablations.identification_runs import percent_errors, whole_experiment
from camid.ablations.methods.drawing import draw
from camid.ablations.methods.runs import METHODS, by_method, compute, conclusion, continuous_time, quantities
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.excitation import pseudo_random_binary_sequence
from camid.chain.plant import second_order
from tests.support.ablations import shared

SHARED = shared()


@pytest.fixture(scope="module")
def table():
    return compute({"periods": [0.1], "signal_to_noise_ratio": 10.0, "noise_samples": 10}, SHARED)


@pytest.mark.parametrize("method", sorted(set(METHODS) - {"state-variable-filter"}))
def test_without_noise_every_consistent_method_is_right(method):
    plant = second_order(1.3, 10.0, 0.1)
    signal = pseudo_random_binary_sequence(8)
    found = METHODS[method](whole_experiment(signal, sample(plant, signal, Acquisition(0.1)), Acquisition(0.1)))
    assert percent_errors(found, plant) == pytest.approx(0.0, abs=1e-4)


def test_poles_that_no_plant_has_are_refused():
    assert continuous_time(np.array([1.0]), np.array([1.0, 1.5, 0.5]), 0.1) is None  # on the negative axis
    assert continuous_time(np.array([1.0]), np.array([1.0, -2.2, 1.4]), 0.1) is None  # outside of the unit circle


def test_efficient_methods_lie_near_the_bound_and_the_five_parameters_pay(table):
    results = by_method(table).set_index("method")
    for method in ("srivc", "output-error", "plain-srivc"):
        assert results["gross"][method] == 0
        # Ten samples: the rms over the bound is 1 ± 0.22.
        assert 0.3 < results["ratio_b0"][method] < 1.9
    assert results["ratio_b0"]["discrete-output-error"] > results["ratio_b0"]["srivc"]
    assert results["gross"]["state-variable-filter"] > 0


def made_up(failing):
    return pd.DataFrame(
        {"period": period, "method": method, "sample": s, "gross": method in failing and period > 0.1}
        | {f"error_{p}": 2.0 for p in ("b0", "a1", "a0")}
        | {f"bound_{p}": 1.0 for p in ("b0", "a1", "a0")}
        for method in METHODS
        for period in (0.1, 0.2)
        for s in range(2)
    )


def test_conclusion_follows_the_numbers():
    def sentence(failing):
        return conclusion({name: value for name, (value, _) in quantities(made_up(failing)).items()})

    assert "safeguarded SRIVC errs by 2 times the bound and never fails" in sentence(())
    assert "safeguarded SRIVC errs by 2 times the bound and fails in up to 100 % of the runs at T = 200 ms" in sentence(
        ("srivc",)
    )


def test_figure_draws_every_method(table):
    figure, drawn = draw(table)
    assert len(figure.axes) == 4
    assert set(drawn["method"]) == set(METHODS)
