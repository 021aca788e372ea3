"""The kind of plant that a simulation declares, made once and asked wherever kinds differ."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from camid.effects import known_effects
from camid.fitting.fit import evaluate
from camid.fitting.from_simulation import kind_of, model_of, problem_of, structure_of
from camid.fitting.initial_motion import with_positions_moved
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.closed_loop import ClosedLoop
from camid.fitting.plants.linear import FreeDecay, LinearPlant
from camid.fitting.plants.pendulum import PendulumKind
from camid.identification.from_recordings import experiments_of, load_recordings
from camid.simulation.file import load_simulation

DRIVEN = {"column": "u", "hold": "zoh"}
SENSOR = {"column": "y", "kind": "instant"}
CONTROLLER = {"reference": "r", "position_gain": 8.0, "velocity_gain": 150.0}
LINEAR = {"transfer_function": {"numerator": [1.0], "denominator": [1.0, 2.0, 4.0]}}
SWINGING = {"natural_frequency": 3.0, "damping": 0.01, "gain": 0.5, "rest": 0.2}


def simulation(plant, signal=DRIVEN, **more):
    content = {"schema": 1, "time": {"column": "t"}, "input": signal, "plant": plant, "sensor": SENSOR}
    return load_simulation(content | {"initial_state": "estimate"} | more)


def pendulum(free, signal=DRIVEN, **more):
    return simulation({"pendulum": SWINGING, "free": free}, signal, **more)


@pytest.mark.parametrize(
    ("believed", "kind", "adds_up"),
    [
        (simulation(LINEAR), LinearPlant(), False),
        (simulation(LINEAR, None), FreeDecay(), True),
        (pendulum({}), PendulumKind(0.2, True, None), True),
        (pendulum({"rest": False, "gain": False}), PendulumKind(0.2, False, 0.5), True),
        (pendulum({}, None), PendulumKind(0.2, True, 0.5), True),  # a free decay says nothing of the gain
    ],
    ids=["linear", "free decay", "pendulum", "pendulum partly known", "swinging pendulum"],
)
def test_the_simulation_says_the_kind(believed, kind, adds_up):
    found = kind_of(believed, [])
    assert found == kind
    assert found.phases_add_up == adds_up


def test_any_kind_may_stand_in_a_closed_loop():
    table = pd.DataFrame({"t": [0.0, 0.1, 0.2], "r": [0.0, 1.0, 2.0], "u": [3.0, 2.0, 1.0], "y": [0.4, 0.5, 0.6]})
    believed = pendulum({}, controller=CONTROLLER)
    loop = kind_of(believed, load_recordings(table, believed, output_needed=True))
    assert isinstance(loop, ClosedLoop)
    assert loop.plant == PendulumKind(0.2, True, None)
    assert loop.constants() == {"rest": 0.2}
    assert loop.phases_add_up
    model = Model(np.zeros(3), constants={"rest": 0.3})
    assert [e.values for e in loop.forces(model)] == [{"rest": 0.3}]
    np.testing.assert_allclose(loop.at_plant(loop.positions[0], model), [0.1, 0.2, 0.3])
    shorter = loop.start_of(2)
    np.testing.assert_array_equal(shorter.loop(0).reference, [0.0, 1.0])
    np.testing.assert_array_equal(shorter.positions[0], [0.4, 0.5])


def test_a_closed_loop_shows_nothing_of_the_camera_nor_of_what_hangs_behind_the_plant():
    loop, plant = kind_of(simulation(LINEAR, controller=CONTROLLER), []), kind_of(simulation(LINEAR), [])
    hidden = {name for name, effect in known_effects().items() if loop.unseen(effect)}
    camera = {e.identifier for e in known_effects().values() if e.place == "sensor"}
    assert hidden == camera | {"input-hold", "output-backlash", "coloured-noise"}
    assert not any(plant.unseen(effect) for effect in known_effects().values())


def test_a_known_gain_follows_the_natural_frequency():
    coefficients = np.array([1.0, 2.0, 8.0])
    np.testing.assert_array_equal(PendulumKind(0.0, True, 0.5).completed(coefficients, {}), [4.0, 2.0, 8.0])
    np.testing.assert_array_equal(PendulumKind(0.0).completed(coefficients, {}), coefficients)
    np.testing.assert_array_equal(PendulumKind(0.0, True, 0.5).all_fixed().completed(coefficients, {}), coefficients)


def test_re_estimated_coefficients_are_never_worse_than_the_given_ones(monkeypatch):
    """Even where the search ends in another minimum, or nowhere."""
    from camid.fitting.fit import evaluate
    from camid.fitting.from_simulation import model_of, problem_of, structure_of
    from camid.identification.from_recordings import experiments_of

    random = np.random.default_rng(np.random.SeedSequence(5))
    signal = np.repeat(random.choice([-1.0, 1.0], 40), 10)
    time = 0.05 * np.arange(400)
    believed = simulation(LINEAR, initial_state="zero")
    table = pd.DataFrame({"t": time, "u": signal, "y": random.standard_normal(400)})
    recordings, experiments, _ = experiments_of(table, believed, None)
    problem = problem_of(believed, structure_of(believed), recordings, experiments)
    given = model_of(problem, [])
    output = problem.simulate_one(given, 0) + 0.01 * random.standard_normal(400)
    recordings, experiments, _ = experiments_of(table.assign(y=output), believed, None)
    problem = problem_of(believed, structure_of(believed), recordings, experiments)
    start = problem.with_initial_states(given)
    least = evaluate(problem, start).cost
    for coefficients in ([3.0, 0.1, 90.0], [3.0, -90.0, 4.0]):  # the second motion runs away
        wrong = Model(np.array(coefficients), constants=start.constants, initial=start.initial)
        monkeypatch.setattr(
            LinearPlant, "_searched", lambda kind, problem, start, wrong=wrong: evaluate(problem, wrong)
        )
        assert problem.kind.refit(problem, start).cost <= least


def test_of_a_pendulum_that_hardly_swings_the_angle_at_rest_is_a_constant():
    """So that of friction it takes what differs by direction; one that is known takes nothing."""
    time = 0.02 * np.arange(400)
    for swing, free, taken in ((0.2, {}, True), (1.5, {}, False), (0.2, {"rest": False}, False)):
        table = pd.DataFrame({"t": time, "u": np.sin(time), "y": 0.3 + swing * np.cos(3.0 * time)})
        believed = pendulum(free)
        recordings, experiments, _ = experiments_of([table], believed, None)
        problem = problem_of(believed, structure_of(believed), recordings, experiments)
        assert problem.kind.constant_beside(problem) == taken


def test_the_angle_at_rest_is_in_the_turn_in_which_it_is_believed_to_be():
    """A fit may end two turns further, with the motion there: nothing tells them apart."""
    time = 0.02 * np.arange(400)
    table = pd.DataFrame({"t": time, "y": 0.3 + 0.2 * np.exp(-0.1 * time) * np.cos(3.0 * time)})
    believed = pendulum({}, None)
    recordings, experiments, _ = experiments_of([table], believed, None)
    problem = problem_of(believed, structure_of(believed), recordings, experiments)
    found = problem.kind.refit(problem, problem.with_initial_states(model_of(problem, [])))
    turned = replace(found.model, constants={"rest": found.model.constants["rest"] + 4.0 * np.pi})
    start = with_positions_moved(problem, turned, -4.0 * np.pi)
    assert evaluate(problem, start).cost == pytest.approx(found.cost, rel=1e-9)
    again = problem.kind.refit(problem, start)
    assert again.model.constants["rest"] == pytest.approx(0.3, abs=0.01)
    assert again.cost == pytest.approx(found.cost, rel=1e-6)
