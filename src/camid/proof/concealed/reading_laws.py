"""What happens to the frame values on their way into the recording, and the colour of their noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.proof.concealed.rig_setup import Context, Effect, FrameMap, NoiseColour, Setup

Array = NDArray[np.float64]


def clipping(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A field of view that ends on both sides; or on one."""
    top, bottom = float(np.max(context.output)), float(np.min(context.output))
    middle = float(np.median(context.output))
    upper = generator.random() < 0.5

    def limits(strength: float) -> tuple[float, float]:
        low, high = middle + (1.0 - strength) * (bottom - middle), middle + (1.0 - strength) * (top - middle)
        if alternative:
            return (-np.inf, high) if upper else (low, np.inf)
        return low, high

    def apply(setup: Setup, strength: float) -> None:
        low, high = limits(strength)
        setup.after_noise.append(lambda w, t, random: np.clip(w, low, high))

    def parameters(strength: float) -> dict[str, float | str | None]:
        return dict(zip(("low", "high"), (v if np.isfinite(v) else None for v in limits(strength)), strict=True))

    law = "one-sided" if alternative else "catalogue"
    return Effect("clipping", "sensor", law, apply, parameters, 0.2, 0.9)


def quantisation(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A coarse lattice of readings."""
    unit = float(np.std(context.output))

    def apply(setup: Setup, strength: float) -> None:
        step = strength * unit
        setup.after_noise.append(lambda w, t, random: step * np.rint(w / step))

    return Effect(
        "quantisation",
        "sensor",
        "catalogue",
        apply,
        lambda g: {"step": g * unit},
        0.05,
        0.7,
        repeatable=False,
        noise_like=True,
    )


def sensor_offset(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Readings that do not start at zero."""
    unit = generator.choice([-1.0, 1.0]) * float(np.std(context.output))

    def apply(setup: Setup, strength: float) -> None:
        setup.before_noise.append(lambda w, t, random: w + strength * unit)

    return Effect("sensor-offset", "sensor", "catalogue", apply, lambda g: {"offset": g * unit}, 0.05, 10.0)


def sensor_drift(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Readings that wander off evenly."""
    unit = generator.choice([-1.0, 1.0]) * float(np.std(context.output)) / context.duration

    def apply(setup: Setup, strength: float) -> None:
        setup.before_noise.append(lambda w, t, random: w + strength * unit * t)

    return Effect("sensor-drift", "sensor", "catalogue", apply, lambda g: {"rate": g * unit}, 0.1, 10.0)


def sensor_oscillation(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A hum of the reading: the mains in its cable, or a camera that sways; or with a weak second harmonic."""
    unit = float(np.std(context.output))
    low, high = 2.0 * np.pi * 5.0 / context.duration, 0.45 * np.pi / context.period
    frequency = float(np.exp(generator.uniform(np.log(low), np.log(high))))
    phase, other = generator.uniform(-np.pi, np.pi, 2)
    harmonic = generator.uniform(0.15, 0.35) if alternative else 0.0

    def apply(setup: Setup, strength: float) -> None:
        def add(w: Array, t: Array, random: np.random.Generator | None) -> Array:
            hum = np.sin(frequency * t + phase) + harmonic * np.sin(2.0 * frequency * t + other)
            return w + strength * unit * hum

        setup.before_noise.append(add)

    return Effect(
        "sensor-oscillation",
        "sensor",
        "with-harmonic" if alternative else "catalogue",
        apply,
        lambda g: {"amplitude": g * unit, "frequency": frequency, "phase": float(phase)},
        0.03,
        3.0,
    )


def input_pickup(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A wire of the drive beside that of the sensor, which carries a share of the command to the reading."""
    unit = generator.choice([-1.0, 1.0]) * float(np.std(context.output)) / context.peak

    def apply(setup: Setup, strength: float) -> None:
        setup.pickup = strength * unit

    return Effect("input-pickup", "sensor", "catalogue", apply, lambda g: {"coefficient": g * unit}, 0.03, 1.0)


def absolute_value(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """A reading that has lost its sign; or a position that is seen mirrored at every instant."""

    def apply(setup: Setup, strength: float) -> None:
        if alternative:
            setup.position_map = lambda y: (np.abs(y), np.sign(y))
            setup.refinement *= 8
        else:
            setup.before_noise.append(lambda w, t, random: np.abs(w))

    law = "instantaneous" if alternative else "catalogue"
    return Effect("absolute-value", "sensor", law, apply, lambda g: {}, fixed=True)


def dropped_frames(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Frames that repeat the one before; or a frame that was cut short, twice."""

    def apply(setup: Setup, strength: float) -> None:
        if alternative:
            setup.partial_repeats = strength
            return

        def repeat(w: Array, t: Array, random: np.random.Generator | None) -> Array:
            if random is None:
                return w
            index = np.arange(len(w))
            lost = random.random(len(w)) < strength
            lost[0] = False
            return w[np.maximum.accumulate(np.where(lost, 0, index))]

        setup.after_noise.append(repeat)

    return Effect(
        "dropped-frames",
        "sensor",
        "partial-exposure" if alternative else "catalogue",
        apply,
        lambda g: {"fraction": g},
        0.01,
        0.15,
        repeatable=False,
        noise_like=True,
    )


def outliers(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Isolated detections of something else; or noise with heavy tails."""
    size = generator.uniform(0.3, 1.5) * float(np.std(context.output))

    def scatter(strength: float) -> FrameMap:
        def add(w: Array, t: Array, random: np.random.Generator | None) -> Array:
            if random is None:
                return w
            if alternative:
                return w + strength * size * random.standard_t(2.0, len(w))
            hit = random.random(len(w)) < strength
            return w + np.where(hit, random.normal(0.0, size, len(w)), 0.0)

        return add

    def apply(setup: Setup, strength: float) -> None:
        setup.after_noise.append(scatter(strength))

    return Effect(
        "outliers",
        "sensor",
        "heavy-tails" if alternative else "catalogue",
        apply,
        (lambda g: {"scale": g * size}) if alternative else (lambda g: {"fraction": g}),
        0.01,
        0.5 if alternative else 0.15,
        repeatable=False,
        noise_like=True,
    )


def multiplicative_noise(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Noise that grows with the reading."""

    def apply(setup: Setup, strength: float) -> None:
        def add(w: Array, t: Array, random: np.random.Generator | None) -> Array:
            return w if random is None else w * (1.0 + strength * random.standard_normal(len(w)))

        setup.before_noise.append(add)

    return Effect(
        "multiplicative-noise",
        "noise",
        "catalogue",
        apply,
        lambda g: {"share": g},
        0.03,
        0.5,
        repeatable=False,
        noise_like=True,
    )


def _autoregressive(coefficients: list[float]) -> NoiseColour:
    """Noise of unit variance with w_k + a_1 w_(k-1) + … = e_k."""

    def draw(random: np.random.Generator, length: int) -> Array:
        from scipy.signal import lfilter

        settled = 2000
        noise = lfilter([1.0], coefficients, random.standard_normal(length + settled))[settled:]
        impulse = lfilter([1.0], coefficients, np.eye(1, 8 * settled)[0])
        return noise / np.sqrt(np.sum(impulse**2))

    return draw


def coloured_noise(generator: np.random.Generator, context: Context, alternative: bool) -> Effect:
    """Noise of a first-order filter; or a camera that vibrates, or a spectrum that falls like 1/f."""
    law = ("catalogue", "vibration", "one-over-f")[int(generator.integers(1, 3)) if alternative else 0]
    parameters: dict[str, float | str | None]
    if law == "catalogue":
        pole = generator.uniform(0.5, 0.95)
        colour = _autoregressive([1.0, -pole])
        parameters = {"spectrum": "autoregressive", "pole": pole}
    elif law == "vibration":
        radius, angle = generator.uniform(0.8, 0.97), generator.uniform(0.1, 0.8) * np.pi
        colour = _autoregressive([1.0, -2.0 * radius * np.cos(angle), radius**2])
        parameters = {"spectrum": "resonance", "radius": radius, "angle": angle}
    else:
        parts = [_autoregressive([1.0, -float(np.exp(-(0.5**i)))]) for i in range(7)]

        def colour(random: np.random.Generator, length: int) -> Array:
            return np.sum([part(random, length) for part in parts], axis=0) / np.sqrt(len(parts))

        parameters = {"spectrum": "one-over-f"}

    def apply(setup: Setup, strength: float) -> None:
        setup.colour = colour

    return Effect(
        "coloured-noise", "noise", law, apply, lambda g: parameters, repeatable=False, noise_like=True, fixed=True
    )
