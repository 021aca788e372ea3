"""A reading that is rounded errs by the same for as long as it keeps its value, which is no physics."""

import numpy as np
import pandas as pd
import pytest
from scipy.signal import cont2discrete, lfilter
from scipy.stats import norm

import camid
from camid.diagnosis.pruning.rounding import log_likelihood
from tests.support.mass_on_spring import effect, record, simulation

PERIOD, COUNT, STEP = 0.01, 3000, 0.05
SIMULATION = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [95.0], "denominator": [1.0, 12.0, 90.0]}},
    "sensor": {"column": "y", "kind": "instant"},
}


def recording():
    """Pulses of many sizes, with rests between them."""
    random = np.random.default_rng(np.random.SeedSequence(14))
    signal = np.zeros(COUNT)
    for first in range(50, COUNT - 200, 200):
        signal[first : first + 40] = random.uniform(-3.0, 3.0)
    numerator, denominator, _ = cont2discrete(([100.0], [1.0, 12.0, 100.0]), PERIOD)
    position = lfilter(numerator.ravel(), denominator, signal)
    return pd.DataFrame({"t": PERIOD * np.arange(COUNT), "u": signal, "y": STEP * np.round(position / STEP)})


def test_rounding_is_named_alone():
    assert [f.identifier for f in camid.diagnose(recording(), SIMULATION).findings] == ["quantisation"]


def test_friction_is_named_beside_it():
    """And not a law with one number more, which follows the rounding."""
    table = record(effect("coulomb-friction", force=0.2), count=1500, noise=0.0)
    table["y"] = 0.1 * np.round(table["y"] / 0.1)
    found = camid.diagnose(table, simulation())
    assert [f.identifier for f in found.findings] == ["coulomb-friction", "quantisation"]
    force = found.findings[0].parameters["force"]
    assert abs(force.value - 0.2) < 4.0 * force.standard_deviation < 0.1 * 0.2


def test_readings_that_are_rounded_have_a_likelihood():
    """The integral of the noise's density over what a reading may have been; at most one."""
    residual, step = np.array([0.0, 0.2, 0.45, 0.7]), 1.0
    found = log_likelihood(residual, step)
    shares = np.geomspace(0.01, 1.0, 400)
    exact = [
        np.sum(
            norm.logsf((residual - 0.5) / s)
            + np.log1p(-np.exp(norm.logsf((residual + 0.5) / s) - norm.logsf((residual - 0.5) / s)))
        )
        for s in shares
    ]
    assert found == pytest.approx(max(exact), abs=0.02)
    assert log_likelihood(np.array([0.1, -0.3]), step) > -1e-3
    assert np.isfinite(log_likelihood(np.array([0.0, 40.0]), step))
