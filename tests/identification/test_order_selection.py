"""The order of simulated plants is found, and what is wrong with the other orders is said."""

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.identification.estimate import estimate
from camid.identification.experiment import Experiment
from camid.identification.order_selection import cancels, poles_determined, select_order
from camid.identification.structure import Structure
from tests.identification.test_residual_analysis import excite, film

PERIOD = 0.05
SLOW, FAST = [1.0, 1.5, 100.0], [1.0, 2.0, 400.0]
PLANTS = {
    "one pole": ([5.0], [1.0, 5.0]),
    "mode": ([100.0], [1.0, 2.0, 100.0]),
    "mode with a zero": ([10.0, 100.0], [1.0, 3.0, 100.0]),
    "mode and pole": ([400.0], np.polymul([1.0, 2.0, 100.0], [1.0, 4.0])),
    "mode, pole and two zeros": ([8.0, 60.0, 400.0], np.polymul([1.0, 2.0, 100.0], [1.0, 4.0])),
    "two modes": ([40000.0], np.polymul(SLOW, FAST)),
    "two modes and zeros": ([400.0 / 2.25, 400.0 / 2.25, 40000.0], np.polymul(SLOW, FAST)),
}


def experiments(plant, seed, decibel, count=511, several=1):
    generator = np.random.default_rng(np.random.SeedSequence(2008, spawn_key=(seed,)))
    made = []
    for _ in range(several):
        signal = excite("prbs", count, generator)
        output = film(plant, signal, period=PERIOD)
        output = output + 10.0 ** (-decibel / 20.0) * np.std(output) * generator.standard_normal(count)
        made.append(Experiment(signal, output, Acquisition(PERIOD), np.ones(count, bool)))
    return made


def order(plant):
    return len(plant[1]) - 1, len(plant[0]) - 1


@pytest.mark.parametrize("name", PLANTS)
def test_the_order_is_found(name):
    right = 0
    for seed, decibel in ((0, 20.0), (1, 30.0)):
        largest = min(order(PLANTS[name])[0] + 1, 4)
        found = select_order(experiments(PLANTS[name], seed, decibel), largest)
        right += (found.poles, found.zeros) == order(PLANTS[name])
        assert found.explained
        assert found.warnings() == []
    assert right == 2


def test_the_table_says_why():
    plant = PLANTS["mode"]
    found = select_order(experiments(plant, 3, 20.0), 3)
    table = found.table
    assert list(zip(table["poles"], table["zeros"], strict=True)) == [(1, 0), (2, 0), (2, 1), (3, 0), (3, 1), (3, 2)]
    assert table["weight"].sum() == pytest.approx(1.0)
    assert table["delta_bic"].min() == 0.0
    assert table["delta_aicc"].min() == 0.0
    expected = np.exp(-0.5 * table["delta_bic"]) / np.exp(-0.5 * table["delta_bic"]).sum()
    np.testing.assert_allclose(table["weight"], expected)
    row = table[table["chosen"]].iloc[0]
    assert (row["poles"], row["zeros"], row["parameters"]) == (2, 0, 3)
    assert row["nrmse"] == pytest.approx(0.1, rel=0.15)
    assert row["passes"]
    first = table.iloc[0]
    assert first["independence_p"] < 1e-6
    assert not first["passes"]
    # A pole more than there are: it cancels, or nothing determines it.
    rich = table[table["poles"] == 3]
    assert not (rich["converged"] & rich["determined"] & ~rich["cancels"]).any()
    mapping = found.to_mapping()
    assert (mapping["poles"], mapping["zeros"]) == (2, 0)
    assert len(mapping["candidates"]) == 6


def test_an_invisible_mode_is_not_asked_for():
    """A second mode with a thousandth of the first one's motion."""
    slow, fast = np.array([1.0, 2.0, 100.0]), np.array([1.0, 4.0, 400.0])
    plant = (np.polyadd(100.0 * fast, 0.4 * slow), np.polymul(slow, fast))
    found = select_order(experiments(plant, 0, 20.0), 4)
    assert (found.poles, found.zeros) == (2, 0)


def test_several_recordings_count_together():
    plant = PLANTS["mode with a zero"]
    found = select_order(experiments(plant, 4, 20.0, count=150, several=3), 2)
    assert (found.poles, found.zeros) == (2, 1)
    assert found.table["parameters"].tolist() == [2, 3, 4]


def test_the_progress_is_told():
    told = []
    select_order(experiments(PLANTS["one pole"], 0, 30.0), 2, progress=told.append)
    assert told == ["order 1 0 (1 of 3)", "order 2 0 (2 of 3)", "order 2 1 (3 of 3)"]


def test_a_recording_without_noise_gives_the_order():
    found = select_order(experiments(PLANTS["mode"], 0, 400.0), 3)
    assert (found.poles, found.zeros) == (2, 0)


def test_a_wrong_declaration_is_not_hidden_by_a_high_order():
    """With the hold declared wrongly no low order passes, and that is said."""
    wrong = [
        Experiment(e.signal, e.output, Acquisition(PERIOD, "foh", "instant", None, 1.5 * PERIOD), e.used)
        for e in experiments(PLANTS["mode"], 0, 40.0)
    ]
    found = select_order(wrong, 2)
    assert not found.explained
    assert "hold" in found.warnings()[0]


def test_zeros_and_poles_that_cancel_are_seen():
    (one,) = experiments(PLANTS["one pole"], 5, 20.0)
    rich = estimate(Structure.of_order(2, 1), [one])
    right = estimate(Structure.of_order(1, 0), [one])
    assert cancels(rich) or not poles_determined(rich, 25.0)
    assert not cancels(right)
    assert poles_determined(right, 25.0)
    # Two different modes with zeros between them cancel nothing.
    (two,) = experiments(PLANTS["two modes and zeros"], 5, 30.0)
    assert not cancels(estimate(Structure.of_order(4, 2), [two]))


def test_what_is_refused():
    (one,) = experiments(PLANTS["mode"], 0, 20.0)
    with pytest.raises(ValueError, match="at least one"):
        select_order([one], 0)
    silent = Experiment(np.zeros(511), one.output, one.acquisition, one.used, True)
    with pytest.raises(ValueError, match="without an input"):
        select_order([silent], 2)
    with pytest.raises(ValueError, match="no order can be estimated"):
        select_order([Experiment(one.signal[:4], one.output[:4], one.acquisition, one.used[:4])], 2)
