"""The numbers that bend a form: where they are tried first, and what they may be, over the range of a recording."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

# Exponents that are tried and allowed, where the exponent is free.
EXPONENTS = (0.3, 0.5, 0.75, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0)
EXPONENT_BOUNDS = (0.1, 9.0)
# Widths and centres, as shares of half the range and of the range; periods that the range holds.
WIDTHS = (0.04, 0.08, 0.15, 0.25, 0.4, 0.65, 1.0, 1.6)
WIDTH_BOUNDS = (0.01, 2.5)
CENTRES = tuple(np.linspace(0.06, 0.94, 19))
# The same where nothing but the place bends the form.
PLACES = tuple(np.linspace(0.03, 0.97, 63))
PERIODS = tuple(np.arange(1.5, 14.01, 0.125))
PERIOD_BOUNDS = (1.5, 15.0)
# Where a force grows towards a point beyond the range: its distance from the end, in ranges.
DISTANCES = (0.03, 0.08, 0.2, 0.4, 0.8)
DISTANCE_BOUNDS = (0.005, 1.5)


@dataclass(frozen=True)
class Range:
    """The values of x that the recording visited."""

    low: float
    high: float

    @property
    def width(self) -> float:
        """From the lowest to the highest."""
        return self.high - self.low

    @property
    def half(self) -> float:
        """Half the width: what thresholds and widths of bumps are measured by."""
        return 0.5 * self.width

    @property
    def largest(self) -> float:
        """The largest |x|: what thresholds about zero are measured by."""
        return max(abs(self.low), abs(self.high))


@dataclass(frozen=True)
class Bend:
    """A number that bends a form's columns.

    Attributes
    ----------
    name : str
        As the formula writes it.
    power : int
        Its unit is that of x to this power.
    values : callable
        First guesses on a range.
    bounds : callable
        Least and largest value on a range.
    """

    name: str
    power: int
    values: Callable[[Range], list[float]]
    bounds: Callable[[Range], tuple[float, float]]


def threshold(name: str = "c") -> Bend:
    """A positive distance from zero."""
    return Bend(
        name,
        1,
        lambda r: [share * r.largest for share in (0.04, 0.08, 0.15, 0.25, 0.35, 0.5, 0.7, 0.85)],
        lambda r: (0.01 * r.largest, r.largest),
    )


def scale(name: str = "c") -> Bend:
    """A positive length over which something bends, up to a few times the range."""
    return Bend(
        name,
        1,
        lambda r: [share * r.half for share in WIDTHS],
        lambda r: (WIDTH_BOUNDS[0] * r.half, WIDTH_BOUNDS[1] * r.half),
    )


def centre(name: str = "x0") -> Bend:
    """A place within the range, beside a scale."""
    return Bend(name, 1, lambda r: [r.low + share * r.width for share in CENTRES], lambda r: (r.low, r.high))


def place(name: str) -> Bend:
    """A place within the range, where nothing else bends the form."""
    return Bend(name, 1, lambda r: [r.low + share * r.width for share in PLACES], lambda r: (r.low, r.high))


def exponent() -> Bend:
    """An exponent."""
    return Bend("p", 0, lambda r: list(EXPONENTS), lambda r: EXPONENT_BOUNDS)


def period() -> Bend:
    """The length after which a form returns."""
    return Bend(
        "L",
        1,
        lambda r: [r.width / count for count in PERIODS],
        lambda r: (r.width / PERIOD_BOUNDS[1], r.width / PERIOD_BOUNDS[0]),
    )


def beyond(above: bool) -> Bend:
    """A point beyond one end of the range."""
    if above:
        return Bend(
            "x0",
            1,
            lambda r: [r.high + share * r.width for share in DISTANCES],
            lambda r: (r.high + DISTANCE_BOUNDS[0] * r.width, r.high + DISTANCE_BOUNDS[1] * r.width),
        )
    return Bend(
        "x0",
        1,
        lambda r: [r.low - share * r.width for share in DISTANCES],
        lambda r: (r.low - DISTANCE_BOUNDS[1] * r.width, r.low - DISTANCE_BOUNDS[0] * r.width),
    )
