"""What an actuator does that a simulation leaves out."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from camid.proof.concealed import vector_layout as s
from camid.proof.concealed.input_path import Curve, curve, play, pulses_of_width, slew
from camid.proof.concealed.plant_laws import Parameters, built_in
from camid.proof.concealed.rig_setup import Context, Effect, Setup

PULSES = 6  # of a modulated command in a frame
FULL_VOLTAGE = 2.5  # of the pulses, over the largest command


def _static(
    identity: str,
    law: str,
    curves: Callable[[float], Curve],
    parameters: Callable[[float], Parameters],
    start: float,
    high: float,
) -> Effect:
    """Effect of a static curve that depends on the strength."""

    def apply(setup: Setup, strength: float) -> None:
        setup.input_maps.append(curve(curves(strength)))

    return Effect(identity, "actuator", law, apply, parameters, start, high)


def dead_zone(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """No force for small commands; or a smooth transition."""
    peak = context.peak

    def hard(strength: float) -> Curve:
        return lambda u: np.sign(u) * np.maximum(np.abs(u) - strength * peak, 0.0)

    def smooth(strength: float) -> Curve:
        return lambda u: u - strength * peak * np.tanh(u / (strength * peak))

    return _static(
        "dead-zone",
        "smooth" if alternative else "catalogue",
        smooth if alternative else hard,
        lambda g: {"half_width": g * peak},
        0.05,
        0.8,
    )


def saturation(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A force that stops growing; or bends over."""
    peak = context.peak

    def hard(strength: float) -> Curve:
        limit = (1.0 - strength) * peak
        return lambda u: np.clip(u, -limit, limit)

    def smooth(strength: float) -> Curve:
        limit = peak / strength
        return lambda u: limit * np.tanh(u / limit)

    return _static(
        "saturation",
        "tanh" if alternative else "catalogue",
        smooth if alternative else hard,
        (lambda g: {"limit": peak / g}) if alternative else (lambda g: {"limit": (1.0 - g) * peak}),
        0.2,
        20.0 if alternative else 0.95,
    )


def backlash(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Play of a gear; or with a gap that transmits a little."""
    share = generator.uniform(0.08, 0.2) if alternative else 0.0

    def apply(setup: Setup, strength: float) -> None:
        setup.input_maps.append(play(strength * context.peak, share))

    return Effect(
        "backlash",
        "actuator",
        "soft-gap" if alternative else "catalogue",
        apply,
        lambda g: {"half_width": g * context.peak},
        0.05,
        0.8,
    )


def rate_limit(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A slew that is limited; or slows down as it arrives.

    It slows down within a share of the largest change, however fast it is: within a fixed time a slew without limit
    would still be a lag, and a size that the lag alone exceeds would make the limit so high that nothing reaches it.
    """
    unit = 2.0 * context.peak / context.period
    soft = generator.uniform(0.05, 0.3) * context.period

    def apply(setup: Setup, strength: float) -> None:
        if alternative:
            setup.parameters[[s.SOFT_SLEW, s.SOFT_SLEW_TIME]] = unit / strength, strength * soft
        else:
            setup.input_maps.append(slew(unit / strength))

    return Effect(
        "rate-limit",
        "actuator",
        "soft" if alternative else "catalogue",
        apply,
        lambda g: {"rate": unit / g},
        1.0,
        300.0,
    )


def actuator_lag(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A lag of first order; or of second order without overshoot."""
    unit = 1.0 / context.rig.rate
    return built_in(
        "actuator-lag",
        "second-order" if alternative else "catalogue",
        lambda g: {s.LAG: g * unit, s.SECOND_LAG: 0.4 * g * unit if alternative else 0.0},
        lambda g: {"time_constant": (1.4 if alternative else 1.0) * g * unit},
        0.1,
        10.0,
        place="actuator",
    )


def gain_asymmetry(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """An actuator that pulls less, or more, than it pushes."""
    sign = generator.choice([-1.0, 1.0])

    def maps(strength: float) -> Curve:
        return lambda u: np.where(u < 0.0, (1.0 + sign * strength) * u, u)

    return _static("gain-asymmetry", "catalogue", maps, lambda g: {"ratio": 1.0 + sign * g}, 0.05, 0.8)


def input_bias(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A command that is off by a constant from the first frame on, when the drive is enabled."""
    sign = generator.choice([-1.0, 1.0])
    unit = sign * context.peak

    def maps(strength: float) -> Curve:
        return lambda u: u + strength * unit

    return _static("input-bias", "catalogue", maps, lambda g: {"bias": g * unit}, 0.05, 3.0)


def input_hold(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A command that runs straight to the next sample; or through a filter that leaves no steps."""
    hold = "band-limited" if alternative else "foh"

    def apply(setup: Setup, strength: float) -> None:
        setup.hold = hold

    parameters: Parameters = {"hold": hold}
    return Effect(
        "input-hold", "actuator", hold if alternative else "catalogue", apply, lambda g: parameters, fixed=True
    )


def input_quantisation(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A command rounded to few levels; or given as pulses of the full voltage that have few widths."""
    peak = context.peak

    def rounded(strength: float) -> Curve:
        return lambda u: strength * peak * np.rint(u / (strength * peak))

    def apply(setup: Setup, strength: float) -> None:
        setup.input_maps.append(curve(rounded(strength)))
        if alternative:
            setup.input_maps.append(pulses_of_width(FULL_VOLTAGE * peak, PULSES))

    law = "pulse-width-modulation" if alternative else "catalogue"
    return Effect("input-quantisation", "actuator", law, apply, lambda g: {"step": g * peak}, 0.1, 1.5)
