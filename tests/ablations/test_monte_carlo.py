import numpy as np
import pandas as pd
import pytest

from camid.ablations.monte_carlo.drawing import draw
from camid.ablations.monte_carlo.runs import combine, compute, compute_shard, conclusion, quantities, shard_seeds
from tests.support.ablations import shared

SHARED = shared(seed=5, sampling_period_sweep={"start": 0.1, "stop": 0.2, "step": 0.1})
SETTINGS = {"signal_to_noise_ratio": 10.0, "seeds": 30, "shards": 3}


@pytest.fixture(scope="module")
def table():
    return compute(SETTINGS, SHARED)


def test_shards_share_the_seeds_out():
    assert sorted(s for shard in range(3) for s in shard_seeds(10, shard, 3)) == list(range(10))


def test_any_number_of_shards_gives_the_same_sums(table):
    whole = combine([compute_shard(SETTINGS, SHARED, range(30))])
    pd.testing.assert_frame_equal(table, whole, rtol=1e-9)


def test_a_few_seeds_lie_on_the_bound(table):
    found = quantities(table)
    for parameter in ("b0", "a1", "a0"):
        # 60 errors: a root mean square scatters by 9 %.
        assert found[f"ratio_{parameter}"][0] == pytest.approx(1.0, abs=0.35)
        assert found[f"coverage_{parameter}"][0] > 85.0
    assert found["gross_failures"][0] == 0


def test_conclusion_follows_the_numbers(table):
    value = {k: v for k, (v, _) in quantities(table).items()}
    failed = {**value, "ratio_a1": 1.3, "gross_failures": 4.0}
    assert "misses" in conclusion(failed)
    assert "4 gross failures" in conclusion(failed)
    assert "misses" not in conclusion({**value, **dict.fromkeys(("ratio_b0", "ratio_a1", "ratio_a0"), 1.0)})


def test_figure_shows_every_period(table):
    figure, plotted = draw(table)
    assert len(figure.axes) == 2
    assert set(np.round(plotted["period"], 3)) == {0.1, 0.2}
