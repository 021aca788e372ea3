import numpy as np
import pandas as pd
import pytest

from camid.ablations.signal_to_noise.drawing import draw
from camid.ablations.signal_to_noise.runs import by_level, compute, conclusion, quantities
from tests.support.ablations import shared

SHARED = shared(order=8)


@pytest.fixture(scope="module")
def table():
    return compute({"period": 0.1, "levels": [10, 20], "noise_samples": 30}, SHARED)


def test_errors_lie_on_the_bound_which_is_proportional_to_the_noise(table):
    found = {name: value for name, (value, _) in quantities(table).items()}
    for p in ("b0", "a1", "a0"):
        assert found[f"bound_{p}_at_10_dB"] / found[f"bound_{p}_at_20_dB"] == pytest.approx(np.sqrt(10.0))
    # Mean of 90 squared standard normal variables, three standard deviations of it.
    assert found["mean_chi_square_at_10_dB"] == pytest.approx(1.0, abs=3.0 * np.sqrt(2.0 / 90.0))


def made_up(gross_at_zero):
    levels = [0.0, 10.0, 20.0]
    return pd.DataFrame(
        {"level": level, "sample": s, "converged": not (level == 0.0 and s < gross_at_zero), "chi_square": 3.0}
        | {f"error_{p}": 1.0 for p in ("b0", "a1", "a0")}
        | {f"bound_{p}": 1.0 for p in ("b0", "a1", "a0")}
        for level in levels
        for s in range(4)
    )


def test_a_gross_failure_leaves_the_bound():
    assert quantities(made_up(0))["keeps_to_bound_from"][0] == 0.0
    found = quantities(made_up(1))
    assert found["keeps_to_bound_from"][0] == 10.0
    assert found["gross_below"][0] == 25.0
    assert list(by_level(made_up(1))["gross"]) == [1, 0, 0]


def test_conclusion_follows_the_numbers():
    whole = conclusion({name: value for name, (value, _) in quantities(made_up(0)).items()})
    broken = conclusion({name: value for name, (value, _) in quantities(made_up(1)).items()})
    assert "every level down to 0 dB" in whole
    assert "down to 10 dB and leaves it below: at 0 dB, 25 %" in broken


def test_figure_shows_every_level(table):
    figure, drawn = draw(table)
    assert len(figure.axes) == 2
    assert list(drawn["level"]) == [10.0, 20.0]
