"""What an actuator makes of its command, as the catalogue's formulas state it."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from .setup import Draft, Drafter, Scales, Setup

Generator = np.random.Generator
Parameters = dict[str, Any]


def with_curve(make: Callable[[Parameters], Callable[[float], float]]) -> Callable[[Setup, Parameters], None]:
    """Return an installer of the curve from u to u that ``make`` makes of the parameters, anew for each run."""

    def install(setup: Setup, p: Parameters) -> None:
        setup.curves.append(lambda: make(p))

    return install


def _draft(
    name: str, key: str, unit: float, make: Callable[[Parameters], Callable[[float], float]], cap: float
) -> Draft:
    return Draft(name, "actuator", "catalogue", lambda size: {key: size * unit}, with_curve(make), cap, 0.25 * cap)


def saturation(scales: Scales, rng: Generator) -> Draft:
    """No force beyond a limit."""

    def make(p: Parameters) -> Callable[[float], float]:
        limit = p["limit"]
        return lambda u: max(-limit, min(u, limit))

    return Draft("saturation", "actuator", "catalogue", lambda size: {"limit": scales.command * (1.0 - size)},
                 with_curve(make), 0.6, 0.3)  # fmt: skip


def dead_zone(scales: Scales, rng: Generator) -> Draft:
    """No force for a small command."""

    def make(p: Parameters) -> Callable[[float], float]:
        half = p["half_width"]
        return lambda u: u - half if u > half else u + half if u < -half else 0.0

    return _draft("dead-zone", "half_width", scales.command, make, 0.3)


def backlash(scales: Scales, rng: Generator) -> Draft:
    """Play of the command."""

    def make(p: Parameters) -> Callable[[float], float]:
        half, held = p["half_width"], [0.0]

        def follow(u: float) -> float:
            held[0] = min(max(held[0], u - half), u + half)
            return held[0]

        return follow

    return _draft("backlash", "half_width", scales.command, make, 0.25)


def gain_asymmetry(scales: Scales, rng: Generator) -> Draft:
    """Another gain for negative commands."""
    sign = float(rng.choice([-1.0, 1.0]))

    def make(p: Parameters) -> Callable[[float], float]:
        ratio = p["ratio"]
        return lambda u: u if u >= 0.0 else ratio * u

    return Draft("gain-asymmetry", "actuator", "catalogue", lambda size: {"ratio": 1.0 + sign * size},
                 with_curve(make), 0.5, 0.1)  # fmt: skip


def bias(scales: Scales, rng: Generator) -> Draft:
    """A constant that is added."""
    sign = float(rng.choice([-1.0, 1.0]))

    def make(p: Parameters) -> Callable[[float], float]:
        constant = p["bias"]
        return lambda u: u + constant

    return _draft("input-bias", "bias", sign * scales.command, make, 0.35)


def rounding(scales: Scales, rng: Generator) -> Draft:
    """A command that is rounded."""

    def make(p: Parameters) -> Callable[[float], float]:
        step = p["step"]
        return lambda u: step * round(u / step)

    return _draft("input-quantisation", "step", scales.command, make, 0.35)


def lag(scales: Scales, rng: Generator) -> Draft:
    """A lag of first order, small beside the loop."""

    def install(setup: Setup, p: Parameters) -> None:
        constant = p["time_constant"]
        setup.approach = lambda last, wanted, time: wanted + (last - wanted) * math.exp(-time / constant)

    return Draft("actuator-lag", "actuator", "catalogue",
                 lambda size: {"time_constant": size / scales.fast}, install, 0.5, 0.1)  # fmt: skip


def rate_limit(scales: Scales, rng: Generator) -> Draft:
    """A limited rate; its strength is the inverse of it."""

    def install(setup: Setup, p: Parameters) -> None:
        rate = p["rate"]

        def approach(last: float, wanted: float, time: float) -> float:
            way = rate * time
            return min(wanted, last + way) if wanted > last else max(wanted, last - way)

        setup.approach = approach
        setup.corner = lambda last, wanted: abs(wanted - last) / rate

    return Draft("rate-limit", "actuator", "catalogue", lambda size: {"rate": scales.slope / size},
                 install, 12.0, 2.0)  # fmt: skip


ACTUATORS: dict[str, tuple[Drafter, ...]] = {
    "saturation": (saturation,), "dead-zone": (dead_zone,), "backlash": (backlash,),
    "gain-asymmetry": (gain_asymmetry,), "input-bias": (bias,), "input-quantisation": (rounding,),
    "actuator-lag": (lag,), "rate-limit": (rate_limit,),
}  # fmt: skip
