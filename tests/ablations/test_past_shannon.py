import pytest

from camid.ablations.past_shannon.drawing import draw
from camid.ablations.past_shannon.runs import compute, conclusion, quantities
from tests.support.ablations import shared

SHARED = shared(seed=5)
SETTINGS = {
    "signal_to_noise_ratio": 10.0,
    "products": [4.0],
    "nominal_error": 0.05,
    "seeds": 15,
    "seeds_without_nominal": 10,
    "bounds": [4.0, 9.0],
    "curve": {"start": 3.2, "stop": 6.0, "points": 5},
    "likelihood_product": 4.0,
}


@pytest.fixture(scope="module")
def table():
    return compute(SETTINGS, SHARED)


def test_bounds_are_those_computed_independently(table):
    found = quantities(table)
    assert found["bound_frequency_at_4"][0] == pytest.approx(0.37, abs=0.005)
    assert found["bound_frequency_at_9"][0] == pytest.approx(1.35, abs=0.005)


def test_alias_is_told_apart_and_the_frequency_found(table):
    found = quantities(table)
    assert found["deviance_of_alias"][0] > 100.0
    assert found["nominal_at_4_wrong_frequency"][0] == 0.0
    assert found["nothing_at_4_wrong_frequency"][0] == 0.0


def test_conclusion_follows_the_numbers(table):
    value = {k: v for k, (v, _) in quantities(table).items()}
    assert "no fits state a wrong frequency" in conclusion(value)
    assert "up to 7.0 % of the fits" in conclusion({**value, "nothing_at_4_confidently_wrong": 7.0})
    assert "median error is" in conclusion({**value, "nominal_at_4_ratio": 9.0})


def test_figure_has_bound_and_likelihood(table):
    figure, plotted = draw(table)
    assert len(figure.axes) == 2
    assert {"bound", "deviance"} <= set(plotted["kind"])
