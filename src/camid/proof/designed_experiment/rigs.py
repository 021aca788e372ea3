"""Rigs of a mass on a spring with one law that a user does not know, and recordings of any input.

Nothing here imports camid. y'' = gain (u' - f) - 2 damping w y' - w^2 y; the camera reads the mean of the position over
the whole frame that ends at the time stamp.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import copysign, exp, log, pi, sqrt, tanh
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Longest step of the integrator in seconds, and as a share of the rig's period.
LONGEST_STEP, LARGEST_SHARE = 2.5e-4, 1.0 / 2000.0
# Laws of the catalogue, by what they act on; the others are outside of it.
FRICTION, DRAG, SPRING, ACTUATOR, SENSOR = "friction", "drag", "spring", "actuator", "sensor"
LISTED = {
    "dry friction": FRICTION,
    "quadratic drag": DRAG,
    "damping that grows with the position": DRAG,
    "cubic spring": SPRING,
    "quadratic spring": SPRING,
    "dead zone": ACTUATOR,
    "saturation": ACTUATOR,
    "play": ACTUATOR,
    "uneven gain": ACTUATOR,
    "lens": SENSOR,
    "perspective": SENSOR,
}
OUTSIDE = {
    "drag of power 1.5": DRAG,
    "spring of power 5": SPRING,
    "soft saturation": ACTUATOR,
    "sensor with two slopes": SENSOR,
}
FORCES: dict[str, Callable[[float, float, float], float]] = {
    "quadratic drag": lambda s, y, v: s * abs(v) * v,
    "damping that grows with the position": lambda s, y, v: s * y * y * v,
    "cubic spring": lambda s, y, v: s * y**3,
    "quadratic spring": lambda s, y, v: s * y * y,
    "drag of power 1.5": lambda s, y, v: s * sqrt(abs(v)) * v,
    "spring of power 5": lambda s, y, v: s * y**5,
}
PATHS: dict[str, Callable[[float, float, float], float]] = {
    "dead zone": lambda s, u, held: copysign(max(abs(u) - s, 0.0), u),
    "saturation": lambda s, u, held: max(-s, min(u, s)),
    "play": lambda s, u, held: min(max(held, u - s), u + s),
    "uneven gain": lambda s, u, held: u if u >= 0.0 else s * u,
    "soft saturation": lambda s, u, held: s * tanh(u / s),
}
INPUTS = ("two levels", "sine", "several levels")


@dataclass(frozen=True)
class Rig:
    """A rig, and how its first recording is made.

    Attributes
    ----------
    seed, number : int
    law : str
        What the user does not know.
    strength : float
        Of the law, in units that follow from it.
    frequency, damping, gain : float
        Hz, ratio, mm/s^2 per V.
    amplitude : float
        V, of the first input.
    period : float
        Seconds from frame to frame.
    rows : int
    noise : float
        Standard deviation of a reading in mm.
    excitation : str
    wrong : tuple of float
        Factors by which the coefficients that the user believes are wrong.
    """

    seed: int
    number: int
    law: str
    strength: float
    frequency: float
    damping: float
    gain: float
    amplitude: float
    period: float
    rows: int
    noise: float
    excitation: str
    wrong: tuple[float, float, float]

    @property
    def listed(self) -> bool:
        """Whether the law is one of the catalogue."""
        return self.law in LISTED

    def simulation(self) -> dict[str, Any]:
        """What the user believes: the right structure without the law, and wrong coefficients."""
        speed = 2.0 * pi * self.frequency
        a, b, c = self.wrong
        denominator = [1.0, 2.0 * self.damping * speed * b, speed**2 * c]
        return {
            "schema": 1,
            "time": {"column": "t"},
            "input": {"column": "u", "hold": "zoh"},
            "plant": {"transfer_function": {"numerator": [self.gain * a], "denominator": denominator}},
            "sensor": {"column": "y", "kind": "camera", "exposure": self.period, "offset": 0.0},
            "initial_state": "zero",
        }


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """Drawn evenly on a scale of ratios."""
    return exp(rng.uniform(log(low), log(high)))


def draw(seed: int, number: int) -> Rig:
    """A rig by its number; every sixth has a law outside of the catalogue."""
    rng = np.random.default_rng([seed, number])
    laws = list(OUTSIDE) if number % 6 == 5 else list(LISTED)
    law = laws[int(rng.integers(len(laws)))]
    frequency, damping = _between(rng, 0.8, 3.0), _between(rng, 0.04, 0.4)
    stiffness = (2.0 * pi * frequency) ** 2
    amplitude = _between(rng, 1.0, 5.0)
    excitation = INPUTS[int(rng.choice(3, p=[0.45, 0.45, 0.1]))]
    if law in {"dead zone", "saturation", "soft saturation"}:
        excitation = INPUTS[1 + int(rng.integers(2))]  # two levels never show what happens between them
    rig = Rig(
        seed,
        number,
        law,
        0.0,
        frequency,
        damping,
        stiffness * _between(rng, 1.0, 4.0),
        amplitude,
        period=float(rng.choice([0.02, 0.025, 0.04])),
        rows=int(rng.integers(250, 500)),
        noise=0.0,
        excitation=excitation,
        wrong=(_between(rng, 0.8, 1.25), _between(rng, 0.7, 1.4), _between(rng, 0.9, 1.1)),
    )
    position = readings(rig, first_input(rig), None)
    size, speed = float(np.std(position)), float(np.std(np.gradient(position, rig.period)))
    # Most springs harden; one that softens is a pendulum to within what any input shows.
    sign = 1.0 if rng.random() < (0.85 if law == "cubic spring" else 0.5) else -1.0
    strength = strength_of(law, _between(rng, 0.015, 0.1), sign, amplitude, size, speed)
    noise = size * _between(rng, 0.01, 0.06)
    return Rig(**{**vars(rig), "strength": strength, "noise": noise})


def strength_of(law: str, share: float, sign: float, force: float, size: float, speed: float) -> float:
    """Strength of a law that makes about ``share`` of the input's force, or of the reading.

    Parameters
    ----------
    law : str
    share, sign : float
    force : float
        V.
    size, speed : float
        Standard deviations of position (mm) and velocity (mm/s).
    """
    strengths = {
        "dry friction": share * force,
        "quadratic drag": share * force / speed**2,
        "damping that grows with the position": share * force / (size**2 * speed),
        "cubic spring": sign * 0.5 * share * force / size**3,
        "quadratic spring": sign * 0.5 * share * force / size**2,
        "dead zone": share * force,
        "saturation": (1.0 - 2.0 * share) * force,
        "play": share * force,
        "uneven gain": 1.0 - sign * share,
        "lens": sign * 0.5 * share / size**2,
        "perspective": sign * 0.3 * share / size,
        "drag of power 1.5": share * force / speed**1.5,
        "spring of power 5": 0.2 * share * force / size**5,
        "soft saturation": force / (3.0 * share) ** 0.5,
        "sensor with two slopes": sign * share,
    }
    return strengths[law]


def first_input(rig: Rig) -> Array:
    """Input of the first recording, V, shape (N,)."""
    rng = np.random.default_rng([rig.seed, rig.number, 1])
    hold = max(round(0.35 / (rig.frequency * rig.period)), 1)
    if rig.excitation == "sine":
        time = rig.period * np.arange(rig.rows)
        signal = rig.amplitude * np.sin(2.0 * pi * 0.7 * rig.frequency * time)
    else:
        count = rig.rows // hold + 1
        choices = np.array([-1.0, 1.0]) if rig.excitation == "two levels" else np.linspace(-1.0, 1.0, 5)
        signal = rig.amplitude * np.repeat(rng.choice(choices, count), hold)[: rig.rows]
    return np.round(signal, 4)


def recording(rig: Rig, signal: Array, run: int) -> pd.DataFrame:
    """A recording of an input (V, shape (N,)): ``t`` (s), ``u`` and ``y`` (mm); ``run`` draws its noise."""
    rng = np.random.default_rng([rig.seed, rig.number, 2, run])
    seen = readings(rig, signal, rig.law) + rig.noise * rng.standard_normal(len(signal))
    time = rig.period * np.arange(len(signal))
    return pd.DataFrame({"t": np.round(time, 6), "u": signal, "y": np.round(seen, 7)})


def readings(rig: Rig, signal: Array, law: str | None) -> Array:
    """What the camera reads without noise, mm, shape (N,); the rig rests before the first sample."""
    parts = int(np.ceil(rig.period / min(LONGEST_STEP, LARGEST_SHARE / rig.frequency)))
    step = rig.period / parts
    position = velocity = held = 0.0
    means = np.zeros(len(signal))
    for k, wanted in enumerate(signal[:-1].tolist()):
        held = actuated(law, rig.strength, wanted, held)
        total = 0.0
        for _ in range(parts):
            before = position
            position, velocity = _step(rig, law, held, position, velocity, step)
            total += 0.5 * (seen(law, rig.strength, before) + seen(law, rig.strength, position))
        means[k + 1] = total / parts
    means[0] = seen(law, rig.strength, 0.0)
    return means


def _step(rig: Rig, law: str | None, force: float, position: float, velocity: float, h: float) -> tuple[float, float]:
    """Position and velocity after a step: half a kick, a drift, half a kick; dry friction holds what it can."""
    dry = rig.strength if law == "dry friction" else 0.0
    for drifts in (True, False):
        speed = 2.0 * pi * rig.frequency
        drive = rig.gain * (force - resisting(law, rig.strength, position, velocity))
        drive -= 2.0 * rig.damping * speed * velocity + speed**2 * position
        if dry > 0.0:
            hold = rig.gain * dry
            if velocity == 0.0:
                drive = 0.0 if abs(drive) <= hold else drive - copysign(hold, drive)
            else:
                drive -= copysign(hold, velocity)
        kicked = velocity + 0.5 * h * drive
        if dry > 0.0 and velocity * kicked < 0.0:
            kicked = 0.0
        velocity = kicked
        if drifts:
            position += h * velocity
    return position, velocity


def resisting(law: str | None, s: float, y: float, v: float) -> float:
    """Force of a law against the motion, V, but for dry friction."""
    if law is None or law not in FORCES:
        return 0.0
    return FORCES[law](s, y, v)


def actuated(law: str | None, s: float, u: float, held: float) -> float:
    """What the actuator makes of a level, V; ``held`` is what it made of the last one."""
    if law is None or law not in PATHS:
        return u
    return PATHS[law](s, u, held)


def seen(law: str | None, s: float, y: float) -> float:
    """What the camera makes of a position, mm."""
    if law == "lens":
        return y * (1.0 + s * y * y)
    if law == "perspective":
        return y / (1.0 + s * y)
    if law == "sensor with two slopes":
        return y * (1.0 + s) if y > 0.0 else y
    return y
