"""An encoder that errs once a turn, on a shaft that turns once and a half."""

import numpy as np
import pandas as pd
from scipy.signal import cont2discrete, lfilter

import camid

PERIOD, COUNT = 0.01, 2500
TURN, AMPLITUDE, PHASE = 360.0, 2.0, 0.5


def test_less_than_two_turns_show_an_eccentricity():
    random = np.random.default_rng(np.random.SeedSequence(9))
    signal = np.repeat(random.uniform(-205.0, 205.0, COUNT // 50), 50)
    numerator, denominator, _ = cont2discrete(([90.0], [1.0, 9.0, 90.0]), PERIOD)
    angle = lfilter(numerator.ravel(), denominator, signal)
    assert 1.2 < np.ptp(angle) / TURN < 1.7
    error = AMPLITUDE * (np.sin(2.0 * np.pi * angle / TURN + PHASE) - np.sin(PHASE))
    table = pd.DataFrame({"t": PERIOD * np.arange(COUNT), "u": signal, "angle": angle + error})
    table["angle"] += 0.1 * random.standard_normal(COUNT)
    found = camid.diagnose(
        table,
        {
            "schema": 1,
            "time": {"column": "t"},
            "input": {"column": "u", "hold": "zoh"},
            "plant": {"transfer_function": {"numerator": [80.0], "denominator": [1.0, 8.0, 80.0]}},
            "sensor": {"column": "angle", "kind": "instant"},
        },
    )
    (finding,) = found.findings
    assert (finding.identifier, found.verdict) == ("encoder-eccentricity", "explained")
    for name, true in {"period": TURN, "amplitude": AMPLITUDE}.items():
        estimate = finding.parameters[name]
        assert abs(estimate.value - true) < 4.0 * estimate.standard_deviation < 0.05 * true
