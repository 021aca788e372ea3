import numpy as np
import pytest

from camid.ablations.excitation_length.drawing import draw
from camid.ablations.excitation_length.runs import by_length, compute, conclusion, quantities
from tests.support.ablations import shared

SHARED = shared()
SETTINGS = {
    "period": 0.05,
    "orders": [6, 7, 8],
    "repeated_order": 6,
    "periods": [16, 32],
    "signal_to_noise_ratio": 10.0,
    "noise_samples": 3,
    "run_in": 100,
}


@pytest.fixture(scope="module")
def table():
    return compute(SETTINGS, SHARED)


def test_information_grows_in_proportion_to_the_record(table):
    lengths = by_length(table).set_index("length")
    for p in ("b0", "a1", "a0"):
        # Every further period adds the same information.
        assert lengths[f"bound_{p}"][16 * 63] / lengths[f"bound_{p}"][32 * 63] == pytest.approx(np.sqrt(2.0), rel=0.04)
        assert np.all(lengths[f"bound_unknown_start_{p}"] >= lengths[f"bound_{p}"])


def test_a_moving_start_declared_at_rest_biases_short_records_most(table):
    lengths = by_length(table)
    repeated = lengths[lengths["kind"] == "periods"].set_index("length")
    assert abs(repeated["moving_start_b0"][32 * 63]) < abs(repeated["moving_start_b0"][16 * 63])


def test_a_bound_of_one_over_root_n_has_the_exponent_of_one_half_and_loses_nothing(table):
    made_up = table.copy()
    for p in ("b0", "a1", "a0"):
        made_up[f"bound_{p}"] = 3.0 / np.sqrt(made_up["length"])
    found = {name: value for name, (value, _) in quantities(made_up).items()}
    assert found["exponent_b0"] == pytest.approx(-0.5)
    assert found["exponent_longest_a0"] == pytest.approx(-0.5)
    assert found["lost_at_start"] == pytest.approx(0.0, abs=1e-9)
    assert found["repeated_over_order_a1"] == pytest.approx(1.0)


def test_conclusion_follows_the_numbers(table):
    value = {name: number for name, (number, _) in quantities(table).items()}
    for p in ("b0", "a1", "a0"):
        value |= {"mean_ratio": 1.0, f"repeated_over_order_{p}": 1.0, f"exponent_longest_{p}": -0.5}
    assert "lie on the Cramér–Rao bound" in conclusion(value)
    assert "as good as a longer register" in conclusion(value)
    assert "falls as 1/√N" in conclusion(value)
    other = conclusion(
        {
            **value,
            "mean_ratio": 2.0,
            "exponent_longest_b0": -1.0,
            "repeated_over_order_b0": 1.6,
            "unknown_start_costs": 9,
        }
    )
    assert "at 2.00 times the Cramér–Rao bound" in other
    assert "worse than a longer register" in other
    assert "falls as 1/√N" not in other
    assert "at most 9 %" in other


def test_figure_has_a_row_for_each_length(table):
    figure, drawn = draw(table)
    assert len(figure.axes) == 3
    assert len(drawn) == 5
