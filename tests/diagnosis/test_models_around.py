"""A sensor without sign is found whatever the nominal coefficients: the refitted ones say nothing of the plant."""

import numpy as np
import pandas as pd
import pytest
from scipy.signal import lsim, lti

import camid

PERIOD, COUNT = 0.02, 700


def recording(offset=0.0):
    """A third-order drive under a random square wave, its speed counted without the sign; made with scipy alone."""
    random = np.random.default_rng(np.random.SeedSequence(71))
    signal = np.repeat(random.choice([-1.0, 1.0], COUNT // 20 + 1), 20)[:COUNT]
    fine = 20
    time = np.arange(COUNT * fine) * PERIOD / fine
    drive = lti([2.0 * 5.0 * 400.0], np.polymul([1.0, 5.0], [1.0, 4.0, 400.0]))
    _, speed, _ = lsim(drive, np.repeat(signal, fine), time, interp=False)
    counted = np.abs(speed[::fine]) + 0.02 * random.standard_normal(COUNT)
    return pd.DataFrame({"t": np.arange(COUNT) * PERIOD, "u": signal, "z": counted + offset})


def believed(frequency, time_constant, **sensor):
    denominator = np.polymul([time_constant, 1.0], [1.0, 0.2 * frequency, frequency**2])
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [frequency**2], "denominator": denominator.tolist()}},
        "sensor": {"column": "z", "kind": "instant", **sensor},
        "effects": [],
    }


@pytest.mark.parametrize(
    ("frequency", "time_constant"),
    [(40.0, 1.0), *(pytest.param(*case, marks=pytest.mark.slow) for case in ((10.0, 0.4), (30.0, 0.1)))],
)
def test_nominal_coefficients_do_not_matter(frequency, time_constant):
    diagnosis = camid.diagnose(recording(), believed(frequency, time_constant))
    assert diagnosis.findings[0].identifier == "absolute-value"
    assert diagnosis.fit.improved < 0.05
    a2, a1, a0 = (c.improved for c in diagnosis.coefficients[1:])
    assert np.sqrt(np.abs(np.roots([1.0, a2, a1, a0])).max()) == pytest.approx(np.sqrt(20.0), rel=0.02)
