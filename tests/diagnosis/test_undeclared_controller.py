"""Plants that leave any recording without the controller that is not declared: an observer holds their simulation."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import camid
from camid.chain.acquisition import Acquisition
from camid.diagnosis.held_by_observer import Pulled, is_astray
from camid.diagnosis.search.hypothesis_fit import takes_input_away
from camid.diagnosis.watch import Watch
from camid.effects.declared import effects_of
from camid.errors import InputError
from camid.simulation.file import load_simulation

FINE = 20


def recorded(wanted, period, force, controller, noise, exposure, seed, start=0.0):
    """Table of command and frames of an axis, by Runge-Kutta steps, that a controller of its own sensor drives."""
    step, open_steps = period / FINE, round(exposure / period * FINE)
    command, frames = np.zeros(len(wanted)), np.zeros(len(wanted))
    state, path, memory = np.array([start, 0.0]), [start] * (FINE + 1), 0.0
    for k, goal in enumerate(wanted):
        seen = path[-open_steps - 1 :]
        frames[k] = (np.sum(seen) - 0.5 * (seen[0] + seen[-1])) / open_steps
        command[k], memory = controller(goal, state, memory)

        def slope(at, u=command[k]):
            return np.array([at[1], force(u, *at)])

        for _ in range(FINE):
            first = slope(state)
            second = slope(state + 0.5 * step * first)
            third = slope(state + 0.5 * step * second)
            fourth = slope(state + step * third)
            state = state + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
            path.append(state[0])
    frames += noise * np.random.default_rng(seed).standard_normal(len(wanted))
    return pd.DataFrame({"t": period * np.arange(len(wanted)), "u": command, "y": frames})


def nominal(numerator, denominator, exposure, **more):
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [numerator], "denominator": denominator}},
        "sensor": {"column": "y", "kind": "camera", "exposure": exposure},
        **more,
    }


def balanced(goal, state, memory):
    """Of an inverted pendulum."""
    return 7.5 * (goal - state[0]) - 1.2 * state[1], memory


def falling(friction):
    return lambda u, y, v: 8.0 * (u - friction * np.tanh(v / 1e-3)) - 0.5 * v + 22.0 * y


def swings(seed, rows, period):
    """Steps and a multisine."""
    random, time = np.random.default_rng(seed), period * np.arange(rows)
    sines = [0.08 * np.sin(2.0 * np.pi * f * time + random.uniform(0.0, 6.28)) for f in (0.13, 0.29, 0.41, 0.73, 1.1)]
    return 0.15 * np.repeat(random.choice([-1.0, 1.0], rows // 100), 100) + np.sum(sines, axis=0)


def test_an_inverted_pendulum_is_identified_in_a_loop_that_is_not_declared():
    table = recorded(swings(3, 3000, 0.01), 0.01, falling(0.0), balanced, 2e-4, 0.004, 1)
    believed = nominal(6.0, [1.0, 0.8, -18.0], 0.004)
    with pytest.raises(InputError, match="unstable"):
        camid.diagnose(table, believed)
    found = camid.diagnose(table, believed | {"observer": {"rate": 6.0}})
    assert found.verdict == "adequate"
    for coefficient, truth in zip(found.coefficients, (8.0, 0.5, -22.0), strict=True):
        assert abs(coefficient.improved - truth) < 4.0 * coefficient.improved_deviation < 0.05 * abs(truth)


@pytest.mark.slow
def test_friction_of_an_inverted_pendulum_is_found_and_the_improved_simulation_follows():
    table = recorded(swings(4, 3000, 0.01), 0.01, falling(0.1), balanced, 2e-4, 0.004, 2)
    found = camid.diagnose(table, nominal(6.0, [1.0, 0.8, -18.0], 0.004, observer={"rate": 8.0}))
    assert found.findings[0].identifier == "coulomb-friction"
    assert found.findings[0].parameters["force"].value == pytest.approx(0.1, rel=0.02)
    assert any("an observer pulls the simulated motion" in warning for warning in found.warnings)
    simulated = camid.simulate(table, found.improved)["simulated"].to_numpy()
    left = np.std(table["y"] - simulated) / np.std(table["y"])
    assert left == pytest.approx(found.fit.improved, rel=0.3)
    assert found.improved.to_mapping()["observer"] == {"rate": 8.0, "gain": 6.0}


def integrating(goal, state, memory):
    """Of a linear motor, with an integral."""
    memory += 0.004 * (goal - state[0])
    return 32.0 * (goal - state[0]) + 60.0 * memory - 2.7 * state[1], memory


def cogging(u, y, v):
    return 8.0 * (u - 0.6 * np.sin(2.0 * np.pi * y / 0.035 + 1.0)) - 5.0 * v


@pytest.mark.slow
def test_strong_cogging_in_a_loop_that_is_not_declared_is_found_with_an_observer():
    """An axis near the edge of a well leaves any simulation that is not pulled."""
    goals = np.cumsum(np.random.default_rng(5).uniform(-0.06, 0.06, 20)).repeat(150)
    table = recorded(0.1 + goals, 0.004, cogging, integrating, 2e-5, 0.002, 3, start=0.1)
    found = camid.diagnose(table, nominal(11.0, [1.0, 3.0, 0.0], 0.002))
    assert [f.identifier for f in found.findings] == ["cogging"]
    values = found.findings[0].parameters
    assert values["amplitude"].value == pytest.approx(0.6, rel=0.003)
    assert values["period"].value == pytest.approx(0.035, rel=0.001)
    assert found.improved.observer.rate == pytest.approx(25.0)
    assert any("an observer pulls the simulated motion" in warning for warning in found.warnings)


def hanging(u, y, v):
    return 15.0 * (u - 0.9 * np.sin(y - 0.3) - 0.25 * np.tanh(v / 1e-3)) - 3.0 * v


def holding(goal, state, memory):
    """Of a gimbal, with a weak integral."""
    memory += 0.01 * (goal - state[0])
    return 4.0 * (goal - state[0]) + 3.0 * memory - 0.6 * state[1], memory


@pytest.mark.slow
def test_what_the_first_of_two_recordings_shows_alone_is_found_in_both():
    """No simulation follows both from the start, and the second one shows less."""
    tables = []
    for seed, width in ((6, 0.9), (7, 0.35)):
        goals = np.random.default_rng(seed).uniform(-width, width, 25).repeat(100)
        smooth = np.convolve(goals, np.ones(40) / 40.0, "same")
        tables.append(recorded(smooth, 0.01, hanging, holding, 1e-3, 0.004, seed))
    found = camid.diagnose(tables, nominal(10.0, [1.0, 4.5, 0.0], 0.004, initial_state="estimate"))
    assert {f.identifier for f in found.findings} == {"coulomb-friction", "pendulum-gravity"}
    force = next(f for f in found.findings if f.identifier == "coulomb-friction").parameters["force"]
    assert force.value == pytest.approx(0.25, rel=0.01)
    assert found.verdict == "explained"


@pytest.mark.parametrize(("limit", "away"), [(0.01, True), (0.5, False)])
def test_an_actuator_that_takes_the_input_away_says_nothing(limit, away):
    """What is pulled without the command is disturbed less than with it, where the command makes up for a force."""
    effects = [{"id": "saturation", "parameters": {"limit": limit}}]
    improved = load_simulation(nominal(8.0, [1.0, 5.0, 0.0], 0.002, effects=effects))
    command = np.sin(np.arange(400.0))
    run = SimpleNamespace(signal=command, acquisition=Acquisition(0.004, sensor="instant"))
    assert takes_input_away(SimpleNamespace(experiments=[run]), effects_of(improved)) is away


def test_frames_that_are_left_out_one_by_one_do_not_pull_and_those_that_judge_do():
    table = recorded(swings(3, 1500, 0.01), 0.01, falling(0.0), balanced, 2e-4, 0.004, 1)
    table.loc[[300, 700, 850], "y"] += 1.0  # a marker that was taken for another one
    found = camid.diagnose(table, nominal(6.0, [1.0, 0.8, -18.0], 0.004, observer={"rate": 6.0}))
    assert {f.identifier for f in found.findings} <= {"outliers"}
    for coefficient, truth in zip(found.coefficients, (8.0, 0.5, -22.0), strict=True):
        assert abs(coefficient.improved - truth) < 4.0 * coefficient.improved_deviation < 0.1 * abs(truth)


@pytest.mark.parametrize(
    ("error", "noise", "structured", "named", "astray"),
    [
        (0.2, 0.1, True, (), True),
        (0.2, 0.1, False, (), False),  # noise alone, however much
        (0.2, 0.1, False, ("coloured-noise",), True),  # what runs away looks like that, too
        (0.02, 0.01, True, (), False),
        (0.02, 0.001, True, (), True),
        (0.002, 0.0001, True, (), False),
    ],
)
def test_what_leaves_noise_alone_follows_the_recording(error, noise, structured, named, astray):
    findings = [SimpleNamespace(identifier=name) for name in named]
    fit = SimpleNamespace(improved=error, noise_floor=noise)
    diagnosis = SimpleNamespace(fit=fit, structured=structured, findings=findings)
    assert is_astray(diagnosis) == astray


@pytest.mark.parametrize(
    ("found", "improved", "verdict", "everything", "more"),
    [
        (["cogging"], 0.010, "explained", True, True),
        ([], 0.010, "adequate", False, False),  # the pull hides what is missing
        (["cogging"], 0.0105, "partly-explained", False, True),  # little beyond the noise
        (["cogging"], 0.019, "partly-explained", False, False),
    ],
)
def test_a_pulled_simulation_tells_what_is_missing_where_something_is_found(found, improved, verdict, everything, more):
    fits = SimpleNamespace(improved=improved, refitted=0.02 if found else improved, noise_floor=0.01)
    diagnosis = SimpleNamespace(findings=found, learned=[], verdict=verdict, fit=fits)
    pulled = Pulled(diagnosis, None, 0.05, Watch())
    assert (pulled.tells_all, pulled.tells_more) == (everything, more)
