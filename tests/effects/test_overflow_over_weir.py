"""A storage whose excess flows off over a weir, against the differential equation of its level."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.overflow_over_weir import OverflowOverWeir
from camid.effects.storage import Overflow
from camid.engine.mechanics import Chain
from camid.engine.run import run

RATE, GAIN, PERIOD, COUNT = 0.5, 2.0, 0.1, 1500
HEIGHT, WEIR = 1.0, 12.0


def levels(signal, sign=1.0):
    """Level at each row, shape (N,), of a storage that fills by ``sign`` times the signal."""
    level, found = 0.0, []
    for value in signal:
        found.append(level)

        def slope(_, now, given=sign * value):
            return RATE * (GAIN * (given - WEIR * max(now[0] - HEIGHT, 0.0) ** 1.5) - now)

        level = solve_ivp(slope, (0.0, PERIOD), [level], "LSODA", rtol=1e-9, atol=1e-11).y[0, -1]
    return sign * np.array(found)


@pytest.fixture(scope="module")
def signal():
    return np.repeat(np.random.default_rng(3).uniform(0.0, 1.5, COUNT // 10), 10)


@pytest.mark.parametrize(("sign", "gain"), [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)])
def test_the_level_follows_its_equation(signal, sign, gain):
    law = OverflowOverWeir(height=sign * gain * HEIGHT, weir=WEIR)
    plant = TransferFunction((gain * GAIN * RATE,), (1.0, RATE))
    chain = Chain(plant, Acquisition(period=PERIOD, hold="zoh", sensor="instant"), (law,))
    found = run(chain, sign * signal, PERIOD * np.arange(COUNT))
    expected = sign * gain * levels(signal)
    assert np.max(np.abs(found - expected)) < 1e-4 * np.std(expected)
    assert np.max(np.abs(expected)) > 1.05 * HEIGHT


def test_without_a_weir_the_level_ends_at_the_same_edge():
    plain = OverflowOverWeir(height=1.0, weir=3.0).simplified()
    assert type(plain) is Overflow
    assert plain.values["height"] == 1.0


SIMULATION = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [0.95], "denominator": [1.0, 0.53]}},
    "sensor": {"column": "y", "kind": "instant"},
}


def recorded(signal):
    """A recording of the storage with a little noise."""
    noise = 0.005 * np.random.default_rng(5).standard_normal(COUNT)
    return pd.DataFrame({"t": PERIOD * np.arange(COUNT), "u": signal, "y": levels(signal) + noise})


def test_an_edge_is_looked_for_where_the_recording_ends_and_not_where_a_model_without_one_goes():
    """A flood that the storage sees once in a while: the rest of the recording says what it is without an edge."""
    position, recording = np.array([-0.3, 0.0, 5.0]), np.array([-0.3, 0.0, 1.0])
    plant = TransferFunction((GAIN * RATE,), (1.0, RATE))
    seen = SimpleNamespace(rest=None, plant=plant, position=position, recorded=recording, used=np.ones(3, bool))
    heights = [law.values["height"] for law in Overflow.candidates(seen)]
    assert [h for h in heights if 0.9 < h < 1.0]
    assert any(h > 1.0 for h in heights)


@pytest.mark.slow
def test_it_is_named_beside_what_is_the_same_and_declared(signal):
    recording = recorded(signal)
    found = camid.diagnose(recording, SIMULATION)
    (finding,) = found.findings
    # A stop with a Hertz contact is the same force: nothing tells them apart.
    weights = {finding.identifier: finding.weight, **dict(finding.alternatives)}
    assert set(weights) >= {"overflow", "end-stop"}
    assert abs(weights["overflow"] - weights["end-stop"]) < 0.01
    weir = finding.parameters["weir" if finding.identifier == "overflow" else "hertz"]
    assert abs(weir.value - WEIR) < 4.0 * weir.standard_deviation
    again = camid.diagnose(recording, found.improved.to_mapping())
    assert again.verdict == "adequate"
