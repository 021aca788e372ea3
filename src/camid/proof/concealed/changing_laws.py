"""Physics outside the tool's catalogue that changes a machine at work: by heat, by its own current, or as time goes by.

No law is a delay, a lag or a curve in its first-order part: what the re-estimated plant does not take up is a product
of two signals, or of a signal and the time, some with a memory.

Sources: Button (1992), J. Audio Eng. Soc. 40(1/2), and Klippel (2004), J. Audio Eng. Soc. 52(1/2) (a coil that its
current heats); Woodson & Melcher (1968), Electromechanical Dynamics I, ch. 3, and Klippel (2006), J. Audio Eng. Soc.
54(10) (force of the reluctance); Lichtenberg & Lieberman (1992), Regular and Chaotic Dynamics, ch. 2 (motion in a
wave); Nayfeh & Mook (1979), Nonlinear Oscillations, ch. 5 (parametric excitation); Pallàs-Areny & Webster (2001),
Sensors and Signal Conditioning, ch. 3 (readings that are shares of a supply).
"""

from __future__ import annotations

import numpy as np

from camid.proof.concealed import vector_layout as s
from camid.proof.concealed.plant_laws import built_in
from camid.proof.concealed.rig_setup import Context, Effect


def heating_winding(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A coil whose resistance rises as it warms up, so that a voltage gives less current: power compression.

    The force is K u / (1 + w) with τ dw/dt = h u² / (1 + w) - w. Its time constant is as long as the input's swings: a
    slow one would be a drift that settles, and one that is faster than the input a curve that bends over.
    """
    unit, time = 1.0 / context.peak**2, generator.uniform(1.5, 5.0) / context.rig.rate
    return built_in(
        "heating-winding",
        "heating-winding",
        lambda g: {s.WINDING_HEATING: g * unit, s.WINDING_TIME: time},
        lambda g: {"heating": g * unit, "time_constant": time},
        0.2,
        4.0,
        place="actuator",
    )


def reluctance_force(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """An iron core that every current, whatever its sign, pulls towards the middle of its coil.

    The inductance L - ½ N x² has its largest value there, and its force ½ i² dL/dx is that of a spring as stiff as the
    square of the command: -r u² x.
    """
    rig = context.rig
    unit = rig.stiffness / context.peak**2
    return built_in(
        "reluctance-force",
        "reluctance-force",
        lambda g: {s.RELUCTANCE: g * unit},
        lambda g: {"coefficient": g * unit / (rig.actuator_constant * rig.output_scale)},
        0.1,
        1.5,
        place="actuator",
        refinement=2,
    )


def travelling_wave(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A wave that runs along the way: a float in a swell, or a slider in the field of a machine that has lost its step.

    The force is A sin(W t - 2π x / l) from the first frame on. It is neither a sine in time, as the motion spans about
    a wave or more, nor one along the way, as it runs on. A strong one would make the motion chaotic.
    """
    force, scale = context.rig.actuator_constant * context.drive, context.rig.output_scale
    length = generator.uniform(0.8, 2.5) * context.stroke
    frequency = generator.choice([-1.0, 1.0]) * generator.uniform(0.2, 0.8) * context.rig.rate
    return built_in(
        "travelling-wave",
        "travelling-wave",
        lambda g: {s.WAVE: g * force, s.WAVE_LENGTH: length, s.WAVE_FREQUENCY: frequency},
        lambda g: {"amplitude": g * context.drive, "length": length * scale, "frequency": frequency},
        0.05,
        0.4,
        refinement=2,
    )


def swinging_stiffness(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A mount whose stiffness swings in time, as of teeth in mesh or of a shaft with a keyway: parametric excitation.

    The restoring force is k (1 + e sin(W t + p)) x. The frequency is below the first three that shake a machine up
    by themselves, which are 2, 1 and 2/3 of its own.
    """
    frequency, phase = generator.uniform(0.15, 0.6) * context.rig.rate, generator.uniform(-np.pi, np.pi)
    return built_in(
        "swinging-stiffness",
        "swinging-stiffness",
        lambda g: {
            s.STIFFNESS_SWING: g,
            s.STIFFNESS_SWING_FREQUENCY: frequency,
            s.STIFFNESS_SWING_PHASE: phase,
        },
        lambda g: {"relative_swing": g, "frequency": frequency, "phase": phase},
        0.05,
        0.7,
    )


def sagging_supply(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A sensor whose reading is a share of a supply that sags under the actuator's current, whichever way that flows.

    The reading is y (1 - e z) with τ dz/dt = |u| - z: what stores charge keeps the voltage up for a while.
    """
    unit, time = 1.0 / context.peak, generator.uniform(0.3, 1.5) / context.rig.rate
    return built_in(
        "sagging-supply",
        "sagging-supply",
        lambda g: {s.SUPPLY_SAG: g * unit, s.SUPPLY_TIME: time},
        lambda g: {"relative_sag": g * unit, "time_constant": time},
        0.05,
        0.4,
        place="sensor",
    )
