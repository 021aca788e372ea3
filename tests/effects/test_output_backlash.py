"""Backlash behind the plant: what the sensor sees of a load, and how it is found."""

import numpy as np
import pandas as pd
import pytest
from scipy.signal import lsim

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.output_backlash import OutputBacklash, OutputBacklashFromAnywhere
from camid.engine.mechanics import Chain
from camid.engine.run import run

PERIOD, FINE = 0.1, 400
PLANT = TransferFunction((100.0,), (1.0, 2.0, 100.0))


def command(rows, seed=1):
    """Levels held for three frames."""
    return np.repeat(np.random.default_rng(seed).choice([-1.0, 1.0], rows // 3), 3)


def behind_play(position, half_width, load):
    """The load, step by step."""
    found = np.empty_like(position)
    for k, drive in enumerate(position):
        load = min(max(load, drive - half_width), drive + half_width)
        found[k] = load
    return found


def fine_motion(signal, plant=PLANT):
    """Drive on a fine grid, by another program."""
    times = np.arange(len(signal) * FINE + 1) * PERIOD / FINE
    inputs = np.append(np.repeat(signal, FINE), signal[-1])
    return lsim((plant.numerator, plant.denominator), inputs, times, interp=False)[1]


@pytest.mark.parametrize(
    ("effect", "load"),
    [(OutputBacklash(half_width=0.2), 0.0), (OutputBacklashFromAnywhere(half_width=0.2, start=0.8), -0.16)],
)
def test_the_load_follows_the_drive_between_frames_too(effect, load):
    signal = command(300)
    found = run(Chain(PLANT, Acquisition(PERIOD, sensor="instant"), (effect,)), signal, PERIOD * np.arange(300))
    expected = behind_play(fine_motion(signal), 0.2, load)[::FINE][:300]
    np.testing.assert_allclose(found, expected, atol=1e-3 * np.std(expected))


def test_an_exposure_averages_the_load():
    signal, exposure = command(300), 0.08
    found = run(
        Chain(PLANT, Acquisition(PERIOD, exposure=exposure), (OutputBacklash(half_width=0.2),)),
        signal,
        PERIOD * np.arange(300),
    )
    load = behind_play(fine_motion(signal), 0.2, 0.0)
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (load[1:] + load[:-1]))]) / FINE * PERIOD
    window = round(exposure / PERIOD * FINE)
    rows = FINE * np.arange(1, 300)
    expected = (integral[rows] - integral[rows - window]) / exposure
    np.testing.assert_allclose(found[1:], expected, atol=5e-3 * np.std(expected))


def test_no_gap_is_no_play():
    signal, times = command(300), PERIOD * np.arange(300)
    chain = Chain(PLANT, Acquisition(PERIOD, exposure=PERIOD))
    with_none = run(
        Chain(PLANT, Acquisition(PERIOD, exposure=PERIOD), (OutputBacklash(half_width=0.0),)), signal, times
    )
    np.testing.assert_allclose(with_none, run(chain, signal, times), atol=1e-4)


@pytest.mark.slow
def test_a_stage_with_play_is_told_from_friction():
    """A motor on a screw: the plant integrates, the nut has a gap, and the scale is on the table."""
    plant = TransferFunction((12.0,), (1.0, 25.0, 0.0))
    generator = np.random.default_rng(5)
    signal = np.repeat(generator.normal(size=150), 10)
    drive = fine_motion(signal, plant)
    recorded = behind_play(drive, 0.04, -0.02)[::FINE][:1500] + 0.002 * generator.normal(size=1500)
    table = pd.DataFrame({"t": PERIOD * np.arange(1500), "u": signal, "y": recorded})
    nominal = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [14.0], "denominator": [1.0, 22.0, 0.0]}},
        "sensor": {"column": "y", "kind": "instant"},
        "initial_state": "estimate",
    }
    found = camid.diagnose(table, nominal)
    assert [f.identifier for f in found.findings] == ["output-backlash"]
    assert found.findings[0].weight > 0.9
    assert found.location.place == "plant"
    half_width = found.findings[0].parameters["half_width"]
    assert abs(half_width.value - 0.04) < 3.0 * half_width.standard_deviation < 0.01
    assert camid.diagnose(table, found.improved.to_mapping()).verdict == "adequate"
