"""Physics that the tool's catalogue does not know: a right answer names none of its effects."""

from __future__ import annotations

import numpy as np

from camid.proof.concealed import vector_layout as s
from camid.proof.concealed.plant_laws import built_in
from camid.proof.concealed.rig_setup import Context, Effect


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
