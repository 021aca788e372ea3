"""Forces on the machine that are left out of the simulation, each from its own mechanics.

The strengths are ratios to forces and positions of the same machine without the effect. Sources: see
:mod:`camid.proof.concealed.machine_forces`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from camid.proof.concealed import vector_layout as s
from camid.proof.concealed.rig_setup import Context, Effect, Setup

Parameters = dict[str, float | str | None]

# Standard deviations of the speed that are not exceeded at twice the amplitude.
TOP_SPEED = 6.0


def built_in(
    identity: str,
    law: str,
    values: Callable[[float], dict[int, float]],
    parameters: Callable[[float], Parameters],
    start: float = 0.1,
    high: float = 1e3,
    place: str = "plant",
    repeatable: bool = True,
    refinement: int = 1,
) -> Effect:
    """Effect that sets places of the integrator's parameter vector."""

    def apply(setup: Setup, strength: float) -> None:
        for slot, value in values(strength).items():
            setup.parameters[slot] = value
        setup.refinement *= refinement

    return Effect(identity, place, law, apply, parameters, start, high, repeatable)


def coulomb_friction(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Stick-slip on a constant level; or bristles (LuGre, Dahl) that bend before they slide."""
    constant = context.rig.actuator_constant
    largest = constant * context.peak

    def parameters(strength: float) -> Parameters:
        return {"force": strength * largest / constant}

    if not alternative:
        return built_in(
            "coulomb-friction",
            "catalogue",
            lambda g: {s.DRY_COULOMB: g * largest, s.DRY_BREAKAWAY: g * largest},
            parameters,
            0.05,
            0.9,
        )
    bend = generator.uniform(0.03, 0.15) * context.stroke
    lugre = generator.random() < 0.5
    damping = generator.uniform(0.1, 0.5) * context.rig.damping if lugre else 0.0
    return built_in(
        "coulomb-friction",
        "lugre" if lugre else "dahl",
        lambda g: {
            s.BRISTLE_COULOMB: g * largest,
            s.BRISTLE_BREAKAWAY: g * largest,
            s.BRISTLE_STIFFNESS: g * largest / bend,
            s.TOP_SPEED: TOP_SPEED * context.speed,
            # A damping that stays where the friction goes would be all that is left of it.
            s.BRISTLE_DAMPING: g * damping,
        },
        parameters,
        0.05,
        0.9,
    )


def stribeck_friction(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A level that falls with speed from its value at break-away."""
    constant, scale = context.rig.actuator_constant, context.rig.output_scale
    largest = constant * context.peak
    ratio = generator.uniform(1.5, 3.0)
    velocity = generator.uniform(0.2, 1.0) * context.speed

    def parameters(strength: float) -> Parameters:
        force = strength * largest / constant
        return {"coulomb": force / ratio, "breakaway": force, "velocity": velocity * scale}

    if not alternative:
        return built_in(
            "stribeck-friction",
            "catalogue",
            lambda g: {s.DRY_COULOMB: g * largest / ratio, s.DRY_BREAKAWAY: g * largest, s.DRY_VELOCITY: velocity},
            parameters,
            0.05,
            0.9,
        )
    bend = generator.uniform(0.03, 0.15) * context.stroke
    return built_in(
        "stribeck-friction",
        "lugre-stribeck",
        lambda g: {
            s.BRISTLE_COULOMB: g * largest / ratio,
            s.BRISTLE_BREAKAWAY: g * largest,
            s.BRISTLE_VELOCITY: velocity,
            s.BRISTLE_STIFFNESS: g * largest / bend,
            s.TOP_SPEED: TOP_SPEED * context.speed,
            s.BRISTLE_DAMPING: g * 0.2 * context.rig.damping,
        },
        parameters,
        0.05,
        0.9,
    )


def quadratic_drag(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Drag that grows with the square of the speed; or with its power of 1.8."""
    rig = context.rig
    exponent = 1.8 if alternative else 2.0
    unit = rig.actuator_constant * context.drive / context.speed**exponent
    return built_in(
        "quadratic-drag",
        "drag-exponent-1.8" if alternative else "catalogue",
        lambda g: {s.DRAG: g * unit, s.DRAG_EXPONENT: exponent},
        lambda g: {"coefficient": g * rig.actuator_constant * context.drive / context.speed**2 / _force(context, 2)},
        0.05,
    )


def _force(context: Context, power: int) -> float:
    """N/m^power in a volt per unit of the output to that power."""
    return context.rig.actuator_constant * context.rig.output_scale**power


def cubic_stiffness(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Hardening or softening spring; or with a term of fifth degree, or side springs that stretch."""
    rig = context.rig
    unit = rig.stiffness / context.stroke**2
    sign = generator.choice([-1.0, 1.0])
    if not alternative:
        return built_in(
            "cubic-stiffness",
            "catalogue",
            lambda g: {s.CUBIC: sign * g * unit},
            lambda g: {"coefficient": sign * g * unit / _force(context, 3)},
            0.03,
        )
    if generator.random() < 0.5:
        fifth = generator.uniform(0.03, 0.1)
        return built_in(
            "cubic-stiffness",
            "with-quintic",
            # The term of fifth degree keeps the softening spring from giving way.
            lambda g: {s.CUBIC: sign * g * unit, s.QUINTIC: fifth * g * unit / context.stroke**2},
            lambda g: {"coefficient": sign * g * unit / _force(context, 3)},
            0.03,
        )
    length = generator.uniform(3.0, 6.0) * context.stroke
    return built_in(
        "cubic-stiffness",
        "side-springs",
        lambda g: {s.SIDE_STIFFNESS: g * unit * length**2, s.SIDE_LENGTH: length},
        lambda g: {"coefficient": g * unit / _force(context, 3)},
        0.03,
    )


def quadratic_stiffness(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Spring that is stiffer to one side; or with a small cubic term."""
    unit = context.rig.stiffness / context.stroke
    sign = generator.choice([-1.0, 1.0])
    extra = generator.uniform(0.15, 0.4) if alternative else 0.0
    return built_in(
        "quadratic-stiffness",
        "with-cubic" if alternative else "catalogue",
        lambda g: {s.QUADRATIC: sign * g * unit, s.CUBIC: extra * g * unit / context.stroke},
        lambda g: {"coefficient": sign * g * unit / _force(context, 2)},
        0.03,
    )


def pendulum_gravity(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Weight on a rod: A sin(y/A); or driven by a force that stays horizontal, and damped by the air.

    The air takes a share of what the sine takes from the spring, k y³/(6 A²), at every size: were it in proportion to
    the swing, little would be left of a small one but quadratic drag, which has a name of its own.
    """
    rig = context.rig
    drag = generator.uniform(0.05, 0.2) * rig.stiffness * context.stroke / (6.0 * context.speed**2)
    return built_in(
        "pendulum-gravity",
        "horizontal-force-and-air-drag" if alternative else "catalogue",
        lambda g: {
            s.PENDULUM: context.stroke / g,
            s.HORIZONTAL_FORCE: 1.0 if alternative else 0.0,
            s.DRAG: g**2 * drag if alternative else 0.0,
            s.DRAG_EXPONENT: 2.0,
        },
        lambda g: {"amplitude": context.stroke / g * rig.output_scale},
        0.2,
        1.2,
    )


def end_stop(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A spring on one side that the motion runs into; or a ball (Hertz), or rubber (Kelvin–Voigt) that never pulls.

    Or a joint with play: the mount's spring does nothing within a gap, and is a stop on either side of it.
    """
    rig, scale = context.rig, context.rig.output_scale
    motion = context.output / scale
    side = generator.choice([-1.0, 1.0])
    # A stop at rest or beyond would push from the start.
    edge = max(float(np.max(side * motion)), 0.05 * context.reach)
    stiffness = rig.stiffness * float(np.exp(generator.uniform(np.log(0.5), np.log(15.0))))
    law = ("catalogue", "hertz", "kelvin-voigt", "play-in-joint")[int(generator.integers(1, 4)) if alternative else 0]
    if law == "play-in-joint":
        return _play_in_joint(context)
    exponent = 1.5 if law == "hertz" else 1.0
    damping = 0.3 * np.sqrt(stiffness * rig.mass) if law == "kelvin-voigt" else 0.0
    return built_in(
        "end-stop",
        law,
        lambda g: {
            s.STOP_SIDE: side,
            s.STOP_POSITION: edge * (1.0 - g),
            s.STOP_STIFFNESS: stiffness / (0.3 * edge) ** (exponent - 1.0),
            s.STOP_EXPONENT: exponent,
            s.STOP_DAMPING: damping,
        },
        lambda g: {
            "position": side * edge * (1.0 - g) * scale,
            "stiffness": stiffness / (0.3 * edge) ** (exponent - 1.0) / (rig.actuator_constant * scale**exponent),
        },
        0.1,
        0.95,
    )


def _play_in_joint(context: Context) -> Effect:
    """The mount's spring with a gap; one below zero, as of a stop that is out of reach, is none."""
    return built_in(
        "end-stop",
        "play-in-joint",
        lambda g: {s.GAP: max(g, 0.0) * context.stroke},
        lambda g: {"half_width": max(g, 0.0) * context.stroke * context.rig.output_scale},
        0.05,
        1.5,
        refinement=5,
    )


def hysteresis(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Bouc–Wen with the exponent one; or two, or elements of springs and sliders."""
    rig = context.rig
    unit = rig.actuator_constant * context.peak
    shape = generator.uniform(0.5, 4.0) / context.stroke
    law = ("catalogue", "bouc-wen-2", "iwan")[int(generator.integers(1, 3)) if alternative else 0]

    def parameters(strength: float) -> Parameters:
        return {"strength": strength * unit / rig.actuator_constant, "shape": shape / rig.output_scale}

    if law == "iwan":
        return built_in(
            "hysteresis",
            law,
            lambda g: {s.JENKINS_STIFFNESS: g * unit * shape, s.JENKINS_FORCE: g * unit * 2.0 / s.JENKINS_ELEMENTS},
            parameters,
            0.1,
            2.0,
        )
    return built_in(
        "hysteresis",
        law,
        lambda g: {
            s.LOOP_FORCE: g * unit,
            s.LOOP_SHAPE: shape,
            s.LOOP_EXPONENT: 2.0 if alternative else 1.0,
            s.TOP_SPEED: TOP_SPEED * context.speed,
        },
        parameters,
        0.1,
        2.0,
    )


def extra_mode(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """The measured point on a spring (paper equation (26)); or the load of a belt whose pulley is driven."""
    rig = context.rig
    ratio = float(np.exp(generator.uniform(np.log(0.01), np.log(0.2))))
    if not alternative:
        return built_in(
            "extra-mode",
            "catalogue",
            lambda g: {s.SECOND_SERIES_FREQUENCY: rig.rate / g, s.SECOND_SERIES_DAMPING: ratio},
            lambda g: {"natural_frequency": rig.rate / g, "damping": ratio},
            0.15,
            0.7,
        )
    mass = generator.uniform(0.05, 0.3) * rig.mass
    return built_in(
        "extra-mode",
        "load-on-a-belt",
        lambda g: {
            s.HIDDEN_IS_SEEN: 1.0,
            s.HIDDEN_MASS: mass,
            s.HIDDEN_STIFFNESS: mass * (rig.rate / g) ** 2,
            s.HIDDEN_DAMPING: 2.0 * ratio * mass * rig.rate / g,
        },
        lambda g: {"natural_frequency": rig.rate / g, "damping": ratio},
        0.15,
        0.7,
    )


def parameter_drift(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Stiffness, damping or actuator constant that change evenly; or as a machine warms up."""
    kind = int(generator.integers(1, 4))
    name = ("stiffness", "damping", "gain")[kind - 1]
    sign = generator.choice([-1.0, 1.0])
    time = generator.uniform(0.2, 0.6) * context.duration if alternative else 0.0
    reach = context.duration if time == 0.0 else time
    return built_in(
        "parameter-drift",
        "warming-up" if alternative else "catalogue",
        lambda g: {s.DRIFT_KIND: float(kind), s.DRIFT_RATE: sign * g / reach, s.DRIFT_TIME: time},
        lambda g: {"coefficient": name, "rate": sign * g / reach},
        0.05,
        0.6 if sign < 0.0 or kind != 2 else 3.0,
    )
