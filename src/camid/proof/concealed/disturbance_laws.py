"""Forces from outside, as commands that would do the same."""

from __future__ import annotations

import numpy as np

from camid.proof.concealed import vector_layout as s
from camid.proof.concealed.plant_laws import built_in
from camid.proof.concealed.rig_setup import Context, Effect, Setup


def periodic_disturbance(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A sine from the first frame on; or with a weak second harmonic."""
    # Between a few cycles in the recording and what the machine still follows.
    low, high = 2.0 * np.pi * 5.0 / context.duration, min(3.0 * context.rig.rate, 0.7 * np.pi / context.period)
    frequency = float(np.exp(generator.uniform(np.log(low), np.log(max(high, 2.0 * low)))))
    phase, other = generator.uniform(-np.pi, np.pi, 2)
    harmonic = generator.uniform(0.15, 0.35) if alternative else 0.0
    unit = context.drive
    return built_in(
        "periodic-disturbance",
        "with-harmonic" if alternative else "catalogue",
        lambda g: {
            s.SINE: g * unit,
            s.SINE_FREQUENCY: frequency,
            s.SINE_PHASE: phase,
            s.HARMONIC: harmonic * g * unit,
            s.HARMONIC_PHASE: other,
        },
        lambda g: {"amplitude": g * unit, "frequency": frequency, "phase": float(phase)},
        0.03,
        place="disturbance",
    )


def step_disturbance(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A load that is put on and stays."""
    # At the start of a frame, as the integrator ends its steps there.
    time = context.period * round(context.frames * generator.uniform(0.15, 0.85))
    unit = generator.choice([-1.0, 1.0]) * context.drive
    return built_in(
        "step-disturbance",
        "catalogue",
        lambda g: {s.STEP: g * unit, s.STEP_TIME: time},
        lambda g: {"size": g * unit, "time": time},
        0.03,
        place="disturbance",
        repeatable=False,
    )


def impulse_disturbance(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A blow that changes the momentum at once; or within a part of a frame."""
    rig = context.rig
    time = context.period * float(context.frames * generator.uniform(0.15, 0.85))
    unit = generator.choice([-1.0, 1.0]) * context.drive / rig.rate
    duration = generator.uniform(0.1, 0.5) * context.period

    def apply(setup: Setup, strength: float) -> None:
        if alternative:
            # A half-sine of amplitude P and duration D has the area 2PD/π; steps of the integrator end within it.
            pulse = strength * unit * np.pi / (2.0 * duration)
            setup.parameters[[s.PULSE, s.PULSE_TIME, s.PULSE_DURATION]] = pulse, time, duration
            setup.kicks += [(time + share * duration, 0.0) for share in np.linspace(0.0, 1.0, 13)]
        else:
            momentum = rig.actuator_constant * strength * unit
            setup.kicks.append((time, momentum / (rig.mass or rig.damping)))

    return Effect(
        "impulse-disturbance",
        "disturbance",
        "half-sine" if alternative else "catalogue",
        apply,
        lambda g: {"size": g * unit, "time": time},
        0.1,
        1e3,
        repeatable=False,
    )
