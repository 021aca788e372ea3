"""A plant in a loop whose controller is at its limit most of the time."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from camid.effects.actuator import GainAsymmetry
from camid.fitting.fit import evaluate, fit
from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.identification.from_recordings import experiments_of
from camid.simulation.file import load_simulation

PERIOD, COUNT = 0.011, 1500
GAIN, DAMPING = 0.01, 1.1
CONTROLLER = {"reference": "r", "position_gain": 2.3, "velocity_gain": 680.0, "limit": 11.0}


def switching_loop(seed=2):
    """A drive that follows a square wave of random length; its control is at one limit or at the other."""
    random = np.random.default_rng(seed)
    reference = np.repeat(random.choice([-0.08, 0.08], COUNT // 21 + 1), 21)[:COUNT]
    position = velocity = 0.0
    control, positions = np.zeros(COUNT), np.zeros(COUNT)
    decay = np.exp(-DAMPING * PERIOD)
    for k in range(COUNT):
        positions[k] = position
        wanted = CONTROLLER["position_gain"] * (reference[k] - position) - velocity
        control[k] = np.clip(CONTROLLER["velocity_gain"] * wanted, -CONTROLLER["limit"], CONTROLLER["limit"])
        final = GAIN * control[k] / DAMPING
        position += final * PERIOD + (velocity - final) * (1.0 - decay) / DAMPING
        velocity = final + (velocity - final) * decay
    noise = random.standard_normal((2, COUNT))
    return pd.DataFrame(
        {
            "t": PERIOD * np.arange(COUNT),
            "r": reference,
            "u": control + 0.05 * noise[0],
            "y": positions + 1e-4 * noise[1],
        }
    )


def linear(gain, damping):
    return {"transfer_function": {"numerator": [gain * GAIN], "denominator": [1.0, damping * DAMPING, 0.0]}}


def believed(plant):
    return load_simulation(
        {
            "schema": 1,
            "time": {"column": "t"},
            "input": {"column": "u", "hold": "zoh"},
            "plant": plant,
            "controller": CONTROLLER,
            "sensor": {"column": "y", "kind": "instant"},
            "initial_state": "zero",
        }
    )


@pytest.mark.parametrize(("gain", "damping"), [(1.15, 0.85), (0.85, 1.15), (1.3, 1.3), (0.7, 0.7)])
def test_its_coefficients_are_found_from_far(gain, damping):
    """Its control switches at wrong times in any other minimum, and leaves most of itself."""
    simulation = believed(linear(gain, damping))
    recordings, experiments, _ = experiments_of([switching_loop()], simulation, None)
    problem = problem_of(simulation, structure_of(simulation), recordings, experiments)
    start = problem.with_initial_states(model_of(problem, []))
    found = problem.kind.refit(problem, start)
    assert found.model.coefficients[:2] == pytest.approx([GAIN, DAMPING], rel=0.01)
    assert np.sqrt(found.cost / COUNT) < 0.06
    # The start alone does not lead there, from one of them at least; else this test would show nothing.
    if (gain, damping) == (0.85, 1.15):
        assert np.sqrt(fit(problem, start).cost / COUNT) > 1.0
    assert evaluate(problem, start).cost > 100.0 * found.cost


EQUATIONS = {
    "physical": {
        "parameters": {"mass": 80.0, "damping": 1.0},
        "equations": {"states": {"position": "speed", "speed": "(u - damping*speed)/mass"}, "output": "position"},
    }
}


def test_constants_of_equations_are_found_from_far_too(monkeypatch):
    """The same drive without friction to speak of, written as equations; its mass is 100."""
    monkeypatch.setitem(globals(), "DAMPING", 1e-3)
    simulation = believed(EQUATIONS)
    recordings, experiments, _ = experiments_of([switching_loop(5)], simulation, None)
    problem = problem_of(simulation, structure_of(simulation), recordings, experiments)
    found = problem.kind.refit(problem, problem.with_initial_states(model_of(problem, [])))
    assert found.model.constants["constant mass"] == pytest.approx(100.0, rel=0.01)


def test_what_is_guessed_in_a_loop_sees_the_control_and_not_the_reference():
    """A reference of one sign and size hides nothing of an actuator that is driven both ways."""
    table = switching_loop()
    table["r"] += 0.08 - table["r"].min()  # never negative
    table["y"] += table["r"].max() - 0.08
    simulation = believed(linear(1.1, 0.9))
    recordings, experiments, _ = experiments_of([table], simulation, None)
    problem = problem_of(simulation, structure_of(simulation), recordings, experiments)
    situation = problem.situations(problem.with_initial_states(model_of(problem, []))).of(GainAsymmetry)
    assert situation.controlled
    np.testing.assert_array_equal(situation.signal, table["u"])
    assert GainAsymmetry.invisible(situation) is None
    assert GainAsymmetry.invisible(replace(situation, signal=table["r"].to_numpy())) is not None
    half = situation.until(100)
    assert half.controlled
    np.testing.assert_array_equal(half.signal, table["u"][:100])
