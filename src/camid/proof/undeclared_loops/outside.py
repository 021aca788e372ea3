"""Physics that no law of the catalogue describes; ids of its own."""

import math
from typing import Any

import numpy as np

from .fields import with_force
from .setup import Draft, Drafter, Force, Hidden, Scales, Setup

Generator = np.random.Generator
Parameters = dict[str, Any]


def latch(scales: Scales, rng: Generator) -> Draft:
    """A magnet beside the way: it pulls to one place, and only near it."""
    place = scales.low + 2.0 * scales.way * float(rng.uniform(0.25, 0.75))
    width = scales.way * float(rng.uniform(0.06, 0.2))

    def make(p: Parameters) -> Force:
        m, c, w = p["force"], p["place"], p["width"]

        def force(t: float, y: float, v: float, u: float) -> float:
            x = (y - c) / w
            return m * x * math.exp(0.5 - 0.5 * x * x)

        return force

    return Draft("magnetic-latch", "plant", "m x exp((1 − x²)/2), x = (y − c)/w",
                 lambda size: {"force": size * scales.command, "place": place, "width": width},
                 with_force("magnetic-latch", make), 0.35, 0.1)  # fmt: skip


def cable(scales: Scales, rng: Generator) -> Draft:
    """A cable that hangs from one end and is whipped: its pull grows with the place and the speed, both ways alike."""
    sign = float(rng.choice([-1.0, 1.0]))

    def make(p: Parameters) -> Force:
        c = p["coefficient"]
        return lambda t, y, v, u: c * y * abs(v)

    return Draft("cable-pull", "plant", "c y |v|",
                 lambda size: {"coefficient": sign * size * scales.command / (scales.reach * scales.speed)},
                 with_force("cable-pull", make), 0.8, 0.2)  # fmt: skip


def slip(scales: Scales, rng: Generator) -> Draft:
    """A belt that slips with what it transmits: the loss grows with its square, and with the speed."""

    def make(p: Parameters) -> Force:
        c = p["coefficient"]
        return lambda t, y, v, u: c * u * abs(u) * abs(v)

    return Draft("belt-slip", "plant", "c u |u| |v|",
                 lambda size: {"coefficient": size / (scales.command * scales.speed)},
                 with_force("belt-slip", make), 0.8, 0.2)  # fmt: skip


def ripple(scales: Scales, rng: Generator) -> Draft:
    """A motor whose force constant ripples along the way."""
    period, phase = 2.0 * scales.way / float(rng.uniform(3.0, 10.0)), float(rng.uniform(-math.pi, math.pi))

    def make(p: Parameters) -> Force:
        c, k, f = p["share"], 2.0 * math.pi / p["period"], p["phase"]
        return lambda t, y, v, u: c * u * math.sin(k * y + f)

    return Draft("force-ripple", "plant", "c u sin(2π y/p + φ)",
                 lambda size: {"share": size, "period": period, "phase": phase},
                 with_force("force-ripple", make), 0.5, 0.15)  # fmt: skip


def sticky_band(scales: Scales, rng: Generator) -> Draft:
    """A band of the guide in which old grease resists the speed."""
    place = scales.low + 2.0 * scales.way * float(rng.uniform(0.25, 0.75))
    width = scales.way * float(rng.uniform(0.1, 0.3))

    def make(p: Parameters) -> Force:
        c, m, w = p["coefficient"], p["place"], p["width"]
        return lambda t, y, v, u: c * v * math.exp(-(((y - m) / w) ** 2))

    return Draft("grease-band", "plant", "c v exp(−((y − m)/w)²)",
                 lambda size: {"coefficient": size * scales.command / scales.speed, "place": place, "width": width},
                 with_force("grease-band", make), 1.0, 0.25)  # fmt: skip


def creep(scales: Scales, rng: Generator) -> Draft:
    """A hose that resists a displacement and forgets it: a spring and a damper in a row (Maxwell)."""
    constant = float(np.exp(rng.uniform(np.log(1.5), np.log(8.0)))) / scales.bandwidth

    def install(setup: Setup, p: Parameters) -> None:
        k, time = p["stiffness"], p["time_constant"]
        setup.hidden = Hidden(lambda z: k * z, lambda y, v, z: v - z / time)

    return Draft("forgetful-hose", "plant", "k z, dz/dt = v − z/τ",
                 lambda size: {"stiffness": size * scales.command / scales.way, "time_constant": constant},
                 install, 0.5, 0.1)  # fmt: skip


OUTSIDE: dict[str, Drafter] = {
    "magnetic latch": latch, "cable pull": cable, "belt slip": slip, "force ripple": ripple,
    "sticky band": sticky_band, "creep": creep,
}  # fmt: skip
