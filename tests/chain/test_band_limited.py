"""Band-limited inputs: straight lines that hold the same below the Shannon limit."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.hold import straight_line_corners
from camid.chain.plant import second_order

PERIOD, COUNT = 0.01, 2000
PLANT = second_order(1.0, 60.0, 0.05)


def multisine(highest):
    """Samples of a sum of sines that begins gently, and its exact response long after."""
    random = np.random.default_rng(np.random.SeedSequence(3))
    time = PERIOD * np.arange(COUNT)
    frequencies = np.sort(random.uniform(5.0, highest, 25))
    phases = random.uniform(0.0, 2.0 * np.pi, 25)
    response = PLANT.frequency_response(frequencies)
    # The mean over an exposure of a period ends at the frame.
    seen = response * np.sinc(frequencies * PERIOD / (2.0 * np.pi)) * np.exp(-0.5j * frequencies * PERIOD)
    waves = np.exp(1j * (np.outer(time, frequencies) + phases))
    return time, waves.sum(axis=1).real, (waves * seen).sum(axis=1).real


def test_response_is_that_of_the_band_limited_signal():
    """Far closer than with either hold, up to half of the Shannon limit."""
    _, signal, exact = multisine(0.5 * np.pi / PERIOD)
    errors = {}
    for hold in ("zoh", "foh", "band-limited"):
        found = sample(PLANT, signal, Acquisition(PERIOD, hold, "camera"))
        part = slice(COUNT // 2, COUNT - 200)  # behind the transient
        errors[hold] = np.sqrt(np.mean((found[part] - exact[part]) ** 2)) / np.std(exact[part])
    assert errors["band-limited"] < 2e-3
    assert errors["band-limited"] < 0.1 * errors["foh"] < errors["zoh"]


def test_corners_of_a_slow_signal_are_its_samples():
    signal = np.cos(np.pi * (np.arange(500) + 0.5) * 4 / 500)
    assert np.max(np.abs(straight_line_corners(signal) - signal)) < 2e-4


@pytest.mark.slow
def test_identified_and_named():
    """Coefficients without bias under the right hold; the wrong one is named by diagnose."""
    time, signal, exact = multisine(0.4 * np.pi / PERIOD)
    random = np.random.default_rng(np.random.SeedSequence(4))
    rows = slice(COUNT // 2, None)
    output = exact + 0.005 * np.std(exact) * random.standard_normal(COUNT)
    recording = pd.DataFrame({"t": time, "u": signal, "y": output})[rows]
    content = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "band-limited"},
        "plant": {"transfer_function": {"numerator": [3000.0], "denominator": [1.0, 7.0, 3300.0]}},
        "sensor": {"column": "y", "kind": "camera"},
        "initial_state": "estimate",
    }
    found = camid.identify(recording, content).simulation.plant
    assert np.allclose(found.denominator, [1.0, 6.0, 3600.0], rtol=0.005)
    diagnosis = camid.diagnose(recording, content | {"input": {"column": "u", "hold": "zoh"}})
    first = diagnosis.findings[0]
    assert (first.identifier, first.parameters["hold"].value) == ("input-hold", "band-limited")
    assert diagnosis.improved.hold == "band-limited"
