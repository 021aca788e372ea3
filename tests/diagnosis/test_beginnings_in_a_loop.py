"""Plants that integrate, in a loop that the simulation does not declare: what is missing is found in their equation."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.diagnosis import run
from camid.diagnosis.search.beginnings_in_a_loop import Beginning, first_beginning


def in_a_loop(wanted, period, force, gain, rate, drive=lambda command: command):
    """Command and position of an axis that a PD controller drives where it is wanted, and which a force opposes."""
    fine = 20
    command, axis = np.zeros(len(wanted)), np.zeros(len(wanted))
    position, velocity = 0.0, 0.0
    for k, goal in enumerate(wanted):
        axis[k] = position
        command[k] = np.clip(8.0 * (goal - position) - 4.0 * velocity, -5.0, 5.0)
        for j in range(fine):
            opposing = force(period * (k + j / fine), position, velocity)
            velocity += period / fine * (gain * (drive(command[k]) - opposing) - rate * velocity)
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


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
def test_a_drive_that_saturates_is_found_beside_friction_and_a_load_that_sets_in():
    """With two of three the axis runs away from the recording: the curve of the command stands before the forces."""
    generator = np.random.default_rng(4)
    limit, friction, load, onset = 2.2, 0.3, 0.5, 17.3
    wanted = np.repeat(generator.uniform(-1.5, 1.5, 16), 150)

    def force(time, _, velocity):
        return friction * np.tanh(velocity / 1e-3) + (load if time >= onset else 0.0)

    command, axis = in_a_loop(wanted, 0.02, force, 1.2, 1.0, drive=lambda u: np.clip(u, -limit, limit))
    found = diagnosed(command, 2.0 + axis + 0.001 * generator.normal(size=len(wanted)), 0.02, 0.95, 1.5)
    named = {f.identifier: f.parameters for f in found.findings}
    assert set(named) >= {"saturation", "coulomb-friction", "step-disturbance"}
    assert named["saturation"]["limit"].value == pytest.approx(limit, rel=0.01)
    assert named["coulomb-friction"]["force"].value == pytest.approx(friction, rel=0.02)
    assert abs(named["step-disturbance"]["size"].value) == pytest.approx(load, rel=0.02)
    assert found.fit.improved < 0.02 < found.fit.refitted


@pytest.mark.slow
def test_buffers_at_both_ends_of_the_way_are_found_in_a_loop_that_is_not_declared():
    generator = np.random.default_rng(6)
    wanted = np.repeat(generator.uniform(-0.9, 0.9, 20), 125)

    def force(_time, position, _velocity):
        return 30.0 * max(position - 0.5, 0.0) + 18.0 * min(position + 0.6, 0.0)

    command, trolley = in_a_loop(wanted, 0.02, force, 0.99, 0.4)
    found = diagnosed(command, 1.2 + trolley + 0.001 * generator.normal(size=len(wanted)), 0.02, 0.8, 0.5)
    assert [f.identifier for f in found.findings] == ["end-stop"]
    values = {name: estimate.value for name, estimate in found.findings[0].parameters.items()}
    ends = {values["position"]: values["stiffness"], values["opposite"]: values["opposite_stiffness"]}
    assert sorted(ends) == pytest.approx([-0.6, 0.5], rel=0.01)
    assert [ends[place] for place in sorted(ends)] == pytest.approx([18.0, 30.0], rel=0.03)
    assert found.fit.improved < 0.05 < found.fit.refitted


@pytest.mark.slow
def test_a_valve_that_overlaps_is_found_beside_a_late_camera_and_a_load_that_is_constant():
    """It was Coulomb friction; the load, which acts behind the valve, an arm that hardly turns."""
    generator = np.random.default_rng(6)
    overlap, load, late, period = 0.5, 0.3, 4, 0.02
    wanted = np.repeat(generator.uniform(-1.5, 1.5, 24), 100)

    def drive(command):
        return np.sign(command) * max(abs(command) - overlap, 0.0)

    command, axis = in_a_loop(wanted, period, lambda _t, _y, _v: load, 1.2, 4.0, drive)
    seen = np.concatenate([np.zeros(late), axis[:-late]])
    found = diagnosed(command, 2.0 + seen + 0.002 * generator.normal(size=len(wanted)), period, 0.9, 5.0)
    named = {f.identifier: f.parameters for f in found.findings}
    assert {"dead-zone", "delay", "input-bias"} <= set(named)
    assert named["dead-zone"]["half_width"].value == pytest.approx(overlap, rel=0.02)
    assert named["delay"]["delay"].value == pytest.approx(late * period, rel=0.05)
    assert named["input-bias"]["bias"].value == pytest.approx(-load, rel=0.05)


@pytest.mark.slow
def test_the_limit_of_a_rate_is_found_in_the_loop_of_a_controller_that_is_often_at_its_own():
    """An edge at the limit of the command would leave nothing of it, and so explain all."""
    generator = np.random.default_rng(5)
    period, rows, rate, fine = 0.002, 3000, 150.0, 20
    wanted = np.repeat(generator.uniform(0.02, 0.25, rows // 300), 300)
    command, axis, position, velocity, arrived = np.zeros(rows), np.zeros(rows), 0.0, 0.0, 0.0
    for k, goal in enumerate(wanted):
        axis[k] = position
        command[k] = np.clip(8.0 * (25.0 * (goal - position) - velocity), -10.0, 10.0)
        for _ in range(fine):
            step = rate * period / fine
            moved = np.clip(command[k] - arrived, -step, step)
            velocity += period / fine * (4.0 * (arrived + 0.5 * moved) - 6.0 * velocity)
            position += period / fine * velocity
            arrived += moved
    nominal = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [3.2], "denominator": [1.0, 7.8, 0.0]}},
        "controller": {"reference": "r", "position_gain": 25.0, "velocity_gain": 8.0, "limit": 10.0},
        "sensor": {"column": "y", "kind": "instant"},
    }
    table = {"t": period * np.arange(rows), "r": wanted, "u": command + 0.003 * generator.normal(size=rows), "y": axis}
    found = camid.diagnose(pd.DataFrame(table), nominal)
    assert found.findings[0].identifier == "rate-limit"
    assert found.findings[0].parameters["rate"].value == pytest.approx(rate, rel=0.05)


def arm_behind_a_dead_zone():
    """Command and reading of an arm, whose torque is 2.2 sin(y + 0.3), behind a dead zone of 0.6."""
    generator = np.random.default_rng(7)
    wanted = np.repeat(generator.uniform(-1.2, 1.2, 24), 125)

    def force(_time, position, _velocity):
        return 2.2 * np.sin(position + 0.3)

    def drive(command):
        return np.sign(command) * max(abs(command) - 0.6, 0.0)

    command, arm = in_a_loop(wanted, 0.01, force, 9.0, 2.5, drive=drive)
    return command, arm + 0.002 * generator.normal(size=len(wanted))


@pytest.mark.slow
def test_gravity_on_an_arm_and_a_dead_zone_before_its_motor_are_found_together():
    """Alone the dead zone that leaves least is another one, and gravity without it is a spring of any form."""
    found = diagnosed(*arm_behind_a_dead_zone(), 0.01, 7.0, 3.4)
    named = {f.identifier: f.parameters for f in found.findings}
    assert set(named) == {"dead-zone", "pendulum-gravity"}
    assert named["dead-zone"]["half_width"].value == pytest.approx(0.6, rel=0.02)
    for name, truth in (("amplitude", 1.0), ("torque", 2.2), ("phase", 0.3)):
        assert named["pendulum-gravity"][name].value == pytest.approx(truth, rel=0.03)
    assert found.fit.improved < 0.02 < found.fit.refitted


@pytest.mark.slow
def test_what_an_observer_has_shown_is_estimated_without_it_where_the_plant_follows(monkeypatch):
    """The pull bends what is estimated, and leaves a structure where nothing is missing any more."""

    def beginning(problem, base, pulled=None, *, held=False):
        return first_beginning(problem, base, held=True) if held else Beginning(runs_away=True)

    monkeypatch.setattr(run, "first_beginning", beginning)
    command, arm = arm_behind_a_dead_zone()
    found = diagnosed(command, arm, 0.01, 7.0, 3.4)
    assert {f.identifier for f in found.findings} == {"dead-zone", "pendulum-gravity"}
    assert not [warning for warning in found.warnings if "an observer pulls" in warning]
    assert found.fit.improved < 0.02 < found.fit.refitted
