import pytest

from camid.ablations.latency import runs as latency
from camid.ablations.pairing.drawing import draw
from camid.ablations.pairing.runs import compute, conclusion, quantities
from tests.support.ablations import shared

SHARED = shared(order=8)


@pytest.fixture(scope="module")
def table():
    settings = {"periods": [0.02, 0.04], "holds": ["foh", "zoh"], "shifts": [0, 1, 2], "methods": ["srivc"]}
    return compute(settings, SHARED)


def test_only_a_first_order_hold_with_the_next_frame_has_no_bias(table):
    largest = table.set_index(["hold", "shift"])[["error_b0", "error_a1", "error_a0"]].abs().max(axis=1)
    assert largest[("foh", 1)].max() < 1e-9
    assert largest.drop(("foh", 1)).min() > 0.5


def test_a_frame_of_wrong_pairing_is_a_frame_of_undeclared_latency(table):
    late = latency.compute({"periods": [0.04], "latencies": [1.0]}, SHARED)
    undeclared = late[~late["declared"]].iloc[0]
    paired = table[(table["hold"] == "foh") & (table["shift"] == 0) & (table["period"] == 0.04)].iloc[0]
    for p in ("b0", "a1", "a0"):
        assert paired[f"error_{p}"] == pytest.approx(undeclared[f"error_{p}"], abs=0.15)
    assert paired["error_a0"] < -5.0


def test_conclusion_follows_the_numbers(table):
    value = {name: number for name, (number, _) in quantities(table).items()}
    assert "w[k+1] has no bias" in conclusion(value)
    assert "No pairing makes a zero-order hold right" in conclusion(value)
    other = conclusion({**value, "foh_1_at_0.02": 5.0, "zoh_0_at_0.04": 0.0})
    assert "biased by up to 5 %" in other
    assert "Some pairing makes a zero-order hold right" in other


def test_figure_draws_the_default_method(table):
    figure, drawn = draw(table)
    assert len(figure.axes) == 3
    assert len(drawn) == 12
