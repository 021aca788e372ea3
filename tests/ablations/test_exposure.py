import pytest

from camid.ablations.exposure.drawing import draw
from camid.ablations.exposure.runs import compute, conclusion, quantities
from tests.support.ablations import shared

SHARED = shared(order=8)


@pytest.fixture(scope="module")
def table():
    return compute({"periods": [0.05], "exposures": [0.1, 1.0]}, SHARED)


def test_biases_are_those_of_theory(table):
    found = {name: value for name, (value, _) in quantities(table).items()}
    assert found["largest_exact"] < 1e-9
    assert found["foh_at_full_exposure"] < 1e-9
    # cos x - sin(x)/x = -x²/3 and 1 - sin(x)/x = x²/6: Model #2 errs twice as much as Model #3, the other way.
    assert found["ratio_model-2_to_model-3"] == pytest.approx(-2.0, abs=0.01)
    # Half of 0.9 frames of lag that are not there: 2ξω0 · 22.5 ms = 4.5 % of a0.
    row = table[(table["model"] == "first-order-hold") & (table["exposure"] == 0.1)].iloc[0]
    assert row["error_a0"] == pytest.approx(4.5, rel=0.2)


def test_conclusion_follows_the_numbers(table):
    value = {name: number for name, (number, _) in quantities(table).items()}
    sentence = conclusion(value)
    assert "there is no bias" in sentence
    assert "half as wrong" in sentence
    other = conclusion({**value, "largest_exact": 3.0, "foh_at_full_exposure": 2.0, "ratio_model-2_to_model-3": 4.0})
    assert "largest bias is 3 %" in other
    assert "errs by 2 % even at 1 T" in other
    assert "half as wrong" not in other


def test_figure_has_a_panel_for_each_parameter_and_period(table):
    figure, drawn = draw(table)
    assert len(figure.axes) == 3
    assert len(drawn) == 10
