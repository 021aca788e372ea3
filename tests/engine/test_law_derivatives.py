"""Derivatives by the heights of a learned law, beside one run, against differences of whole runs."""

from dataclasses import replace

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects import known_effects
from camid.effects.learned import LearnedCurve, LearnedForce
from camid.engine.law_derivatives import by_law
from camid.engine.mechanics import Chain
from camid.engine.run import move, run

PERIOD = 0.02
SIGNAL = np.repeat(np.random.default_rng(1).uniform(-1.5, 1.5, 60), 8)
TIME = PERIOD * np.arange(len(SIGNAL))
SIZE = 1e-4
SPRING = TransferFunction((100.0,), (1.0, 2.0, 100.0))


def effect(name, **values):
    return known_effects()[name](**values)


def chain_of(effects, name, plant=SPRING, initial=None, knots=33, **acquisition):
    """Chain with a bent law behind some effects, on knots over what the motion visits."""
    chain = Chain(plant, Acquisition(PERIOD, **acquisition), tuple(effects), initial, steps=6)
    motion = move(chain, SIGNAL, TIME)
    seen = motion.velocity if name in ("velocity", "gain over velocity") else motion.position
    at = np.linspace(np.min(seen), np.max(seen), knots)
    scale = 0.3 if name in ("position", "velocity") or name.startswith("gain") else 0.03
    law = LearnedForce(variables=name, knots=at.tolist(), values=(scale * (at / np.max(np.abs(at))) ** 3).tolist())
    return replace(chain, effects=(*chain.effects, law))


def differences(chain, ways, size=SIZE):
    """Central differences, by the heights of the last effect."""
    *others, law = chain.effects

    def moved(change):
        return run(replace(chain, effects=(*others, law.with_heights(law.heights + change))), SIGNAL, TIME)

    return np.column_stack([(moved(size * way) - moved(-size * way)) / (2.0 * size) for way in ways.T])


def largest_error(chain, ways, size=SIZE):
    """Largest error of a column beside its length, or where it is short beside a part of the longest one's."""
    found = by_law(chain, SIGNAL, TIME, len(chain.effects) - 1, ways, SIZE)
    assert found is not None
    expected = differences(chain, ways, size)
    lengths = np.linalg.norm(expected, axis=0)
    errors = np.linalg.norm(found - expected, axis=0)
    return float(np.max(errors / np.maximum(lengths, 0.02 * np.max(lengths))))


CASES = {
    "nothing else": {},
    "cubic stiffness": {"effects": [effect("cubic-stiffness", coefficient=0.02)]},
    "friction that sticks": {"effects": [effect("coulomb-friction", force=0.9)]},
    "hysteresis": {"effects": [effect("hysteresis", strength=0.5, shape=1.0)]},
    "a short exposure": {"exposure": 0.007},
    "latency from a start": {"exposure": 0.007, "latency": 0.013, "initial": np.array([0.3, -0.2])},
    "an instant sensor": {"sensor": "instant", "latency": 0.004},
    "a straight input": {"hold": "foh"},
    "a lens": {"effects": [effect("lens-distortion", k1=0.02)]},
    "a lens and a shutter": {
        "effects": [effect("lens-distortion", k1=0.02), effect("rolling-shutter", time_per_unit=1e-3)]
    },
    "three poles": {"plant": TransferFunction((1000.0,), (1.0, 20.0, 200.0, 1000.0))},
    "a sum of two": {"plant": TransferFunction((100.0, 2000.0), (1.0, 12.0, 140.0, 1000.0))},
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("name", ["position", "velocity"])
def test_they_are_those_of_whole_runs(case, name):
    options = dict(CASES[case])
    chain = chain_of(options.pop("effects", []), name, **options)
    assert largest_error(chain, np.eye(33), 0.1 * SIZE) < 5e-4


@pytest.mark.parametrize("name", ["damping over position", "gain over position", "gain over velocity"])
def test_they_are_those_of_what_multiplies_a_signal(name):
    chain = chain_of([effect("coulomb-friction", force=0.3)], name)
    assert largest_error(chain, np.eye(33), 0.1 * SIZE) < 5e-4


@pytest.mark.parametrize("effects", [[], [effect("coulomb-friction", force=0.3)]])
def test_a_law_on_more_knots_is_changed_along_hats(effects):
    chain = chain_of(effects, "position", knots=161)
    knots = chain.effects[-1].knots
    hats = np.column_stack([np.interp(knots, knots[::8], way) for way in np.eye(21)])
    assert largest_error(chain, hats, 0.1 * SIZE) < 5e-4


def test_impulses_and_forces_that_jump_are_met():
    shocks = [
        effect("impulse-disturbance", size=0.05, time=2.003),
        effect("step-disturbance", size=0.4, time=4.0071),
    ]
    chain = chain_of(shocks, "velocity")
    assert largest_error(chain, np.eye(33), 0.1 * SIZE) < 5e-4


def test_a_curve_of_the_sensor_takes_no_further_run():
    chain = chain_of([effect("coulomb-friction", force=0.3)], "position")
    seen = run(chain, SIGNAL, TIME)
    knots = np.linspace(np.min(seen), np.max(seen), 17).tolist()
    chain = replace(chain, effects=(*chain.effects, LearnedCurve(variables="reading", knots=knots, values=knots)))
    assert largest_error(chain, np.eye(17)) < 1e-6


@pytest.mark.parametrize("hold", ["zoh", "foh"])
@pytest.mark.parametrize("others", [["cubic-stiffness"], ["coulomb-friction"], ["hysteresis", "saturation"]])
def test_a_curve_of_the_actuator_changes_the_input(others, hold):
    known = {
        "cubic-stiffness": {"coefficient": 0.02},
        "coulomb-friction": {"force": 0.6},
        "hysteresis": {"strength": 0.5, "shape": 1.0},
        "saturation": {"limit": 1.1},
    }
    knots = np.linspace(-1.5, 1.5, 17)
    curve = LearnedCurve(variables="input", knots=knots.tolist(), values=(knots + 0.1 * knots**3).tolist())
    effects = tuple(effect(name, **known[name]) for name in others)
    chain = Chain(SPRING, Acquisition(PERIOD, hold=hold, exposure=0.007), (*effects, curve), steps=6)
    assert largest_error(chain, np.eye(17), 0.1 * SIZE) < 5e-4


def test_what_only_whole_runs_tell_is_left_to_them():
    knots = [-1.0, 0.0, 1.0]
    bent_input = LearnedCurve(variables="input", knots=knots, values=knots)  # of a linear chain, which runs exactly
    force = LearnedForce(variables="velocity", knots=knots, values=[0.0] * 3)
    first_order = TransferFunction((5.0,), (1.0, 5.0))
    for plant, law, steps in ((SPRING, bent_input, 6), (first_order, force, 6), (SPRING, force, None)):
        chain = Chain(plant, Acquisition(PERIOD), (law,), steps=steps)
        assert by_law(chain, SIGNAL, TIME, 0, np.eye(3), SIZE) is None
