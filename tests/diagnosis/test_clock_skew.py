"""A camera whose clock is fast shows motion after the last recorded input, and after the last row that is fitted."""

import numpy as np
import pandas as pd
import pytest
from scipy.signal import lsim

import camid

PERIOD, COUNT, FINE, SKEW = 0.02, 1500, 50, 0.003
SIMULATION = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [60.0], "denominator": [1.0, 2.0, 60.0]}},
    "sensor": {"column": "y", "kind": "instant"},
}


@pytest.fixture(scope="module")
def recording():
    """Steps of the command, the last of which goes on, and positions at times that run ahead of it."""
    random = np.random.default_rng(np.random.SeedSequence(5))
    signal = np.repeat(random.choice([-1.0, 1.0], COUNT // 10), 10)
    held = np.repeat(np.append(signal, np.full(COUNT // 50, signal[-1])), FINE)
    times = PERIOD / FINE * np.arange(len(held))
    moved = lsim(([60.0], [1.0, 2.0, 60.0]), held, times, interp=False)[1]
    rows = PERIOD * np.arange(COUNT)
    return pd.DataFrame({"t": rows, "u": signal, "y": np.interp((1.0 + SKEW) * rows, times, moved)})


def test_the_last_rows_go_on_with_the_last_input(recording):
    effects = [{"id": "clock-skew", "parameters": {"skew": SKEW}}]
    simulated = camid.simulate(recording, SIMULATION | {"effects": effects})["simulated"]
    assert np.max(np.abs(simulated - recording["y"])) < 1e-3


def test_a_skew_that_is_declared_goes_on_too(recording):
    sensor = {"column": "y", "kind": "instant", "skew": SKEW}
    simulated = camid.simulate(recording, SIMULATION | {"sensor": sensor})["simulated"]
    assert np.max(np.abs(simulated - recording["y"])) < 1e-3


def test_the_last_rows_that_are_fitted_are_no_shift_of_the_measurement(recording):
    """Motion that stood still after them was one, by as much as it had been wrong."""
    noise = 0.01 * np.random.default_rng(np.random.SeedSequence(6)).standard_normal(COUNT)
    found = camid.diagnose(recording.assign(y=recording["y"] + noise), SIMULATION)
    (finding,) = found.findings
    assert (finding.identifier, found.verdict) == ("clock-skew", "explained")
    skew = finding.parameters["skew"]
    assert abs(skew.value - SKEW) < 4.0 * skew.standard_deviation < 0.01 * SKEW
