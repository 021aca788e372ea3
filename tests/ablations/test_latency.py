import numpy as np
import pytest

from camid.ablations.latency.drawing import draw
from camid.ablations.latency.runs import compute, conclusion, first_order_bias, quantities
from camid.chain.acquisition import Acquisition
from camid.chain.excitation import pseudo_random_binary_sequence
from camid.chain.plant import second_order
from tests.support.ablations import shared

SHARED = shared(order=8)


@pytest.fixture(scope="module")
def table():
    return compute({"periods": [0.05], "latencies": [0.0, 0.02, 1.0]}, SHARED)


@pytest.mark.parametrize(("frequency", "damping"), [(10.0, 0.1), (7.0, 0.3), (10.0, 0.5)])
def test_a_white_input_gives_the_closed_form(frequency, damping):
    plant = second_order(1.7, frequency, damping)
    bias = first_order_bias(plant, pseudo_random_binary_sequence(16), Acquisition(0.01))
    assert bias == pytest.approx(-2.0 * damping * frequency, rel=0.05)


def test_small_latencies_follow_the_projection_and_declared_ones_cost_nothing(table):
    found = {name: value for name, (value, _) in quantities(table).items()}
    assert found["largest_declared"] < 1e-9
    small = table[~table["declared"] & (table["latency"] == 0.02)].iloc[0]
    for p in ("b0", "a1", "a0"):
        assert small[f"error_{p}"] == pytest.approx(small[f"first_order_{p}"], rel=0.03, abs=2e-3)
    assert np.sign(small["error_a0"]) == -1.0


def test_conclusion_follows_the_numbers(table):
    value = {name: number for name, (number, _) in quantities(table).items()}
    assert "costs nothing" in conclusion(value)
    assert " follow the first-order rule" in conclusion(value)
    other = conclusion({**value, "largest_declared": 2.0, "a0_per_millisecond_at_0.05": 0.7})
    assert "still costs up to 2 %" in other
    assert "do not follow" in other


def test_figure_draws_every_run(table):
    figure, drawn = draw(table)
    assert len(figure.axes) == 3
    assert len(drawn) == len(table)
