"""What a camera makes of a position, as the catalogue's formulas state it."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from .rigs import Array
from .setup import Draft, Drafter, Scales, Setup

Generator = np.random.Generator
Parameters = dict[str, Any]
Shown = Callable[[Array], Array]


def with_image(make: Callable[[Parameters], Shown]) -> Callable[[Setup, Parameters], None]:
    """Return an installer of the map from positions to what the image shows (y)."""

    def install(setup: Setup, p: Parameters) -> None:
        setup.image = make(p)

    return install


def with_readings(make: Callable[[Parameters], Callable[[Array, Array], Array]]) -> Callable[[Setup, Parameters], None]:
    """Return an installer of what becomes of the readings (y) at their times (s)."""

    def install(setup: Setup, p: Parameters) -> None:
        setup.readings = make(p)

    return install


def _sign(rng: Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def lens(scales: Scales, rng: Generator) -> Draft:
    """Radial distortion."""
    unit = _sign(rng) / scales.reach**2
    return Draft("lens-distortion", "sensor", "catalogue", lambda size: {"k1": size * unit},
                 with_image(lambda p: lambda y: y * (1.0 + p["k1"] * y**2)), 0.15, 0.02)  # fmt: skip


def oblique(scales: Scales, rng: Generator) -> Draft:
    """An oblique view."""
    unit = _sign(rng) / scales.reach
    return Draft("perspective", "sensor", "catalogue", lambda size: {"obliqueness": size * unit},
                 with_image(lambda p: lambda y: y / (1.0 + p["obliqueness"] * y)), 0.15, 0.02)  # fmt: skip


def eccentric(scales: Scales, rng: Generator) -> Draft:
    """An error that repeats along the way."""
    period, phase = 2.0 * scales.way / float(rng.uniform(2.5, 8.0)), float(rng.uniform(-math.pi, math.pi))

    def make(p: Parameters) -> Shown:
        e, k, f = p["amplitude"], 2.0 * math.pi / p["period"], p["phase"]
        return lambda y: y + e * (np.sin(k * y + f) - math.sin(f))

    return Draft("encoder-eccentricity", "sensor", "catalogue",
                 lambda size: {"amplitude": size * scales.way, "period": period, "phase": phase},
                 with_image(make), 0.05, 0.01)  # fmt: skip


def lattice(scales: Scales, rng: Generator) -> Draft:
    """Values on a lattice that is coarser than the noise."""
    return Draft("quantisation", "sensor", "catalogue", lambda size: {"step": size * scales.way},
                 with_readings(lambda p: lambda w, t: p["step"] * np.round(w / p["step"])), 0.15, 0.02)  # fmt: skip


def skew(scales: Scales, rng: Generator) -> Draft:
    """A clock of another rate."""
    sign = _sign(rng)

    def install(setup: Setup, p: Parameters) -> None:
        setup.moments = lambda t: (1.0 + p["skew"]) * t

    return Draft("clock-skew", "sensor", "catalogue", lambda size: {"skew": sign * size}, install, 0.012, 0.003)


def jitter(scales: Scales, rng: Generator) -> Draft:
    """Frames that are a little early or late."""
    seed = int(rng.integers(2**31))

    def install(setup: Setup, p: Parameters) -> None:
        setup.moments = lambda t: t + np.random.default_rng(seed).normal(0.0, p["std"], t.size)

    return Draft("timestamp-jitter", "sensor", "catalogue", lambda size: {"std": size * scales.period},
                 install, 0.3, 0.1)  # fmt: skip


def outliers(scales: Scales, rng: Generator) -> Draft:
    """Frames in which something else was found, somewhere about the view."""
    seed, spread = int(rng.integers(2**31)), float(rng.uniform(15.0, 80.0)) * scales.noise

    def make(p: Parameters) -> Callable[[Array, Array], Array]:
        def struck(w: Array, t: Array) -> Array:
            draw = np.random.default_rng(seed)
            hit = draw.random(w.size) < p["fraction"]
            return np.asarray(w + np.where(hit, draw.normal(0.0, spread, w.size), 0.0))

        return struck

    return Draft("outliers", "sensor", "catalogue", lambda size: {"fraction": size}, with_readings(make), 0.06, 0.01)


def repeated(scales: Scales, rng: Generator) -> Draft:
    """Frames that never came."""
    seed = int(rng.integers(2**31))

    def make(p: Parameters) -> Callable[[Array, Array], Array]:
        def again(w: Array, t: Array) -> Array:
            lost = np.random.default_rng(seed).random(w.size) < p["fraction"]
            lost[0] = False
            rows = np.maximum.accumulate(np.where(lost, 0, np.arange(w.size)))
            return np.asarray(w[rows])

        return again

    return Draft(
        "dropped-frames", "sensor", "catalogue", lambda size: {"fraction": size}, with_readings(make), 0.3, 0.05
    )


def exposure(scales: Scales, rng: Generator) -> Draft:
    """An exposure that is not the declared one, which is in the camera that the user knows."""

    def install(setup: Setup, p: Parameters) -> None:
        setup.camera = replace(setup.camera, exposure=p["exposure"])

    return Draft("exposure", "sensor", "catalogue", lambda size: {"exposure": size * scales.period}, install, 1.0, 0.5)


def delay(scales: Scales, rng: Generator) -> Draft:
    """A delay beyond the declared latency."""

    def install(setup: Setup, p: Parameters) -> None:
        setup.moments = lambda t: t - p["delay"]

    return Draft("delay", "sensor", "catalogue", lambda size: {"delay": size * scales.period}, install, 5.0, 0.5)


def shutter(scales: Scales, rng: Generator) -> Draft:
    """Rows of the image that are read one after the other."""
    unit = _sign(rng) * scales.period / scales.way

    def install(setup: Setup, p: Parameters) -> None:
        setup.shutter = p["time_per_unit"]

    return Draft(
        "rolling-shutter", "sensor", "catalogue", lambda size: {"time_per_unit": size * unit}, install, 1.5, 0.3
    )


def clipped(scales: Scales, rng: Generator) -> Draft:
    """A view that ends before the way does."""
    return Draft("clipping", "sensor", "catalogue",
                 lambda size: {"low": scales.low + size * scales.way, "high": scales.high - size * scales.way},
                 with_readings(lambda p: lambda w, t: np.clip(w, p["low"], p["high"])), 0.35, 0.1)  # fmt: skip


def shift(scales: Scales, rng: Generator) -> Draft:
    """A camera that is knocked."""
    sign, rows = _sign(rng), int(rng.uniform(0.3, 0.7) * scales.duration / scales.period)

    def make(p: Parameters) -> Callable[[Array, Array], Array]:
        return lambda w, t: w + p["size"] * (t >= p["time"])

    return Draft("sensor-drift", "sensor", "catalogue",
                 lambda size: {"size": sign * size * scales.way, "time": (rows + 0.53) * scales.period},
                 with_readings(make), 0.2, 0.02)  # fmt: skip


SENSORS: dict[str, tuple[Drafter, ...]] = {
    "lens-distortion": (lens,), "perspective": (oblique,), "encoder-eccentricity": (eccentric,),
    "quantisation": (lattice,), "clock-skew": (skew,), "timestamp-jitter": (jitter,), "outliers": (outliers,),
    "dropped-frames": (repeated,), "exposure": (exposure,), "delay": (delay,), "rolling-shutter": (shutter,),
    "clipping": (clipped,), "sensor-drift": (shift,),
}  # fmt: skip
