"""Families of inputs, each with a few numbers that an optimiser may choose.

References
----------
Pintelon and Schoukens (2012), *System Identification: A Frequency Domain Approach*, 2nd ed., Wiley, ch. 5.
Nelles (2001), *Nonlinear System Identification*, Springer, ch. 17.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.excitation import TAPS, multilevel, multisine, pseudo_random_binary_sequence

Array = NDArray[np.float64]

# Share of the range that the smallest candidates use.
SMALLEST_SHARE = 0.05
# Levels, phases and orders of runs that a number between zero and one chooses from.
SEEDS = 97


@dataclass(frozen=True)
class Band:
    """Where the rig answers: lowest and highest frequency in hertz, period and number of the rows."""

    low: float
    high: float
    period: float
    rows: int

    @property
    def duration(self) -> float:
        """Seconds."""
        return self.rows * self.period

    @property
    def time(self) -> Array:
        """Seconds, shape (N,)."""
        return np.asarray(self.period * np.arange(self.rows), dtype=np.float64)

    def frequency(self, x: float) -> float:
        """From the lowest (0) to the highest (1), even on a scale of ratios."""
        return float(self.low * (self.high / self.low) ** x)

    def hold(self, x: float) -> int:
        """Rows that a level lasts: from half a cycle of the highest frequency (0) to one of the lowest (1)."""
        seconds = 0.5 / self.frequency(1.0 - x)
        return int(np.clip(round(seconds / self.period), 1, max(self.rows // 6, 1)))


@dataclass(frozen=True)
class Family:
    """A family of inputs.

    Attributes
    ----------
    name : str
    numbers : int
        Numbers between zero and one that choose a member.
    make : callable
        From these numbers and a band to a signal between minus one and one, shape (N,), and what describes it.
    """

    name: str
    numbers: int
    make: Callable[[Array, Band], tuple[Array, dict[str, Any]]]


def _share(x: float) -> float:
    """Share of the range: half of all candidates use nearly half of it or more: most effects show in large motion."""
    return float(SMALLEST_SHARE ** ((1.0 - x) ** 2))


def _filled(part: Array, rows: int) -> Array:
    return np.resize(part, rows)


def _multisine(x: Array, band: Band) -> tuple[Array, dict[str, Any]]:
    low, high = sorted((band.frequency(x[0]), band.frequency(x[1])))
    lines = np.arange(max(int(np.ceil(low * band.duration)), 1), int(high * band.duration) + 1)
    lines = lines[2 * lines < band.rows]
    lines = lines if len(lines) else np.array([1])
    lines = lines[:: max(len(lines) // 60, 1)]
    generator = np.random.default_rng(int(x[3] * SEEDS))
    signal = multisine(band.rows, lines.tolist(), phases="random", generator=generator)
    signal = _share(x[2]) * signal / float(np.max(np.abs(signal)))
    first, last = lines[0] / band.duration, lines[-1] / band.duration
    return signal, {"lowest_frequency": first, "highest_frequency": last, "lines": len(lines), "share": _share(x[2])}


def _prbs(x: Array, band: Band) -> tuple[Array, dict[str, Any]]:
    hold = band.hold(x[0])
    bits = int(np.ceil(band.rows / hold))
    order = int(np.clip(np.ceil(np.log2(bits + 1)), 2, max(TAPS)))
    sequence = np.roll(pseudo_random_binary_sequence(order), int(x[2] * SEEDS))
    signal = _share(x[1]) * _filled(np.repeat(sequence, hold), band.rows)
    return signal, {"order": order, "levels": 2, "hold": hold * band.period, "share": _share(x[1])}


def _multilevel(x: Array, band: Band) -> tuple[Array, dict[str, Any]]:
    hold = band.hold(x[0])
    order = int(np.clip(np.ceil(np.log2(band.rows / hold + 1)), 2, max(TAPS)))
    levels = 3 + int(x[2] * 12.999)
    sequence = multilevel(order, levels, np.random.default_rng(int(x[3] * SEEDS)))
    signal = _share(x[1]) * _filled(np.repeat(sequence, hold), band.rows)
    return signal, {"order": order, "levels": levels, "hold": hold * band.period, "share": _share(x[1])}


def _steps(x: Array, band: Band) -> tuple[Array, dict[str, Any]]:
    hold = band.hold(x[0])
    levels = 3 + int(x[1] * 12.999)
    up = np.linspace(-1.0, 1.0, levels)
    stairs = np.concatenate([up, up[-2:0:-1]])
    stairs = np.roll(stairs, -(levels // 2))
    signal = _share(x[2]) * _filled(np.repeat(stairs, hold), band.rows)
    return signal, {"levels": levels, "hold": hold * band.period, "share": _share(x[2])}


def _sweep(x: Array, band: Band) -> tuple[Array, dict[str, Any]]:
    first, last = band.frequency(x[0]), band.frequency(x[1])
    ratio, passed = last / first, np.linspace(0.0, 1.0, band.rows)
    slope = np.log(ratio)
    cycles = passed if abs(slope) < 1e-9 else (ratio**passed - 1.0) / slope
    sizes = _share(x[2]) * (_share(x[3]) / _share(x[2])) ** passed
    signal = sizes * np.sin(2.0 * np.pi * first * band.duration * cycles)
    return signal, {
        "first_frequency": first,
        "last_frequency": last,
        "first_share": _share(x[2]),
        "last_share": _share(x[3]),
    }


def _ramps(x: Array, band: Band) -> tuple[Array, dict[str, Any]]:
    frequency = band.frequency(x[0])
    phase = np.mod(frequency * band.time + 0.25, 1.0)
    triangle = 1.0 - 4.0 * np.abs(phase - 0.5)
    passed = np.linspace(0.0, 1.0, band.rows)
    sizes = _share(x[1]) * (_share(x[2]) / _share(x[1])) ** passed
    return sizes * triangle, {"frequency": frequency, "first_share": _share(x[1]), "last_share": _share(x[2])}


def _free_decay(x: Array, band: Band) -> tuple[Array, dict[str, Any]]:
    push, free = band.hold(x[0]), 2 * band.hold(x[1])
    count = int(np.ceil(band.rows / (push + free)))
    shares = _share(x[2]) * (_share(x[3]) / _share(x[2])) ** np.linspace(0.0, 1.0, count)
    signs = np.where(np.arange(count) % 2 == 0, 1.0, -1.0)
    one = np.concatenate([np.ones(push), np.zeros(free)])
    signal = (one[None, :] * (shares * signs)[:, None]).ravel()[: band.rows]
    return signal, {
        "push": push * band.period,
        "free": free * band.period,
        "first_share": _share(x[2]),
        "last_share": _share(x[3]),
    }


FAMILIES = (
    Family("multisine", 4, _multisine),
    Family("PRBS", 3, _prbs),
    Family("multilevel PRBS", 4, _multilevel),
    Family("steps", 3, _steps),
    Family("ramps", 3, _ramps),
    Family("sweep", 4, _sweep),
    Family("free decay", 4, _free_decay),
)
