"""What a camera does that a simulation leaves out: geometry and time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.proof.concealed.rig_setup import Context, Effect, Setup

Array = NDArray[np.float64]


def exposure(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Another exposure than the declared one, ending at the same time."""
    longer = context.period - context.exposure
    room = longer if longer > 0.4 * context.period else -context.exposure

    def actual(strength: float) -> float:
        return context.exposure + strength * room

    def apply(setup: Setup, strength: float) -> None:
        setup.exposure = actual(strength)

    return Effect(
        "exposure", "sensor", "catalogue", apply, lambda g: {"exposure": actual(g)}, 0.3, 1.0 if room > 0.0 else 0.97
    )


def delay(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A delay of the command; or of the camera: recordings of a machine at rest cannot tell them apart."""

    def apply(setup: Setup, strength: float) -> None:
        if alternative:
            setup.latency += strength * context.period
        else:
            setup.transport_delay += strength * context.period

    return Effect(
        "delay",
        "sensor",
        "sensor-latency" if alternative else "catalogue",
        apply,
        lambda g: {"delay": g * context.period},
        0.2,
        4.0,
    )


def rolling_shutter(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Rows read one after the other: the window's time depends on where the marker is."""
    fastest = float(np.max(np.abs(np.diff(context.output)))) / context.period
    unit = generator.choice([-1.0, 1.0]) / fastest
    # Rows are read faster than the marker moves, even at twice the amplitude, and the windows stay near their frames.
    largest = min(0.25, 3.0 * context.period * fastest / float(np.max(np.abs(context.output))))

    def apply(setup: Setup, strength: float) -> None:
        setup.rolling = strength * unit

    return Effect("rolling-shutter", "sensor", "catalogue", apply, lambda g: {"time_per_unit": g * unit}, 0.05, largest)


def clock_skew(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A camera whose clock is fast or slow beside the one that commands the machine."""
    unit = generator.choice([-1.0, 1.0]) / context.frames

    def apply(setup: Setup, strength: float) -> None:
        setup.skew = strength * unit

    return Effect("clock-skew", "sensor", "catalogue", apply, lambda g: {"skew": g * unit}, 0.3, 6.0)


def timestamp_jitter(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Frames that are taken a little early or late."""

    def apply(setup: Setup, strength: float) -> None:
        setup.jitter = strength * context.period

    return Effect(
        "timestamp-jitter",
        "sensor",
        "catalogue",
        apply,
        lambda g: {"std": g * context.period},
        0.03,
        0.5,
        repeatable=False,
        noise_like=True,
    )


def lens_distortion(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Radial distortion of the position at every instant, with one coefficient; or with two."""
    edge = float(np.max(np.abs(context.output)))
    sign = generator.choice([-1.0, 1.0])
    second = generator.uniform(0.3, 0.8) if alternative else 0.0

    def apply(setup: Setup, strength: float) -> None:
        first, fourth = sign * strength / edge**2, second * strength / edge**4

        def distort(y: Array) -> tuple[Array, Array]:
            square = y * y
            return y * (1.0 + square * (first + square * fourth)), 1.0 + square * (3.0 * first + 5.0 * fourth * square)

        setup.position_map = distort

    return Effect(
        "lens-distortion",
        "sensor",
        "two-coefficients" if alternative else "catalogue",
        apply,
        lambda g: {"k1": sign * g / edge**2},
        0.02,
        # A barrel must not fold the image of twice the amplitude.
        0.06 if sign < 0.0 else 0.6,
    )


def perspective(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A motion that is not parallel to the image plane: y / (1 + a y)."""
    edge = float(np.max(np.abs(context.output)))
    sign = generator.choice([-1.0, 1.0])

    def apply(setup: Setup, strength: float) -> None:
        tilt = sign * strength / edge
        setup.position_map = lambda y: (y / (1.0 + tilt * y), 1.0 / (1.0 + tilt * y) ** 2)

    return Effect("perspective", "sensor", "catalogue", apply, lambda g: {"obliqueness": sign * g / edge}, 0.02, 0.25)


def encoder_eccentricity(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A reading that errs once a turn; or also twice."""
    period = generator.uniform(0.6, 2.5) * float(np.std(context.output))
    phase, second = generator.uniform(-np.pi, np.pi), generator.uniform(0.1, 0.25) if alternative else 0.0
    unit = period / (2.0 * np.pi)

    def apply(setup: Setup, strength: float) -> None:
        def read(y: Array) -> tuple[Array, Array]:
            angle = y / unit
            error = np.sin(angle + phase) - np.sin(phase) + second * np.sin(2.0 * angle)
            slope = np.cos(angle + phase) + 2.0 * second * np.cos(2.0 * angle)
            return y + strength * unit * error, 1.0 + strength * slope

        setup.position_map = read
        setup.refinement *= 3

    return Effect(
        "encoder-eccentricity",
        "sensor",
        "two-harmonics" if alternative else "catalogue",
        apply,
        lambda g: {"amplitude": g * unit, "period": period, "phase": phase},
        0.05,
        0.8,
    )


def late_command(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A log that writes each command some rows late, so that the reading is ahead of it."""
    lead = int(generator.integers(1, 4)) * context.period

    def apply(setup: Setup, strength: float) -> None:
        setup.latency -= lead

    return Effect("late-command", "sensor", "catalogue", apply, lambda g: {"lead": lead}, fixed=True)


def speed_weighted_centroid(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Positions weighted with the speed (paper equation (2)); or with a gradient that saturates at high speed."""
    typical = context.speed * context.rig.output_scale

    def weight(speed: Array) -> Array:
        return speed / np.sqrt(1.0 + (speed / typical) ** 2) if alternative else speed

    def apply(setup: Setup, strength: float) -> None:
        setup.speed_weight = weight
        setup.refinement *= 4

    return Effect(
        "speed-weighted-centroid",
        "sensor",
        "saturating-gradient" if alternative else "catalogue",
        apply,
        lambda g: {},
        fixed=True,
    )
