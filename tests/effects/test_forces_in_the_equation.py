"""Plants beside a force over the position, by their equation at the recorded positions."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.actuator import RateLimit, Saturation
from camid.effects.arm_gravity import ArmGravity
from camid.effects.damping import QuadraticDrag
from camid.effects.dead_zone import DeadZone
from camid.effects.equation_of_motion import equations_of_motion
from camid.effects.force_over_position import plant_beside_stops
from camid.effects.friction import CoulombFriction
from camid.effects.gradual_friction import GradualCoulombFriction
from camid.effects.periodic_in_position import Cogging
from camid.effects.pursued_forces import plants_beside_laws
from camid.effects.sensor import Delay
from camid.effects.situation import Situation
from camid.effects.stiffness import CubicStiffness, EndStop

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
    found = plant_beside_stops(situation(*actuator))
    ((place, stiffness),) = found.stops
    assert place == pytest.approx(PLACE, rel=0.05)
    assert stiffness > STIFFNESS  # the buffer is progressive
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
    assert plant_beside_stops(situation(time, command, position)) is None


@pytest.mark.slow
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


def test_a_curve_of_the_command_stands_before_the_forces(actuator):
    time, command, _ = actuator
    limit, friction = 18.0, 4.0
    velocity, fine = np.zeros(ROWS), 20
    for k in range(ROWS - 1):
        speed = velocity[k]
        for _ in range(fine):
            pushed = np.clip(command[k], -limit, limit) - friction * np.tanh(speed / 0.02)
            speed += PERIOD / fine * (GAIN * pushed - RATE * speed)
        velocity[k + 1] = speed
    seen = situation(time, command, PERIOD * np.cumsum(velocity))
    curves = [Saturation(limit=size) for size in (10.0, 14.0, limit, 25.0)]
    best = plants_beside_laws(seen, [CoulombFriction(force=1.0)], 2, curves)[0]
    assert [type(law) for law in best.laws] == [Saturation, CoulombFriction]
    assert best.laws[0].values["limit"] == limit
    assert best.laws[1].values["force"] == pytest.approx(friction, rel=0.2)
    # A curve that takes nothing of the command explains nothing.
    assert all(
        not isinstance(each.laws[0], Saturation) for each in plants_beside_laws(seen, [], 2, [Saturation(limit=41.0)])
    )


def test_a_rate_and_a_delay_stand_before_the_forces(actuator):
    time, command, _ = actuator
    rate, late, friction, fine = 12.0, 4, 4.0, 20
    velocity, arrived = np.zeros(ROWS), 0.0
    for k in range(ROWS - 1):
        speed = velocity[k]
        for _ in range(fine):
            arrived += np.clip(command[max(k - late, 0)] - arrived, -rate * PERIOD / fine, rate * PERIOD / fine)
            speed += PERIOD / fine * (GAIN * (arrived - friction * np.tanh(speed / 0.02)) - RATE * speed)
        velocity[k + 1] = speed
    seen = situation(time, command, PERIOD * np.cumsum(velocity))
    curves = [*(RateLimit(rate=each) for each in (6.0, 9.0, rate, 20.0)), Saturation(limit=14.0)]
    delays = [Delay(delay=periods * PERIOD) for periods in range(1, 11)]
    best = plants_beside_laws(seen, [CoulombFriction(force=1.0)], 2, curves, delays)[0]
    assert [type(law) for law in best.laws] == [RateLimit, Delay, CoulombFriction]
    assert best.laws[0].values["rate"] == rate
    assert best.laws[1].values["delay"] == pytest.approx(late * PERIOD, abs=1.01 * PERIOD)
    assert best.laws[2].values["force"] == pytest.approx(friction, rel=0.2)
    # A command that is held is late by half a period anyway.
    on_time = situation(time, command, PERIOD * np.cumsum(np.roll(velocity, -late)))
    best = plants_beside_laws(on_time, [CoulombFriction(force=1.0)], 2, curves, delays)[0]
    assert [type(law) for law in best.laws] == [RateLimit, CoulombFriction]


def test_a_curve_of_the_command_is_found_beside_a_force_that_hides_it():
    """Alone another dead zone leaves least: most of what arrives of the command holds an arm."""
    generator, period, half, fine = np.random.default_rng(7), 0.01, 0.6, 20
    wanted = np.repeat(generator.uniform(-1.2, 1.2, ROWS // 125), 125)
    command, arm = np.zeros(ROWS), np.zeros(ROWS)
    position, velocity = 0.0, 0.0
    for k in range(ROWS):
        arm[k] = position
        command[k] = 8.0 * (wanted[k] - position) - 4.0 * velocity
        arrived = np.sign(command[k]) * max(abs(command[k]) - half, 0.0)
        for _ in range(fine):
            velocity += period / fine * (9.0 * (arrived - 2.2 * np.sin(position + 0.3)) - 2.5 * velocity)
            position += period / fine * velocity
    nothing, used = np.zeros(ROWS), np.ones(ROWS, bool)
    plant = TransferFunction((7.0,), (1.0, 3.4, 0.0))
    instant = Acquisition(period, sensor="instant")
    seen = Situation(period * np.arange(ROWS), command, arm, nothing, nothing, nothing, plant, instant, used)
    curves = [DeadZone(half_width=each) for each in (0.2, 0.4, half, 0.9, 1.5, 2.5, 4.0)]
    shapes = [ArmGravity(amplitude=1.0, torque=1.0, phase=each) for each in (0.0, 0.3, 0.8, 1.6)]
    best = plants_beside_laws(seen, [*shapes, CubicStiffness(coefficient=1.0)], 2, curves)[0]
    assert type(best.laws[0]) is DeadZone
    assert best.laws[0].values["half_width"] == half
    assert best.laws[1].values["phase"] == 0.3
    assert best.laws[1].values["torque"] == pytest.approx(2.2, rel=0.05)


def test_each_force_leaves_of_a_command_what_it_leaves_alone(actuator):
    time, command, stroke = actuator
    (equation, *_) = equations_of_motion(situation(time, command, stroke), friction=False)
    forces = np.column_stack([np.maximum(equation.motion[1] - PLACE, 0.0), equation.motion[1] ** 3])
    half = 0.5 * np.tanh(command)
    found = equation.left_with_each([command, half], forces)
    for row, arrived in zip(found, (command, half), strict=True):
        bent = equation.beside(arrived)
        alone = bent.left_by_each(forces, np.zeros((len(time), 0)))
        np.testing.assert_allclose(row, bent.unexplained * alone, rtol=1e-9)


def test_friction_of_an_axis_may_grow_with_the_load():
    """It is begun from friction that does not, with the same level at the usual load, if that is more."""
    signal = np.linspace(-2.0, 2.0, 101)
    axis = SimpleNamespace(signal=signal, plant=TransferFunction((1.0,), (1.0, 1.0, 0.0)))
    (loaded,) = (law for law in CoulombFriction(force=0.2).relatives(axis) if law.identifier != "dead-zone")
    assert loaded.identifier == "load-dependent-friction"
    usual = float(np.median(np.abs(signal)))
    assert loaded.values["force"] + loaded.values["coefficient"] * usual == pytest.approx(0.2)
    assert [law.identifier for law in CoulombFriction(force=20.0).relatives(axis)] == ["dead-zone"]
    gradual = GradualCoulombFriction(force=0.2, transition=0.1)
    assert [law.identifier for law in gradual.relatives(axis)] == ["dead-zone"]


def test_a_period_is_found_between_those_that_are_guessed():
    """Over thirty poles: a guess that is a little off is a good part of a pole off at the end."""
    generator, period = np.random.default_rng(9), 3.2
    time, parts = 0.01 * np.arange(ROWS), 20
    command = 20.0 * np.repeat(generator.choice([-1.0, -0.6, 0.7, 1.0], ROWS // 60), 60)
    stroke, position, velocity = np.zeros(ROWS), 0.0, 0.0
    for k, held in enumerate(command):
        stroke[k] = position
        for _ in range(parts):
            pole = 6.0 * np.sin(2.0 * np.pi * position / period + 0.4)
            velocity += 0.01 / parts * (2.0 * (held - pole) - 3.0 * velocity)
            position += 0.01 / parts * velocity
    given = situation(
        time, command, stroke + 1e-4 * generator.normal(size=ROWS), TransferFunction((1.5,), (1.0, 4.0, 0.0))
    )
    given = replace(given, acquisition=Acquisition(0.01, sensor="instant"))
    ((law,),) = [each.laws for each in plants_beside_laws(given, [Cogging(amplitude=6.0, period=3.21, phase=0.4)], 1)]
    assert law.values["period"] == pytest.approx(period, rel=1e-3)
    assert law.values["phase"] == pytest.approx(0.4, abs=0.1)
    assert law.values["amplitude"] == pytest.approx(6.0, rel=0.05)
