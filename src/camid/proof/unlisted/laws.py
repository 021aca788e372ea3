"""Laws outside the catalogue, each a shape over dimensionless position, velocity or input, written from its physics.

Position, velocity and input are in units of what the rig does without the law (twice their standard deviations), and
the shapes are of order one there; how strong a law is, the recording decides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import copysign, exp, pi, sin, sqrt, tanh

import numpy as np

Shape = Callable[[float], float]

# Where a root or a modulus would have no slope to integrate over, it is round; share of the unit.
ROUND = 0.02
# Where a rig gives way, it does within this width.
STEP_WIDTH = 0.06
# Nearer than this no magnet comes.
NEAREST = 0.35


@dataclass(frozen=True)
class Law:
    """One law outside the catalogue.

    Attributes
    ----------
    name : str
    variables : str
        What it depends on and where it acts: ``position``, ``velocity`` (a force against the motion), ``damping over
        position`` (times the velocity), ``gain over position``, ``gain over velocity`` (a loss, times the input),
        ``input`` and ``reading`` (a curve, by what it departs from a straight line).
    form : str
        Form of the documented dictionary that expresses it exactly (:data:`camid.proof.unlisted.table.FORMS`), empty
        if there is none.
    draw : callable
        From a generator of random numbers to the shape.
    """

    name: str
    variables: str
    form: str
    draw: Callable[[np.random.Generator], Shape]


def _side(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _root(x: float) -> float:
    """Root with the sign of its argument."""
    return x / (x * x + ROUND**2) ** 0.25


def _kink(x: float) -> float:
    """The argument where it is positive."""
    return max(x, 0.0)


def _beyond(x: float, half: float) -> float:
    """What of the argument lies beyond plus or minus ``half``."""
    return copysign(max(abs(x) - half, 0.0), x)


def _magnet(rng: np.random.Generator) -> Shape:
    side, place = _side(rng), rng.uniform(1.8, 2.4)
    return lambda s: -side / max(place - side * s, NEAREST) ** 2


def _detent(rng: np.random.Generator) -> Shape:
    place, width = rng.uniform(-0.6, 0.6), rng.uniform(0.2, 0.4)
    return lambda s: (s - place) / width * exp(-(((s - place) / width) ** 2))


def _lobe(rng: np.random.Generator) -> Shape:
    place, width, side = rng.uniform(-0.6, 0.6), rng.uniform(0.2, 0.4), _side(rng)
    return lambda s: side * exp(-(((s - place) / width) ** 2))


def _resonant_bump(rng: np.random.Generator) -> Shape:
    place, width, side = rng.uniform(-0.6, 0.6), rng.uniform(0.15, 0.3), _side(rng)
    return lambda s: side / (1.0 + ((s - place) / width) ** 2)


def _cam(rng: np.random.Generator) -> Shape:
    period, share = rng.uniform(0.6, 1.0), rng.uniform(0.4, 0.7)
    phases = rng.uniform(-pi, pi, 2)
    return lambda s: sin(2.0 * pi * s / period + phases[0]) + share * sin(4.0 * pi * s / period + phases[1])


def _exponential(rng: np.random.Generator) -> Shape:
    scale = _side(rng) * rng.uniform(0.35, 0.7)
    return lambda s: scale * (exp(min(s / scale, 8.0)))


def _step(rng: np.random.Generator) -> Shape:
    place = rng.uniform(-0.6, 0.6)
    return lambda s: tanh((s - place) / STEP_WIDTH)


def _soft_contact(rng: np.random.Generator) -> Shape:
    half = rng.uniform(0.25, 0.5)
    return lambda s: copysign(_beyond(s, half) ** 2, s)


def _two_stops(rng: np.random.Generator) -> Shape:
    half = rng.uniform(0.3, 0.6)
    return lambda s: _beyond(s, half)


def _hertz(rng: np.random.Generator) -> Shape:
    power = rng.uniform(1.4, 1.7)
    return lambda s: copysign(abs(s) ** power, s)


def _preload(rng: np.random.Generator) -> Shape:
    scale = rng.uniform(0.2, 0.5)
    return lambda s: tanh(s / scale)


def _quintic(rng: np.random.Generator) -> Shape:
    return lambda s: s**5


def _one_way(rng: np.random.Generator) -> Shape:
    side = _side(rng)
    return lambda r: side * _kink(side * r)


def _root_drag(rng: np.random.Generator) -> Shape:
    return _root


def _cubic_drag(rng: np.random.Generator) -> Shape:
    return lambda r: r**3


def _relief_valve(rng: np.random.Generator) -> Shape:
    half = rng.uniform(0.25, 0.5)
    return lambda r: r - _beyond(r, half)


def _one_side(rng: np.random.Generator) -> Shape:
    side, place = _side(rng), rng.uniform(-0.2, 0.4)
    return lambda s: _kink(side * s - place)


def _square(rng: np.random.Generator) -> Shape:
    return lambda s: s * s


def _modulus(rng: np.random.Generator) -> Shape:
    return lambda r: sqrt(r * r + ROUND**2)


def _negative_two_stops(rng: np.random.Generator) -> Shape:
    half = rng.uniform(0.35, 0.6)
    return lambda x: -_beyond(x, half)


def _uneven_powers(rng: np.random.Generator) -> Shape:
    powers = rng.uniform(1.5, 2.2), rng.uniform(0.5, 0.75)
    return lambda x: copysign(abs(x) ** powers[0 if x > 0.0 else 1], x) - x


def _tanh_curve(rng: np.random.Generator) -> Shape:
    scale = rng.uniform(0.5, 1.0)
    return lambda x: scale * tanh(x / scale) - x


def _signed_square(rng: np.random.Generator) -> Shape:
    side = _side(rng)
    return lambda x: side * x * x


def _one_kink(rng: np.random.Generator) -> Shape:
    side, place = _side(rng), rng.uniform(-0.3, 0.3)
    return lambda x: -side * _kink(side * x - place)


# In an order that mixes places, so that any first part of them is a fair sample.
LAWS = (
    Law("magnet beyond the end", "position", "inverse square", _magnet),
    Law("digressive damper (relief valve)", "velocity", "dead zone", _relief_valve),
    Law("valve curve with two slopes", "input", "dead zone", _negative_two_stops),
    Law("quadratic sensor", "reading", "square", _signed_square),
    Law("damping with a bump", "damping over position", "bump", _lobe),
    Law("motor constant that falls off-centre", "gain over position", "square", _square),
    Law("detent", "position", "pull", _detent),
    Law("damping in one direction", "velocity", "kink at zero", _one_way),
    Law("valve with uneven powers", "input", "", _uneven_powers),
    Law("tanh sensor", "reading", "tanh", _tanh_curve),
    Law("drag as the root of the speed", "velocity", "signed root", _root_drag),
    Law("cam with two harmonics", "position", "two harmonics", _cam),
    Law("gain that falls with the speed", "gain over velocity", "modulus", _modulus),
    Law("exponential stiffening", "position", "exponential", _exponential),
    Law("tanh amplifier", "input", "tanh", _tanh_curve),
    Law("sensor with two slopes", "reading", "kink", _one_kink),
    Law("lobe on the way", "position", "bump", _lobe),
    Law("damping on one side", "damping over position", "kink", _one_side),
    Law("cubic drag", "velocity", "cube", _cubic_drag),
    Law("spring that gives way (step)", "position", "step", _step),
    Law("weak spot of the motor", "gain over position", "bump", _lobe),
    Law("exponential valve", "input", "exponential", _exponential),
    Law("clearance with soft contacts", "position", "", _soft_contact),
    Law("exponential sensor", "reading", "exponential", _exponential),
    Law("thickening of the lubricant", "velocity", "tanh", _preload),
    Law("stops on both sides", "position", "dead zone", _two_stops),
    Law("contact of spheres", "position", "signed power", _hertz),
    Law("preloaded spring", "position", "tanh", _preload),
    Law("quintic spring", "position", "fifth power", _quintic),
    Law("bump of Lorentz's shape", "position", "rational bump", _resonant_bump),
)
