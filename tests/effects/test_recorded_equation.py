"""Plants beside a force over the position, by their equation at the recorded positions."""

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.damping import QuadraticDrag
from camid.effects.friction import CoulombFriction
from camid.effects.recorded_equation import plant_beside_stop, plants_beside_laws
from camid.effects.situation import Situation
from camid.effects.stiffness import EndStop

PERIOD, ROWS = 0.05, 3000
GAIN, RATE = 0.45, 3.0
PLACE, STIFFNESS = 35.0, 3.0
# What an estimation without the stop ends in: no motor.
BENT = TransferFunction((27.0,), (1.0, 230.0, 0.0))
BUTTONS = (-1.0, -0.4, 0.0, 0.5, 0.8, 1.0)


@pytest.fixture(scope="module")
def actuator():
    """Time, command and stroke of a spindle that is driven into a buffer by hand, by another integrator."""
    generator = np.random.default_rng(4)
    time = PERIOD * np.arange(ROWS)
    command = 40.0 * np.repeat(generator.choice(BUTTONS, ROWS // 60), 60)

    def motion(t, x):
        pushed = command[min(int(t / PERIOD), ROWS - 1)]
        contact = STIFFNESS * max(x[0] - PLACE, 0.0) + 0.5 * max(x[0] - PLACE, 0.0) ** 2
        return [x[1], GAIN * (pushed - contact) - RATE * x[1]]

    found = solve_ivp(motion, (0.0, time[-1]), [5.0, 0.0], t_eval=time, rtol=1e-8, max_step=PERIOD)
    return time, command, np.round(found.y[0] + 0.02 * generator.normal(size=ROWS), 2)


def situation(time, command, stroke, plant=BENT):
    """What effects are told of a recording, with a simulation that is somewhere else."""
    nothing = np.zeros(ROWS)
    used = np.ones(ROWS, bool)
    return Situation(
        time, command, stroke, nothing, nothing, nothing, plant, Acquisition(PERIOD, sensor="instant"), used
    )


def test_the_stop_and_the_plant_beside_it_are_seen_before_anything_is_fitted(actuator):
    found = plant_beside_stop(situation(*actuator))
    assert found.place == pytest.approx(PLACE, rel=0.05)
    assert found.stiffness > STIFFNESS  # the buffer is progressive
    assert found.plant.denominator[1] == pytest.approx(RATE, rel=0.1)
    assert found.plant.numerator[0] == pytest.approx(GAIN, rel=0.1)
    assert found.plant.denominator[2] == 0.0


def test_only_a_plant_that_integrates_needs_one(actuator):
    (stop, plant, constants) = EndStop.with_plant(situation(*actuator), {"bias": 0.3, "offset": 1.0})
    assert type(stop) is EndStop
    assert set(constants) == {"bias"}
    assert plant.denominator[2] == 0.0
    spring = TransferFunction((27.0,), (1.0, 230.0, 4.0))
    assert EndStop.with_plant(situation(*actuator, plant=spring), {}) is None


def test_free_motion_shows_no_stop(actuator):
    time, command, _ = actuator
    velocity = np.zeros(ROWS)
    for k in range(ROWS - 1):
        velocity[k + 1] = velocity[k] + PERIOD * (GAIN * command[k] - RATE * velocity[k])
    position = PERIOD * np.cumsum(velocity)
    assert plant_beside_stop(situation(time, command, position)) is None


def test_a_buffer_of_a_spindle_is_found_though_the_plant_without_it_runs_away(actuator):
    time, command, stroke = actuator
    nominal = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [0.3], "denominator": [1.0, 2.4, 0.0]}},
        "sensor": {"column": "y", "kind": "instant"},
        "initial_state": "estimate",
    }
    found = camid.diagnose(pd.DataFrame({"t": time, "u": command, "y": stroke}), nominal)
    first = found.findings[0]
    assert first.identifier == "end-stop"
    assert first.parameters["position"].value == pytest.approx(PLACE, rel=0.05)
    assert found.fit.improved < 0.05 < found.fit.refitted


def in_a_loop(wanted, period, force, gain, rate):
    """Command and position of an axis that a PD controller drives where it is wanted, and which a force opposes."""
    fine = 20
    command, axis = np.zeros(len(wanted)), np.zeros(len(wanted))
    position, velocity = 0.0, 0.0
    for k, goal in enumerate(wanted):
        axis[k] = position
        command[k] = np.clip(8.0 * (goal - position) - 4.0 * velocity, -5.0, 5.0)
        for j in range(fine):
            opposing = force(period * (k + j / fine), position, velocity)
            velocity += period / fine * (gain * (command[k] - opposing) - rate * velocity)
            position += period / fine * velocity
    return command, axis


def diagnosed(command, recorded, period, numerator, damping):
    """Of an axis whose loop the simulation does not declare."""
    nominal = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [numerator], "denominator": [1.0, damping, 0.0]}},
        "sensor": {"column": "y", "kind": "instant"},
    }
    table = pd.DataFrame({"t": period * np.arange(len(command)), "u": command, "y": recorded})
    return camid.diagnose(table, nominal)


def test_a_buffer_in_a_loop_that_is_not_declared_is_found_beside_coefficients_of_either_sign():
    """Without the buffer the plant that is estimated from what the loop commanded may even have the other sign."""
    generator = np.random.default_rng(8)
    wanted = np.repeat(generator.uniform(-0.7, 0.75, 20), 125)
    command, trolley = in_a_loop(wanted, 0.02, lambda _t, y, _v: 25.0 * max(y - 0.5, 0.0), 0.99, 0.4)
    found = diagnosed(command, 1.2 + trolley + 0.001 * generator.normal(size=len(wanted)), 0.02, 0.8, 0.5)
    assert [f.identifier for f in found.findings] == ["end-stop"]
    for name, truth in (("position", 0.5), ("stiffness", 25.0)):
        assert found.findings[0].parameters[name].value == pytest.approx(truth, rel=0.01)
    assert found.fit.improved < 0.05 < found.fit.refitted


def test_friction_and_a_load_that_sets_in_are_found_together_in_a_loop_that_is_not_declared():
    """With one of them alone the axis runs away from the recording as well."""
    generator = np.random.default_rng(12)
    onset, load, friction = 22.22, 0.66, 0.35
    wanted = np.repeat(generator.uniform(-1.5, 1.5, 16), 150)

    def force(time, _, velocity):
        return friction * np.tanh(velocity / 1e-3) + (load if time >= onset else 0.0)

    command, axis = in_a_loop(wanted, 0.02, force, 1.2, 1.2)
    found = diagnosed(command, 2.0 + axis + 0.002 * generator.normal(size=len(wanted)), 0.02, 0.9, 1.6)
    named = {f.identifier: f.parameters for f in found.findings}
    assert set(named) == {"coulomb-friction", "step-disturbance"}
    assert named["step-disturbance"]["time"].value == pytest.approx(onset, abs=0.1)
    assert abs(named["step-disturbance"]["size"].value) == pytest.approx(load, rel=0.02)
    assert named["coulomb-friction"]["force"].value == pytest.approx(friction, rel=0.02)
    assert found.fit.improved < 0.02
    assert found.fit.refitted > 0.5


def test_friction_that_sticks_and_a_load_that_sets_in_meanwhile_are_found_in_a_loop_that_is_not_declared():
    """The axis rests at other places for the least error: the sum of squares over the whole recording is rugged."""
    generator = np.random.default_rng(31)
    onset, load = 24.4, -0.66
    wanted = np.repeat(generator.uniform(-1.5, 1.5, 16), 150)

    def force(time, _, velocity):
        level = 0.35 + 0.37 * np.exp(-((velocity / 0.1) ** 2))
        return level * np.tanh(velocity / 1e-3) + (load if time >= onset else 0.0)

    command, axis = in_a_loop(wanted, 0.02, force, 1.2, 1.2)
    found = diagnosed(command, 2.3 + axis + 0.002 * generator.normal(size=len(wanted)), 0.02, 1.5, 1.4)
    named = {f.identifier: f.parameters for f in found.findings}
    assert set(named) - {"coloured-noise"} == {"stribeck-friction", "step-disturbance"}
    assert named["step-disturbance"]["time"].value == pytest.approx(onset, abs=0.1)
    assert abs(named["step-disturbance"]["size"].value) == pytest.approx(abs(load), rel=0.02)
    assert named["stribeck-friction"]["coulomb"].value == pytest.approx(0.35, rel=0.03)
    assert named["stribeck-friction"]["breakaway"].value == pytest.approx(0.72, rel=0.1)
    assert found.fit.improved < 0.02


def test_forces_are_found_one_after_the_other_and_no_more_than_explain_something(actuator):
    time, command, stroke = actuator
    seen = situation(time, command, stroke)
    shapes = [EndStop(position=PLACE, stiffness=1.0), CoulombFriction(force=1.0), QuadraticDrag(coefficient=1.0)]
    found, *others = plants_beside_laws(seen, shapes, 3)
    assert [type(law) for law in found.laws] == [EndStop]
    assert all(found.left < other.left for other in others)
    assert found.laws[0].values["stiffness"] > 0.0
    assert found.plant.denominator[1] == pytest.approx(RATE, rel=0.2)  # the buffer is progressive
    assert plants_beside_laws(seen, [CoulombFriction(force=1.0)], 2) == []
