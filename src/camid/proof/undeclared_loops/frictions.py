"""Dry frictions and hysteresis of the catalogue, as its formulas state them."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from .setup import Draft, Drafter, Hidden, Level, Scales, Setup

Generator = np.random.Generator
Parameters = dict[str, Any]


def with_friction(make: Any) -> Any:
    """Return an installer of the friction that ``make`` makes of the parameters."""

    def install(setup: Setup, p: Parameters) -> None:
        level: Level = make(p)
        setup.friction = level

    return install


def coulomb(scales: Scales, rng: Generator) -> Draft:
    """Friction of constant size."""

    def make(p: Parameters) -> Level:
        force = p["force"]
        return lambda y, speed, u, side: force

    return Draft(
        "coulomb-friction",
        "plant",
        "catalogue",
        lambda size: {"force": size * scales.command},
        with_friction(make),
        0.4,
        0.1,
    )


def falling_levels(scales: Scales, rng: Generator) -> Callable[[float], Parameters]:
    """Draw levels (u) at high speeds and at rest, and the speed (y/s) at which friction falls, for any size."""
    share, speed = float(rng.uniform(0.4, 0.7)), float(rng.uniform(0.04, 0.25)) * scales.speed

    def parameters(size: float) -> Parameters:
        most = size * scales.command
        return {"coulomb": share * most, "breakaway": most, "velocity": speed}

    return parameters


def stribeck(scales: Scales, rng: Generator) -> Draft:
    """Friction that falls from its break-away level."""
    parameters = falling_levels(scales, rng)

    def make(p: Parameters) -> Level:
        low, rise, v = p["coulomb"], p["breakaway"] - p["coulomb"], p["velocity"]
        return lambda y, speed, u, side: low + rise * math.exp(-((speed / v) ** 2))

    return Draft("stribeck-friction", "plant", "catalogue", parameters, with_friction(make), 0.4, 0.12)


def asymmetric(scales: Scales, rng: Generator) -> Draft:
    """Friction of another size in each direction."""
    share, turned = float(rng.uniform(0.2, 0.65)), bool(rng.random() < 0.5)

    def parameters(size: float) -> Parameters:
        pair = (size * scales.command, share * size * scales.command)
        return {"forward": pair[turned], "backward": pair[not turned]}

    def make(p: Parameters) -> Level:
        forward, backward = p["forward"], p["backward"]
        return lambda y, speed, u, side: forward if side > 0.0 else backward

    return Draft("asymmetric-friction", "plant", "catalogue", parameters, with_friction(make), 0.4, 0.12)


def position_dependent(scales: Scales, rng: Generator) -> Draft:
    """Friction that grows along the way; it stays above zero wherever the machine goes."""
    share = float(rng.uniform(0.4, 0.85)) * float(rng.choice([-1.0, 1.0]))

    def parameters(size: float) -> Parameters:
        middle = 0.6 * size * scales.command
        return {"force": middle, "gradient": share * middle / scales.reach}

    def make(p: Parameters) -> Level:
        force, gradient = p["force"], p["gradient"]
        return lambda y, speed, u, side: max(force + gradient * y, 0.0)

    return Draft("position-dependent-friction", "plant", "catalogue", parameters, with_friction(make), 0.42, 0.12)


def load_dependent(scales: Scales, rng: Generator) -> Draft:
    """Friction that grows with what is transmitted."""
    share = float(rng.uniform(0.05, 0.35))

    def make(p: Parameters) -> Level:
        force, coefficient = p["force"], p["coefficient"]
        return lambda y, speed, u, side: force + coefficient * abs(u)

    return Draft(
        "load-dependent-friction",
        "plant",
        "catalogue",
        lambda size: {"force": share * size * scales.command, "coefficient": size},
        with_friction(make),
        0.35,
        0.12,
    )


def hysteresis(scales: Scales, rng: Generator) -> Draft:
    """A force that follows the motion and saturates."""
    shape = 1.0 / (scales.way * float(np.exp(rng.uniform(np.log(0.03), np.log(0.4)))))

    def install(setup: Setup, p: Parameters) -> None:
        h, k = p["strength"], p["shape"]
        setup.hidden = Hidden(lambda z: h * z, lambda y, v, z: k * (v - 0.5 * abs(v) * z - 0.5 * v * abs(z)))

    return Draft(
        "hysteresis",
        "plant",
        "catalogue",
        lambda size: {"strength": size * scales.command, "shape": shape},
        install,
        0.4,
        0.12,
    )


def bristles(scales: Scales, rng: Generator) -> Draft:
    """Coulomb friction that bends before it slides."""
    bend = scales.way * float(np.exp(rng.uniform(np.log(0.01), np.log(0.05))))

    def install(setup: Setup, p: Parameters) -> None:
        force, d = p["force"], p["presliding"]
        setup.hidden = Hidden(lambda z: force * z, lambda y, v, z: (v - abs(v) * z) / d)

    return Draft(
        "coulomb-friction",
        "plant",
        "catalogue",
        lambda size: {"force": size * scales.command, "presliding": bend},
        install,
        0.4,
        0.12,
    )


FRICTIONS: dict[str, tuple[Drafter, ...]] = {
    "coulomb-friction": (coulomb, coulomb, coulomb, bristles),
    "stribeck-friction": (stribeck,),
    "asymmetric-friction": (asymmetric,),
    "position-dependent-friction": (position_dependent,),
    "load-dependent-friction": (load_dependent,),
    "hysteresis": (hysteresis,),
}
