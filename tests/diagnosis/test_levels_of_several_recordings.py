"""What one recording cannot show several may: inputs of two levels each, of different sizes."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.effects.command import levels
from camid.effects.friction import LoadDependentFriction
from tests.support.runge_kutta import positions

PERIOD, PARTS, ROWS = 0.02, 80, 640
SIZES = (1.0, 3.0)
SIMULATION = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [35.0], "denominator": [1.0, 5.0, 55.0]}},
    "sensor": {"column": "y", "kind": "instant"},
    "effects": [],
}


def bent(law, drive):
    """The force that a command becomes."""
    if law == "saturation":
        return np.clip(drive, -2.0, 2.0)
    return np.sign(drive) * max(abs(drive) - 0.4, 0.0) if law == "dead-zone" else drive


def friction(law, drive):
    """The level of dry friction under a load."""
    return {"load-dependent-friction": 0.05 + 0.12 * abs(drive), "coulomb-friction": 0.15}.get(law, 0.0)


def recording(law, size, seed, signal=None):
    """Of a mass on a spring under a random telegraph signal of a size."""
    random = np.random.default_rng(seed)
    if signal is None:
        signal = size * np.repeat(random.choice([-1.0, 1.0], ROWS // 8), 8)

    def rate(state, drive):
        position, velocity = state
        resistance = friction(law, drive) * np.tanh(velocity / 0.002)
        return np.array([velocity, 40.0 * (bent(law, drive) - resistance) - 6.0 * velocity - 60.0 * position])

    seen = positions(rate, signal, PERIOD, PARTS)
    noisy = seen + 0.01 * np.std(seen) * random.standard_normal(len(seen))
    return pd.DataFrame({"t": PERIOD * np.arange(len(seen)), "u": signal, "y": noisy})


def diagnosis(*recordings):
    return camid.diagnose(list(recordings), SIMULATION, time_limit=None)


@pytest.mark.parametrize(
    ("law", "parameter", "value"),
    [("saturation", "limit", 2.0), ("dead-zone", "half_width", 0.4), ("load-dependent-friction", "coefficient", 0.12)],
)
@pytest.mark.slow
def test_what_two_sizes_of_the_input_show_is_named(law, parameter, value):
    found = diagnosis(*(recording(law, size, seed) for seed, size in enumerate(SIZES)))
    assert found.verdict == "explained"
    (effect,) = found.findings
    # Of two levels, each for as long as they like, a play leaves what a dead zone leaves.
    names = {effect.identifier, *(name for name, weight in effect.alternatives if weight > 0.3)}
    assert law in names
    estimate = effect.parameters[parameter]
    assert estimate.value == pytest.approx(value, abs=max(4.0 * estimate.standard_deviation, 0.02 * value))


@pytest.mark.slow
def test_steps_of_the_command_are_found_where_the_longest_recording_has_none():
    """A free decay says nothing of the input, however long it is."""
    random = np.random.default_rng(5)
    sweep = 2.2 * np.sin(np.cumsum(np.linspace(0.02, 0.2, ROWS)))
    driven = recording("none", 1.0, 5, np.round(sweep / 0.5) * 0.5).assign(u=sweep)
    time = PERIOD * np.arange(2 * ROWS)
    decay = 0.6 * np.exp(-3.0 * time) * np.cos(np.sqrt(51.0) * time) + 0.004 * random.standard_normal(len(time))
    still = pd.DataFrame({"t": time, "u": 0.0, "y": decay})
    found = camid.diagnose([still, driven], {**SIMULATION, "initial_state": "estimate"}, time_limit=None)
    (effect,) = found.findings
    assert effect.identifier == "input-quantisation"
    assert effect.parameters["step"].value == pytest.approx(0.5, rel=1e-2)


@pytest.mark.slow
def test_friction_under_one_load_may_grow_with_it():
    found = diagnosis(recording("load-dependent-friction", 3.0, 1))
    (effect,) = found.findings
    assert effect.identifier == "coulomb-friction"
    others = dict(effect.alternatives)
    assert others[LoadDependentFriction.identifier] == pytest.approx(0.3 / 0.7 * effect.weight)
    # Both are there for the next experiment, which has to have several levels.
    by_name = {h.identifier: h for h in found.hypotheses}
    assert by_name[LoadDependentFriction.identifier].misfit == pytest.approx(0.0, abs=1e-3)
    assert by_name[LoadDependentFriction.identifier].weight == others[LoadDependentFriction.identifier]
    # Two loads tell them apart.
    found = diagnosis(*(recording("coulomb-friction", size, seed) for seed, size in enumerate(SIZES)))
    (effect,) = found.findings
    assert effect.identifier == "coulomb-friction"
    assert dict(effect.alternatives).get(LoadDependentFriction.identifier, 0.0) < 0.1


def test_levels_are_those_of_all_recordings():
    assert levels(np.array([1.0, -1.0])) == 1
    assert levels(np.array([1.0, -1.0, 3.0])) == 2
