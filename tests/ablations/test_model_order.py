import numpy as np
import pandas as pd
import pytest

from camid.ablations.model_order.drawing import draw
from camid.ablations.model_order.runs import TRUE_POLES, by_order, compute, conclusion, quantities
from tests.support.ablations import shared

SHARED = shared()
SETTINGS = {
    "period": 0.05,
    "natural_frequency": 40.0,
    "damping": 0.1,
    "orders": [2, 4],
    "signal_to_noise_ratio": 10.0,
    "noise_samples": 2,
    "selected_samples": 1,
    "largest_selected": 2,
}


@pytest.fixture(scope="module")
def table():
    return compute(SETTINGS, SHARED)


def test_penalties_are_those_of_akaike_and_schwarz(table):
    # Two more coefficients: 2 · 2 against 2 · ln 512.
    difference = (table["bayes"] - table["akaike"]).groupby(table["poles"]).mean()
    assert difference[4] - difference[2] == pytest.approx(2.0 * np.log(512) - 4.0)


def test_the_true_order_simulates_best_and_is_chosen(table):
    orders = by_order(table).set_index(["plant", "poles"])
    # The rms of the projection of white noise on k coefficients: σ sqrt(k/N).
    assert orders["nrmse_true"][("one mode", 2)] == pytest.approx(np.sqrt(0.1 * 3 / 512), rel=0.9)
    assert orders["nrmse_true"][("two modes", 4)] < 0.5 * orders["nrmse_true"][("two modes", 2)]
    assert orders["chosen_bayes"][("two modes", 4)] == 1.0
    assert quantities(table)["selected_2"][0] == 100.0


def made_up(best):
    return pd.DataFrame(
        {
            "plant": plant,
            "poles": poles,
            "sample": 0,
            "converged": True,
            "akaike": 0.0 if poles == 6 else 1.0,
            "bayes": 0.0 if poles == best(plant) else 1.0,
            "nrmse_fresh": 0.3,
            "nrmse_true": 0.01 * poles,
            "largest_relative_deviation": 0.1,
            "frequency_error": 0.1,
            "damping_error": 0.1,
            "selected_poles": 2.0,
            "selected_zeros": 0.0,
        }
        for plant in TRUE_POLES
        for poles in (2, 4, 6)
    )


def test_conclusion_follows_the_numbers():
    def sentence(best):
        return conclusion({name: value for name, (value, _) in quantities(made_up(best)).items()})

    assert "finds the true order in 100 and 0 % of the records" in sentence(TRUE_POLES.get)
    assert "Bayes's criterion alone (100 and 100 % of 1) is more reliable" in sentence(TRUE_POLES.get)
    assert "Too many poles cost more than too few" in sentence(TRUE_POLES.get)
    assert "Bayes's criterion alone (0 and 0 % of 1) is no more reliable" in sentence(lambda _: 6)


def test_figure_draws_both_plants(table):
    figure, drawn = draw(table)
    assert len(figure.axes) == 3
    assert set(drawn["plant"]) == set(TRUE_POLES)
