"""Physics that the tool's catalogue does not know: a right answer names none of its effects."""

from __future__ import annotations

import numpy as np

from camid.proof.concealed import vector_layout as s
from camid.proof.concealed.input_path import Curve, curve, held, refined
from camid.proof.concealed.machine_integrator import Segments
from camid.proof.concealed.plant_laws import built_in
from camid.proof.concealed.rig_setup import Context, Effect, InputMap, Setup

PULSES = 6  # of the modulated command in a frame


def play_in_joint(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A spring that does nothing within a gap."""
    return built_in(
        "play-in-joint",
        "play-in-joint",
        lambda g: {s.GAP: g * context.stroke},
        lambda g: {"half_width": g * context.stroke * context.rig.output_scale},
        0.05,
        1.5,
        refinement=5,
    )


def nonlinear_hidden_mass(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A second mass on a spring that hardens."""
    rig = context.rig
    frequency = generator.uniform(0.6, 1.6) * rig.rate

    def values(strength: float) -> dict[int, float]:
        mass = strength * rig.mass
        stiffness = 0.5 * mass * frequency**2
        return {
            s.HIDDEN_MASS: mass,
            s.HIDDEN_STIFFNESS: stiffness,
            s.HIDDEN_CUBIC: 0.3 * stiffness / context.stroke**2,
            s.HIDDEN_DAMPING: 0.1 * mass * frequency,
        }

    return built_in(
        "nonlinear-hidden-mass", "nonlinear-hidden-mass", values, lambda g: {"mass_ratio": g}, 0.02, 1.0, refinement=4
    )


def pulse_width_modulation(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A command that is given as pulses of the full voltage, whose number of widths is limited."""

    def apply(setup: Setup, strength: float) -> None:
        step = strength * context.peak

        def rounded(u: np.ndarray) -> np.ndarray:
            return step * np.rint(u / step)

        function: Curve = rounded
        setup.input_maps += [curve(function), _pulse_width(2.5 * context.peak, PULSES)]

    law = "pulse-width-modulation"
    return Effect(law, "actuator", law, apply, lambda g: {"step": g * context.peak}, 0.1, 1.5)


def _pulse_width(full: float, pulses: int) -> InputMap:
    """Each held value as pulses of the full voltage that have the same area."""

    def apply(segments: Segments, period: float) -> Segments:
        fine = refined(segments, period)
        length = np.diff(fine.start, append=2.0 * fine.start[-1] - fine.start[-2]) / pulses
        rise = (fine.start[:, None] + length[:, None] * np.arange(pulses)).ravel()
        level = np.repeat(fine.value, pulses)
        duty = np.clip(np.abs(level) / full, 0.0, 0.999)
        start = np.stack((rise, rise + duty * np.repeat(length, pulses)), axis=1)
        value = np.stack((full * np.sign(level), np.zeros(len(duty))), axis=1)
        kept = np.ones_like(start, dtype=bool)
        kept[:, 0] = duty > 0.0
        return held(start[kept], value[kept])

    return apply


def force_ripple(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A force constant that ripples along the way."""
    pitch, phase = generator.uniform(0.4, 1.5) * context.stroke, generator.uniform(-np.pi, np.pi)
    return built_in(
        "force-ripple",
        "force-ripple",
        lambda g: {s.RIPPLE: g, s.RIPPLE_PITCH: pitch, s.RIPPLE_PHASE: phase},
        lambda g: {"relative_ripple": g, "pitch": pitch * context.rig.output_scale},
        0.1,
        0.9,
        place="actuator",
    )


def back_electromotive_force(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A motor whose force falls with its speed, whichever way it turns."""
    return built_in(
        "saturating-back-electromotive-force",
        "saturating-back-electromotive-force",
        lambda g: {s.SPEED_LIMIT: context.speed / g},
        lambda g: {"speed": context.speed / g * context.rig.output_scale},
        0.1,
        3.0,
        place="actuator",
    )


def viscoelastic_damping(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A rubber mount: three Maxwell elements whose relaxation times span a decade or two (Prony series)."""
    time, ratio = generator.uniform(2.0, 10.0) / context.rig.rate, generator.uniform(0.15, 0.3)
    return built_in(
        "viscoelastic-damping",
        "viscoelastic-damping",
        lambda g: {s.MAXWELL_STIFFNESS: g * context.rig.stiffness, s.MAXWELL_TIME: time, s.MAXWELL_RATIO: ratio},
        lambda g: {"relative_stiffness": g, "slowest_time": time},
        0.1,
        4.0,
    )
