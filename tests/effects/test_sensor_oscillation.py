"""What hums in the reading moves nothing, and is told from a force by how that begins."""

import numpy as np
import pandas as pd
import pytest
from scipy.signal import lsim

import camid

PERIOD, COUNT, FINE = 0.02, 1200, 20
PLANT = ([40.0], [1.0, 3.0, 40.0])
AMPLITUDE, ANGULAR, PHASE = 0.08, 19.5, 0.9


def simulation(start):
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [33.0], "denominator": [1.0, 3.6, 36.0]}},
        "sensor": {"column": "y", "kind": "instant"},
        "initial_state": start,
    }


def recording(force, hum):
    """A rig that rests before the recording, under a command and a sinusoid that is a force or in the reading."""
    random = np.random.default_rng(np.random.SeedSequence(21))
    signal = np.repeat(random.choice([-1.0, 1.0], COUNT // 12), 12)
    times = PERIOD / FINE * np.arange(COUNT * FINE)
    wave = np.sin(ANGULAR * times + PHASE)
    moved = lsim(PLANT, np.repeat(signal, FINE) + force * wave, times, interp=False)[1]
    output = (moved + hum * wave)[::FINE] + 0.01 * random.standard_normal(COUNT)
    return pd.DataFrame({"t": times[::FINE], "u": signal, "y": output})


def test_a_hum_of_the_reading_is_found():
    found = camid.diagnose(recording(0.0, AMPLITUDE), simulation("zero"))
    (finding,) = found.findings
    assert (finding.identifier, found.location.place, found.verdict) == ("sensor-oscillation", "sensor", "explained")
    for name, true in {"amplitude": AMPLITUDE, "frequency": ANGULAR, "phase": PHASE}.items():
        estimate = finding.parameters[name]
        assert abs(estimate.value - true) < 4.0 * estimate.standard_deviation < 0.1 * true
    again = camid.diagnose(recording(0.0, AMPLITUDE), found.improved)
    assert again.verdict == "adequate"


def test_a_periodic_force_is_none():
    found = camid.diagnose(recording(0.2, 0.0), simulation("zero"))
    (finding,) = found.findings
    assert finding.identifier == "periodic-disturbance"
    assert dict(finding.alternatives).get("sensor-oscillation", 0.0) < 0.05


@pytest.mark.parametrize(("force", "hum"), [(0.2, 0.0), (0.0, AMPLITUDE)])
def test_where_the_start_is_open_neither_is_excluded(force, hum):
    """The likelier one leads, and the other one is listed."""
    (finding,) = camid.diagnose(recording(force, hum), simulation("estimate")).findings
    weights = {finding.identifier: finding.weight} | dict(finding.alternatives)
    assert weights["periodic-disturbance"] > weights["sensor-oscillation"] > 0.1
