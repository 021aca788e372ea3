"""Laws along the way: uneven friction and gain, cogging, damping by the amplitude, a mode beside, full storages.

The strengths are ratios to forces and positions of the same machine without the effect. Sources: Canudas de Wit et al.
(1995), IEEE Transactions on Automatic Control 40(3) (friction); Hanselman (2006), Brushless Permanent Magnet Motor
Design, ch. 7 (cogging); Ewins (2000), Modal Testing, ch. 2; Blasius (1913), Forschungsarbeiten 131 (pipe flow).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.compiled import njit
from camid.proof.concealed import vector_layout as s
from camid.proof.concealed.plant_laws import Parameters, built_in
from camid.proof.concealed.rig_setup import Context, Effect, Setup

Array = NDArray[np.float64]

LARGEST_FRICTION = 0.6  # of the largest force


def asymmetric_friction(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Stick-slip on a level for each direction."""
    uneven = generator.choice([-1.0, 1.0]) * generator.uniform(0.3, 0.9)
    largest = context.rig.actuator_constant * context.peak
    return built_in(
        "asymmetric-friction",
        "catalogue",
        lambda g: {s.DRY_COULOMB: g * largest, s.DRY_BREAKAWAY: g * largest, s.DRY_DIRECTION: uneven},
        lambda g: {"forward": g * (1.0 + uneven) * context.peak, "backward": g * (1.0 - uneven) * context.peak},
        0.05,
        LARGEST_FRICTION,
    )


def position_dependent_friction(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Stick-slip on a level that rises along the way; or from one level to another where the guide is worn."""
    slope = generator.choice([-1.0, 1.0]) * generator.uniform(0.5, 1.0) / context.reach
    largest = context.rig.actuator_constant * context.peak
    width = 0.5 * context.reach if alternative else 0.0
    return built_in(
        "position-dependent-friction",
        "worn-guide" if alternative else "catalogue",
        lambda g: {
            s.DRY_COULOMB: g * largest,
            s.DRY_BREAKAWAY: g * largest,
            s.DRY_SLOPE: slope,
            s.DRY_WIDTH: width,
        },
        lambda g: {"force": g * context.peak, "gradient": g * context.peak * slope / context.rig.output_scale},
        0.05,
        LARGEST_FRICTION,
    )


def position_dependent_gain(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A magnet whose pull depends on the gap."""
    unit = generator.choice([-1.0, 1.0]) / context.reach
    return built_in(
        "position-dependent-gain",
        "catalogue",
        lambda g: {s.POSITION_GAIN: g * unit},
        lambda g: {"slope": g * unit / context.rig.output_scale},
        0.05,
        0.45,
        place="actuator",
    )


def load_dependent_friction(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Stick-slip on a level that rises with the driving force."""
    share = generator.uniform(0.1, 0.4)
    largest = context.rig.actuator_constant * context.peak
    return built_in(
        "load-dependent-friction",
        "catalogue",
        lambda g: {
            s.DRY_COULOMB: share * g * largest,
            s.DRY_BREAKAWAY: share * g * largest,
            s.DRY_LOAD: g,
        },
        lambda g: {"force": share * g * context.peak, "coefficient": g},
        0.05,
        LARGEST_FRICTION,
    )


def amplitude_dependent_damping(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Damping with the square of the distance from rest; or in proportion to the distance."""
    rig, power = context.rig, 1 if alternative else 2
    unit = rig.damping / context.stroke**power
    slot = s.DISTANCE_DAMPING if alternative else s.POSITION_DAMPING
    return built_in(
        "amplitude-dependent-damping",
        "distance" if alternative else "catalogue",
        lambda g: {slot: g * unit},
        lambda g: {"coefficient": g * unit / (rig.actuator_constant * rig.output_scale ** (power + 1))},
        0.1,
        50.0,
    )


def cogging(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A detent force that is a sine along the way; or one with a second harmonic."""
    force, scale = context.rig.actuator_constant * context.drive, context.rig.output_scale
    pitch, phase = generator.uniform(0.4, 1.5) * context.stroke, generator.uniform(-np.pi, np.pi)
    harmonic = generator.uniform(0.1, 0.3) if alternative else 0.0
    harmonic_phase = generator.uniform(-np.pi, np.pi)
    return built_in(
        "cogging",
        "with-harmonic" if alternative else "catalogue",
        lambda g: {
            s.DETENT: g * force,
            s.DETENT_PITCH: pitch,
            s.DETENT_PHASE: phase,
            s.DETENT_HARMONIC: harmonic,
            s.DETENT_HARMONIC_PHASE: harmonic_phase,
        },
        lambda g: {"amplitude": g * context.drive, "period": pitch * scale, "phase": phase},
        0.1,
        3.0,
    )


def parallel_mode(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A mode that swings beside the machine's; or a second mass that the first one carries on a spring."""
    rig = context.rig
    ratio = float(np.exp(generator.uniform(np.log(0.01), np.log(0.2))))
    frequency = generator.uniform(1.3, 4.0) * rig.rate
    sign = generator.choice([-1.0, 1.0])

    def parameters(strength: float) -> Parameters:
        gain = None if alternative else sign * strength * rig.actuator_constant / rig.stiffness * rig.output_scale
        return {"gain": gain, "natural_frequency": frequency, "damping": ratio}

    if alternative:
        return built_in(
            "parallel-mode",
            "hidden-mass",
            lambda g: {
                s.HIDDEN_MASS: g * rig.mass,
                s.HIDDEN_STIFFNESS: g * rig.mass * frequency**2,
                s.HIDDEN_DAMPING: 2.0 * ratio * g * rig.mass * frequency,
            },
            parameters,
            0.02,
            1.0,
        )
    return built_in(
        "parallel-mode",
        "catalogue",
        lambda g: {
            s.BESIDE_COMPLIANCE: sign * g / rig.stiffness,
            s.BESIDE_FREQUENCY: frequency,
            s.BESIDE_DAMPING: ratio,
        },
        parameters,
        0.05,
        1.0,
    )


def square_root_outflow(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A storage that empties with the square root of its level, too; or with its power of 4/7 (a smooth pipe)."""
    rig = context.rig
    exponent = 4.0 / 7.0 if alternative else 0.5
    unit = rig.stiffness * context.stroke ** (1.0 - exponent)
    return built_in(
        "square-root-outflow",
        "smooth-pipe" if alternative else "catalogue",
        lambda g: {s.OUTFLOW: g * unit, s.OUTFLOW_EXPONENT: exponent},
        lambda g: {"coefficient": g * unit / (rig.actuator_constant * rig.output_scale**exponent), "below": "none"},
        0.1,
        5.0,
        refinement=4,
    )


def overflow(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A storage whose level ends at its edge; or over whose edge the excess flows as over a weir."""
    rig, scale = context.rig, context.rig.output_scale
    side = generator.choice([-1.0, 1.0])
    edge = max(float(np.max(side * context.output)) / scale, 0.05 * context.reach)

    def values(strength: float) -> dict[int, float]:
        height = (1.0 - strength) * edge
        weir = 3.0 * rig.stiffness * edge / (0.1 * edge) ** 1.5 if alternative else 0.0
        return {s.EDGE_SIDE: side, s.EDGE_HEIGHT: height, s.EDGE_WEIR: weir}

    return built_in(
        "overflow",
        "weir" if alternative else "catalogue",
        values,
        lambda g: {"height": side * (1.0 - g) * edge * scale, "share": None, "below": "none"},
        0.1,
        0.9,
        refinement=4,
    )


@njit
def _behind_play(position: Array, half_width: float) -> tuple[Array, Array]:
    """A load that is pushed from either side of a gap, and whether it moves with the machine."""
    load, moves = np.empty_like(position), np.zeros_like(position)
    load[0] = position[0]
    for k in range(1, len(position)):
        lag = position[k] - load[k - 1]
        load[k] = load[k - 1]
        if lag > half_width:
            load[k], moves[k] = position[k] - half_width, 1.0
        elif lag < -half_width:
            load[k], moves[k] = position[k] + half_width, 1.0
    return load, moves


def output_backlash(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A load behind a joint with play, which friction holds while the joint crosses the gap."""
    edge = float(np.max(np.abs(context.output)))

    def apply(setup: Setup, strength: float) -> None:
        setup.load_map = lambda position: _behind_play(position, strength * edge)
        setup.refinement *= 4

    return Effect("output-backlash", "plant", "catalogue", apply, lambda g: {"half_width": g * edge}, 0.02, 0.3)
