"""Equations of motion of the rigs, written by hand: nothing here is derived from the text that the tool is given."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import sin, sqrt

Constants = Mapping[str, float]
State = Sequence[float]
# From state, input and constants to the rates of the states (per second).
Rates = Callable[[State, float, Constants], tuple[float, ...]]


def first(state: State) -> float:
    """The first state is measured."""
    return state[0]


def second(state: State) -> float:
    """The second state is measured."""
    return state[1]


def third(state: State) -> float:
    """The third state is measured."""
    return state[2]


def spring(state: State, force: float, c: Constants) -> tuple[float, ...]:
    """A force (N) on a mass with spring and damper: position and speed."""
    position, speed = state[0], state[1]
    return speed, (force - c["damping"] * speed - c["stiffness"] * position) / c["mass"]


def spring_with_gain(state: State, signal: float, c: Constants) -> tuple[float, ...]:
    """The same behind an amplifier."""
    return spring(state, c["gain"] * signal, c)


def spring_with_two_dampers(state: State, force: float, c: Constants) -> tuple[float, ...]:
    """The same with two dampers on the mass."""
    position, speed = state[0], state[1]
    drag = c["bearing"] * speed + c["brake"] * speed
    return speed, (force - drag - c["stiffness"] * position) / c["mass"]


def cart(state: State, force: float, c: Constants) -> tuple[float, ...]:
    """A force (N) on a cart with viscous friction: position and speed."""
    return state[1], (force - c["damping"] * state[1]) / c["mass"]


def motor(state: State, voltage: float, c: Constants) -> tuple[float, ...]:
    """A voltage on a motor without inductance: angle and speed."""
    current = (voltage - c["torque_constant"] * state[1]) / c["resistance"]
    return state[1], (c["torque_constant"] * current - c["friction"] * state[1]) / c["inertia"]


def two_masses(state: State, force: float, c: Constants) -> tuple[float, ...]:
    """A force (N) on the first of two masses that a spring couples: positions and speeds, the motor's first."""
    motor, motor_speed, load, load_speed = state[0], state[1], state[2], state[3]
    coupling = c["stiffness"] * (motor - load) + c["damping"] * (motor_speed - load_speed)
    drag = c["friction"] * motor_speed
    return motor_speed, (force - drag - coupling) / c["motor_mass"], load_speed, coupling / c["load_mass"]


def quarter_car(state: State, road: float, c: Constants) -> tuple[float, ...]:
    """A road's height (m) below a wheel that carries a body: heights and speeds, the body's first."""
    body, body_speed, wheel, wheel_speed = state[0], state[1], state[2], state[3]
    suspension = c["spring"] * (wheel - body) + c["damper"] * (wheel_speed - body_speed)
    tyre = c["tyre"] * (road - wheel)
    return body_speed, suspension / c["body_mass"], wheel_speed, (tyre - suspension) / c["wheel_mass"]


def travel(state: State) -> float:
    """Travel of the suspension (m)."""
    return state[0] - state[2]


def heater(state: State, power: float, c: Constants) -> tuple[float, ...]:
    """A power (W) into a heater that warms a plate: temperatures above the room's."""
    heater, plate = state[0], state[1]
    flow = c["transfer"] * (heater - plate)
    return (power - flow) / c["heater_capacity"], (flow - c["loss"] * plate) / c["plate_capacity"]


def pendulum(state: State, torque: float, c: Constants) -> tuple[float, ...]:
    """A torque (N m) on a pendulum: angle from hanging and speed."""
    weight = c["mass"] * c["gravity"] * c["length"] * sin(state[0])
    return state[1], (torque - c["damping"] * state[1] - weight) / c["inertia"]


def hardening(state: State, force: float, c: Constants) -> tuple[float, ...]:
    """A force (N) on a mass on a spring that hardens: position and speed."""
    position, speed = state[0], state[1]
    spring = c["linear"] * position + c["cubic"] * position * position * position
    return speed, (force - c["damping"] * speed - spring) / c["mass"]


def tanks(state: State, signal: float, c: Constants) -> tuple[float, ...]:
    """A pump fills a tank that empties into a second one (Torricelli): levels."""
    between, out = c["upper_outflow"] * sqrt(state[0]), c["lower_outflow"] * sqrt(state[1])
    return c["pump"] * signal - between, between - out


def unequal_tanks(state: State, signal: float, c: Constants) -> tuple[float, ...]:
    """The same with tanks of different cross sections."""
    upper, lower = sqrt(state[0]), sqrt(state[1])
    return c["pump"] * signal - c["upper_out"] * upper, c["lower_in"] * upper - c["lower_out"] * lower


def float_with_drag(state: State, force: float, c: Constants) -> tuple[float, ...]:
    """A force (N) on a float with quadratic drag: heave and speed."""
    position, speed = state[0], state[1]
    return speed, (force - c["drag"] * speed * abs(speed) - c["buoyancy"] * position) / c["mass"]
