"""What a diagnosis says that it could not have seen: effects of that size are found, smaller ones mostly not."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.plant import second_order
from camid.diagnosis.report.page import render
from camid.effects import known_effects
from camid.engine.mechanics import Chain
from camid.engine.run import run
from camid.number_text import apart_from

COUNT, PERIOD, NOISE = 600, 0.05, 0.03
# A few of each place.
EFFECTS = ("coulomb-friction", "cubic-stiffness", "dead-zone", "input-bias", "lens-distortion", "delay")
SIMULATION = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [120.0], "denominator": [1.0, 2.5, 66.0]}},
    "sensor": {"column": "y", "kind": "camera"},
}


def recording(effects, seed):
    """A rig with multilevel input, and white noise of 3 % of the linear output."""
    signal = np.repeat(np.random.default_rng(5).uniform(-1.0, 1.0, COUNT // 4), 4)
    time = PERIOD * np.arange(COUNT)
    plant, acquisition = second_order(2.0, 8.0, 0.15), Acquisition(PERIOD)
    spread = float(np.std(run(Chain(plant, acquisition), signal, time)))
    noise = NOISE * spread * np.random.default_rng([17, seed]).standard_normal(COUNT)
    output = run(Chain(plant, acquisition, tuple(effects)), signal, time) + noise
    return pd.DataFrame({"t": time, "u": signal, "y": output})


@pytest.fixture(scope="module")
def sound():
    """Diagnosis of a rig that has nothing that its simulation leaves out."""
    return camid.diagnose(recording([], 0), SIMULATION)


@pytest.fixture(scope="module")
def limits(sound):
    """Effects at the smallest detectable size that the diagnosis of a sound rig states."""
    found = sound
    assert found.verdict == "adequate"
    return {
        u.identifier: known_effects()[u.identifier](**{u.parameter: u.value}, **u.others)
        for u in found.undetectable
        if u.identifier in EFFECTS
    }


def rate(effects, factor, seeds):
    """Share of the recordings in which something is detected, with so many noise seeds for each effect."""
    found = [
        camid.diagnose(recording([effect.scaled(factor)], 100 * i + seed), SIMULATION).verdict != "adequate"
        for i, effect in enumerate(effects)
        for seed in range(1, seeds + 1)
    ]
    return float(np.mean(found))


# 95 % are promised: of six recordings fewer than four are detected twice in a thousand times, of 48 recordings fewer
# than 85 % once in two hundred times.
@pytest.mark.parametrize(("seeds", "least"), [(1, 0.6), pytest.param(8, 0.85, marks=pytest.mark.slow)])
def test_effects_of_the_smallest_detectable_size_are_detected(limits, seeds, least):
    assert set(limits) == set(EFFECTS)
    assert rate(limits.values(), 1.0, seeds) >= least


@pytest.mark.slow
def test_effects_of_a_third_of_that_size_are_mostly_not_detected(limits):
    assert set(limits) == set(EFFECTS)
    assert rate(limits.values(), 1.0 / 3.0, 8) <= 0.3


def test_of_a_limit_smaller_values_show(sound):
    """And a number that is nearly that of no effect has digits that tell it from that."""
    stated = {u.identifier: u for u in sound.undetectable if u.value is not None}
    assert stated["coulomb-friction"].shows_above
    assert stated["coulomb-friction"].neutral == 0.0
    for name in ("rate-limit", "saturation", "gain-asymmetry"):
        assert not stated[name].shows_above
    assert stated["gain-asymmetry"].neutral == 1.0
    assert stated["rate-limit"].to_mapping()["smallest_detectable"]["shows"] == "below"
    page = render(sound)
    assert ">≥ " in page
    assert ">≤ " in page
    assert f">≤ {apart_from(stated['gain-asymmetry'].value, 1.0)}<" in page
