"""Rigs of one mass under a law: drawn, integrated by Runge-Kutta steps, filmed, and declared as a user would.

Written after the documentation alone; imports nothing of the tool.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil, pi, sqrt
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from .laws import LAWS, Law, Shape

Array = NDArray[np.float64]

# Runge-Kutta steps of the fourth order within a period.
STEPS = 10
# Share of the output, in standard deviations, that a law changes.
LEAST, MOST = 0.05, 0.4
# What no other coefficients could do must be as many times the noise, or nothing in the recording shows a law.
VISIBLE = 2.0
# Relative error of a nominal coefficient, at most.
WRONG = 0.2
# Strengths tried until the share is met within its tolerance.
TRIES, TOLERANCE = 14, 0.03
DRAWS = 60


@dataclass(frozen=True)
class Rig:
    """A mass on a spring, what drives and films it, and the law that nobody knows of.

    Attributes
    ----------
    frequency, damping, gain : float
        Natural frequency (rad/s), damping ratio, static gain (y/u).
    period, exposure : float
        Of the camera, s.
    frames : int
    amplitude : float
        Of the input, u.
    noise : float
        Share of the output's standard deviation.
    units : tuple of float
        Units of the law: position (y), velocity (y/s), input (u).
    law : Law or None
    shape : callable or None
    strength : float
    """

    frequency: float
    damping: float
    gain: float
    period: float
    exposure: float
    frames: int
    amplitude: float
    noise: float
    units: tuple[float, float, float] = (1.0, 1.0, 1.0)
    law: Law | None = None
    shape: Shape | None = None
    strength: float = 0.0

    def departure(self, x: float) -> float:
        """Law at a position, velocity, input or reading, as the documentation states laws.

        A force in u at the plant (per velocity if it is a damping), a share of the input that is lost, or what a curve
        adds to a straight line.
        """
        if self.law is None or self.shape is None:
            return 0.0
        position, velocity, level = self.units
        unit = {"velocity": velocity, "gain over velocity": velocity, "input": level}.get(self.law.variables, position)
        size = {
            "position": position / self.gain,
            "velocity": position / self.gain,
            "damping over position": position / self.gain / velocity,
            "input": level,
            "reading": position,
        }.get(self.law.variables, 1.0)
        zero = 0.0 if self.law.variables in ("damping over position",) else self.shape(0.0)
        return self.strength * size * (self.shape(x / unit) - zero)

    def pulls(self) -> Callable[[float, float, float], float]:
        """Force at the plant's input (u) by position, velocity and input."""
        kind = self.law.variables if self.law is not None else ""
        law = self.departure
        kinds: dict[str, Callable[[float, float, float], float]] = {
            "position": lambda y, v, u: u - law(y),
            "velocity": lambda y, v, u: u - law(v),
            "damping over position": lambda y, v, u: u - law(y) * v,
            "gain over position": lambda y, v, u: u * (1.0 - law(y)),
            "gain over velocity": lambda y, v, u: u * (1.0 - law(v)),
            "input": lambda y, v, u: u + law(u),
        }
        return kinds.get(kind, lambda y, v, u: u)

    def film(self, levels: Array) -> tuple[Array, float]:
        """Readings without noise, shape (frames,), and the root mean square velocity (y/s)."""
        force, square = self.pulls(), self.frequency**2
        drag, push = 2.0 * self.damping * self.frequency, self.gain * square

        def rates(y: float, v: float, u: float) -> tuple[float, float]:
            return v, push * force(y, v, u) - drag * v - square * y

        y = v = speeds = 0.0
        seen = np.zeros(self.frames)
        # Steps end where an exposure begins.
        parts = [(length, exposed) for length, exposed in _parts(self.period, self.exposure) if length > 0.0]
        for k in range(1, self.frames):
            u = float(levels[k - 1])
            for length, exposed in parts:
                count = ceil(STEPS * length / self.period)
                area = 0.0
                for _ in range(count):
                    y, v, mean = _step(rates, y, v, u, length / count)
                    area += mean
                if exposed:
                    seen[k] = area / count
            speeds += v * v
        if self.law is not None and self.law.variables == "reading":
            seen = np.array([w + self.departure(float(w)) for w in seen])
        return seen, sqrt(speeds / self.frames)


def _parts(period: float, exposure: float) -> tuple[tuple[float, bool], tuple[float, bool]]:
    closed = period - exposure
    return (closed if closed > 1e-9 * period else 0.0, False), (exposure, True)


def _step(
    rates: Callable[[float, float, float], tuple[float, float]], y: float, v: float, u: float, step: float
) -> tuple[float, float, float]:
    """Position and velocity after a step, and the mean position in it, of one order more than a trapezium's."""
    a, b = rates(y, v, u)
    c, d = rates(y + 0.5 * step * a, v + 0.5 * step * b, u)
    e, f = rates(y + 0.5 * step * c, v + 0.5 * step * d, u)
    g, h = rates(y + step * e, v + step * f, u)
    end, fast = y + step * (a + 2.0 * c + 2.0 * e + g) / 6.0, v + step * (b + 2.0 * d + 2.0 * f + h) / 6.0
    return end, fast, 0.5 * (y + end) + step * (v - fast) / 12.0


# -- inputs ------------------------------------------------------------------------------------------------------------


def random_levels(rig: Rig, rng: np.random.Generator) -> Array:
    """Random levels, held for a tenth of a natural period up to one."""
    natural = 2.0 * pi / rig.frequency / rig.period
    levels: list[float] = []
    while len(levels) < rig.frames:
        levels += [rig.amplitude * float(rng.uniform(-1.0, 1.0))] * ceil(natural * rng.uniform(0.1, 1.0))
    return np.array(levels[: rig.frames])


def multisine(rig: Rig, rng: np.random.Generator) -> Array:
    """Sines of random phases from a tenth of the natural frequency up to twice that."""
    frequencies = rig.frequency * rng.uniform(0.1, 2.0, 16)
    phases = rng.uniform(-pi, pi, 16)
    time = rig.period * np.arange(rig.frames)
    waves = np.sin(time[:, None] * frequencies + phases).sum(axis=1)
    return np.asarray(rig.amplitude * 0.6 * waves / np.std(waves))


def binary(rig: Rig, rng: np.random.Generator) -> Array:
    """A maximum-length sequence of order 9, clocked eight times in a natural period, from a random start."""
    register = list(rng.integers(0, 2, 9))
    if not any(register):
        register[0] = 1
    held = max(1, round(2.0 * pi / rig.frequency / rig.period / 8.0))
    levels: list[float] = []
    while len(levels) < rig.frames:
        levels += [rig.amplitude * 0.7 * (2.0 * float(register[-1]) - 1.0)] * held
        register = [register[8] ^ register[4], *register[:8]]
    return np.array(levels[: rig.frames])


INPUTS = {"random levels": random_levels, "multisine": multisine, "PRBS": binary}


# -- recordings --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Case:
    """Two recordings of a rig, and what its user believes.

    ``first`` has columns ``t``, ``u``, ``y``; ``second`` as well, and ``clean`` is its ``y`` without noise, shape
    (frames,). ``share`` is the part of the output that the law changes, ``left`` what of that no coefficients could
    do, both in standard deviations of the output.
    """

    rig: Rig
    inputs: tuple[str, str]
    first: pd.DataFrame
    second: pd.DataFrame
    clean: Array
    share: float
    left: float

    def simulation(self, rng: np.random.Generator) -> dict[str, Any]:
        """What the user believes: the right structure without the law, and wrong coefficients."""
        rig = self.rig
        square = rig.frequency**2
        gain, drag, spring = (
            float(f"{value * (1.0 + rng.uniform(-WRONG, WRONG)):.5g}")
            for value in (rig.gain * square, 2.0 * rig.damping * rig.frequency, square)
        )
        return {
            "schema": 1,
            "time": {"column": "t"},
            "input": {"column": "u", "hold": "zoh"},
            "plant": {"transfer_function": {"numerator": [gain], "denominator": [1.0, drag, spring]}},
            "sensor": {"column": "y", "kind": "camera", "exposure": rig.exposure},
        }


def generator(seed: int, number: int, missing: bool) -> np.random.Generator:
    """Random numbers of one case."""
    return np.random.default_rng([seed, number, int(missing)])


def draw(rng: np.random.Generator, law: Law | None) -> Case:
    """A rig under a law, or under none, and its recordings.

    Raises
    ------
    RuntimeError
        If no rig drawn shows the law.
    """
    for _ in range(DRAWS):
        case = _drawn(rng, law)
        if case is not None:
            return case
    raise RuntimeError(f"no rig shows the law {law.name if law else ''}")


def law_of(number: int) -> Law:
    """Law of a case: one after the other."""
    return LAWS[number % len(LAWS)]


def _drawn(rng: np.random.Generator, law: Law | None) -> Case | None:
    frequency = 10.0 ** rng.uniform(-0.3, 2.3)
    period = float(f"{rng.uniform(0.12, 0.35) / frequency:.3g}")
    plain = Rig(
        frequency=frequency,
        damping=10.0 ** rng.uniform(-1.4, -0.25),
        gain=float(_side(rng) * 10.0 ** rng.uniform(-3.0, 3.0)),
        period=period,
        exposure=float(f"{period * rng.uniform(0.3, 1.0):.4g}"),
        frames=int(rng.integers(1200, 1801)),
        amplitude=10.0 ** rng.uniform(-2.0, 2.0),
        noise=10.0 ** rng.uniform(np.log10(0.002), np.log10(0.02)),
    )
    # A two-level input shows nothing of a curve of the actuator, as the documentation warns.
    names = [name for name in INPUTS if name != "PRBS" or law is None or law.variables != "input"]
    first, second = (str(name) for name in rng.choice(names, 2, replace=False))
    levels = INPUTS[first](plain, rng)
    without, velocity = plain.film(levels)
    rig, share, left = plain, 0.0, 0.0
    if law is not None:
        units = (2.0 * float(np.std(without)), 2.0 * velocity, 2.0 * float(np.std(levels)))
        rig = replace(plain, units=units, law=law, shape=law.draw(rng))
        target = 10.0 ** rng.uniform(np.log10(LEAST), np.log10(MOST))
        found = _strengthened(rig, levels, without, target)
        if found is None:
            return None
        rig = found
    seen, _ = rig.film(levels)
    deviation = float(np.std(seen))
    if law is not None:
        share = float(np.std(seen - without)) / float(np.std(without))
        left = _beyond_coefficients(plain, levels, without, seen) / deviation
        if left < VISIBLE * rig.noise:
            return None
    others = INPUTS[second](rig, rng)
    others *= _amplitude(law, plain, levels, without) / _amplitude(law, plain, others, plain.film(others)[0])
    clean, _ = rig.film(others)
    noise = rig.noise * deviation
    tables = [
        pd.DataFrame({"t": rig.period * np.arange(rig.frames), "u": u, "y": y + noise * rng.standard_normal(len(y))})
        for u, y in ((levels, seen), (others, clean))
    ]
    return Case(rig, (first, second), tables[0], tables[1], clean, share, left)


def _amplitude(law: Law | None, plain: Rig, levels: Array, motion: Array) -> float:
    """Largest value of what the law depends on, in the rig without it: the law is asked for where the first one was."""
    if law is not None and law.variables == "input":
        return float(np.max(np.abs(levels)))
    if law is not None and "velocity" in law.variables:
        return float(np.max(np.abs(np.gradient(motion, plain.period))))
    return float(np.max(np.abs(motion)))


def _side(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _strengthened(rig: Rig, levels: Array, without: Array, target: float) -> Rig | None:
    """The rig with a law of the strength that changes a share of the output; None where there is none."""
    size, low, high, strength = float(np.std(without)), 0.0, np.inf, 0.3
    for _ in range(TRIES):
        found = replace(rig, strength=strength)
        try:
            share = float(np.std(found.film(levels)[0] - without)) / size
        except OverflowError:
            share = np.inf
        if abs(share / target - 1.0) < TOLERANCE:
            return found
        if share < target:
            low = strength
        else:
            high = strength
        strength = sqrt(max(low, 1e-3 * high) * high) if np.isfinite(high) else 2.0 * strength
    return None


def _beyond_coefficients(plain: Rig, levels: Array, without: Array, seen: Array) -> float:
    """Root mean square of what the law does that no coefficients and no offset could, to first order."""
    step = 1e-3
    columns = [without, np.ones(len(without))]
    others = [replace(plain, **{name: getattr(plain, name) * (1.0 + step)}) for name in ("frequency", "damping")]
    columns += [(other.film(levels)[0] - without) / step for other in others]
    table = np.stack(columns, axis=1)
    table /= np.linalg.norm(table, axis=0)
    change = seen - without
    return float(np.std(change - table @ np.linalg.lstsq(table, change, rcond=None)[0]))
