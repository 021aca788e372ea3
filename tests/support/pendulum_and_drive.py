"""Rigs that the tests simulate with an integrator of their own: a pendulum, a disc, and a drive in a closed loop."""

from functools import cache
from math import copysign, inf, pi, sin

import numpy as np
import pandas as pd

SUBSTEPS = 40


def friction_step(velocity, acceleration, level, step):
    """Velocity after a step with dry friction that stops the motion and holds it."""
    free = velocity + step * acceleration
    loss = step * level
    return copysign(max(abs(free) - loss, 0.0), free)


def pendulum(
    *,
    natural_frequency,
    damping,
    rest,
    angle,
    friction=0.0,
    load=0.0,
    period=0.01,
    count=3000,
    noise=0.0,
    seed=0,
    velocity=0.0,
):
    """Free decay of a pendulum, dry friction in rad of static deflection; columns t, angle.

    ``load`` is the share by which the friction of the bearing grows with the square of the velocity that pulls at it.
    """
    angles = _angles(natural_frequency, damping, rest, angle, friction, load, period, count, velocity)
    random = np.random.default_rng(np.random.SeedSequence(seed))
    return pd.DataFrame({"t": period * np.arange(count), "angle": angles + noise * random.standard_normal(count)})


@cache
def _angles(natural_frequency, damping, rest, angle, friction, load, period, count, velocity):
    """Angles without noise, shape (count,)."""
    y, v = angle, velocity
    step = period / SUBSTEPS
    rows = np.empty(count)
    square = natural_frequency**2
    for k in range(count):
        rows[k] = y
        for _ in range(SUBSTEPS):
            # Kick, drift, kick: the friction acts on both kicks.
            pull = -square * sin(y - rest) - 2.0 * damping * natural_frequency * v
            v = friction_step(v, pull, square * friction * (1.0 + load * v * v), 0.5 * step)
            y += step * v
            pull = -square * sin(y - rest) - 2.0 * damping * natural_frequency * v
            v = friction_step(v, pull, square * friction * (1.0 + load * v * v), 0.5 * step)
    return rows


LEVELS = (-0.7, -0.45, -0.1, 0.2, 0.5, 0.7)


def disc(*, friction=0.0, delay=0.0, bias=0.0, count, period=0.02, noise=0.003, seed=0, levels=LEVELS, held=10):
    """An unbalanced disc on a motor, its heavy side down at rest; columns t, u, y.

    A torque of one turns it as far as gravity does at a right angle. ``delay`` is that of the input, in seconds, and
    ``held`` the frames between two of its levels.
    """
    random = np.random.default_rng(np.random.SeedSequence(seed))
    signal = np.repeat(random.choice(levels, count // held + 1), held)[:count]
    y, v, step = 0.0, 0.0, period / SUBSTEPS
    angles = np.empty(count)
    for k in range(count):
        angles[k] = y
        for part in range(SUBSTEPS):
            row = int(np.floor(k + (part + 0.5) / SUBSTEPS - delay / period))
            torque = (float(signal[row]) if row >= 0 else 0.0) + bias
            v = friction_step(v, 100.0 * (torque - sin(y)) - 5.0 * v, 100.0 * friction, 0.5 * step)
            y += step * v
            v = friction_step(v, 100.0 * (torque - sin(y)) - 5.0 * v, 100.0 * friction, 0.5 * step)
    angles += noise * random.standard_normal(count)
    return pd.DataFrame({"t": period * np.arange(count), "u": signal, "y": angles})


def drive(
    *,
    mass,
    viscous,
    friction=0.0,
    bias=0.0,
    ripple=0.0,
    position_gain=8.0,
    velocity_gain=150.0,
    limit=inf,
    actuator=None,
    period=0.01,
    count=3000,
    noise=0.0,
    seed=0,
):
    """A mass on a drive that follows a reference; columns t, r, u, y; noise on the control.

    ``actuator`` (command, what it made of the last one, seconds since then) gives the force that reaches the mass.
    """
    random = np.random.default_rng(np.random.SeedSequence(seed))
    rig = (mass, viscous, friction, bias, ripple, position_gain, velocity_gain, limit, actuator)
    reference, positions, controls = _loop(*rig, period, count)
    controls = controls + noise * random.standard_normal(count)
    return pd.DataFrame({"t": period * np.arange(count), "r": reference, "u": controls, "y": positions})


@cache
def _loop(mass, viscous, friction, bias, ripple, position_gain, velocity_gain, limit, actuator, period, count):
    """Reference, position and control without noise, each of shape (count,)."""
    time = period * np.arange(count)
    reference = 0.3 * np.sin(0.9 * time) + 0.1 * np.sin(2.3 * time + 1.0) + 0.05 * np.sin(5.1 * time)
    y, v, step = float(reference[0]), 0.0, period / SUBSTEPS
    positions, controls = np.empty(count), np.empty(count)
    passed = 0.0
    for k in range(count):
        control = min(max(velocity_gain * (position_gain * (float(reference[k]) - y) - v), -limit), limit)
        positions[k], controls[k] = y, control
        for _ in range(SUBSTEPS):
            passed = control if actuator is None else actuator(control, passed, step)
            # A screw that is not straight: the friction changes along its turns.
            level = friction * (1.0 + ripple * sin(2.0 * pi * y / 0.04))
            v = friction_step(v, (passed + bias - viscous * v) / mass, level / mass, 0.5 * step)
            y += step * v
            v = friction_step(v, (passed + bias - viscous * v) / mass, level / mass, 0.5 * step)
    return reference, positions, controls


def pendulum_simulation(**parameters):
    """What one would write first of it."""
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": None,
        "plant": {"pendulum": parameters},
        "sensor": {"column": "angle", "kind": "instant"},
        "initial_state": "estimate",
    }


def drive_simulation(mass, viscous, *, position_gain=8.0, velocity_gain=150.0, limit=None):
    """What one would write first of it."""
    controller = {"reference": "r", "position_gain": position_gain, "velocity_gain": velocity_gain}
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [1.0], "denominator": [mass, viscous, 0.0]}},
        "controller": controller | ({} if limit is None else {"limit": limit}),
        "sensor": {"column": "y", "kind": "instant"},
        "initial_state": "estimate",
    }


def disc_simulation():
    """What one would write first of it: a spring in the place of gravity."""
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [90.0], "denominator": [1.0, 6.0, 90.0]}},
        "sensor": {"column": "y", "kind": "instant"},
        "initial_state": "estimate",
    }
