"""An initial state of which the rows that are compared say nothing any more."""

import numpy as np
import pandas as pd
import pytest
from scipy.signal import cont2discrete, lfilter

import camid
from tests.support.mass_on_spring import simulation

PERIOD, NOISE = 0.09, 0.07
TRUE = {
    "numerator": [616.0],
    "denominator": [1.0, 12.68, 43.35, 103.36],
}  # its fastest pole decays in a tenth of a second
BELIEVED = {"numerator": [690.0], "denominator": [1.0, 13.4, 47.6, 112.8]}


def recording(seed=1, before=400, count=1600):
    """Samples of a plant that was driven before the record begins."""
    random = np.random.default_rng(seed)
    signal = np.repeat(random.choice([-1.5, 1.5], (before + count) // 4 + 1), 4)[: before + count]
    numerator, denominator, _ = cont2discrete((TRUE["numerator"], TRUE["denominator"]), PERIOD, "zoh")
    output = lfilter(np.ravel(numerator), denominator, signal)[before:] + NOISE * random.standard_normal(count)
    return pd.DataFrame({"t": PERIOD * np.arange(count), "u": signal[before:], "y": output})


def believed(**changes):
    instant = {"column": "y", "kind": "instant", "offset": 0.0}
    return simulation(plant={"transfer_function": BELIEVED}, sensor=instant, initial_state="estimate", **changes)


@pytest.mark.parametrize("left_out", [0.0, 3.0, 6.0, 20.0])
def test_rounding_errors_of_it_are_no_noise(left_out):
    table = recording()
    found = camid.identify(table, believed(recording={"leave_out": left_out}))
    assert found.converged
    plant = found.simulation.plant.monic
    np.testing.assert_allclose(plant.denominator, TRUE["denominator"], rtol=0.02)
    rows = table["t"] >= left_out
    left = (table["y"] - camid.simulate(table, found.simulation)["simulated"])[rows]
    assert np.std(left) == pytest.approx(NOISE, rel=0.05)


@pytest.mark.parametrize(("seed", "before"), [(4, 300), (6, 300), (7, 301)])
def test_nothing_is_named_where_it_has_decayed_before_the_rows_that_are_compared(seed, before):
    diagnosis = camid.diagnose(recording(seed, before, 2080), believed())
    assert diagnosis.verdict == "adequate"
