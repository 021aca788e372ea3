"""The dictionary: every form that a learned law is tried as.

A form is a sum of columns φ_i(x; η) with one amplitude each. The amplitudes are linear; the few numbers η that bend the
columns (a threshold, a period, an exponent) start from a grid over the range of x that the recording visited.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

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


@dataclass(frozen=True)
class Form:
    """A form of the dictionary.

    Attributes
    ----------
    name : str
        What it is, in words.
    family : str
        Forms of one family are the same law more or less free: they are no rivals of each other.
    text : str
        With ``x`` for what it is over, and the names of amplitudes and bends.
    amplitudes : tuple of (str, float)
        Names, and powers of x by which their units divide that of the values.
    columns : callable
        φ(x, η): shapes (N,) and (b,) to (N, a).
    bends : tuple of Bend
    curved : bool
        Whether it is none of a constant and a straight line, which a coefficient may stand for.
    symmetric : bool
        Whether it is centred at zero, and needs the range to reach both sides of it.
    contains : frozenset of str
        Forms that it is, or comes as near to as one likes, with some value of its bends: where one of them says as
        much, it is no rival of it.
    """

    name: str
    family: str
    text: str
    amplitudes: tuple[tuple[str, float], ...]
    columns: Callable[[Array, Array], Array]
    bends: tuple[Bend, ...] = ()
    curved: bool = True
    symmetric: bool = False
    contains: frozenset[str] = frozenset()

    @property
    def count(self) -> int:
        """How many numbers it has."""
        return len(self.amplitudes) + len(self.bends)

    def starts(self, visited: Range) -> Iterator[Array]:
        """First guesses of the bends, shapes (b,)."""
        for values in product(*(bend.values(visited) for bend in self.bends)):
            yield np.array(values)

    def bounds(self, visited: Range) -> tuple[Array, Array]:
        """Least and largest bends, shapes (b,)."""
        limits = [bend.bounds(visited) for bend in self.bends]
        return np.array([low for low, _ in limits]), np.array([high for _, high in limits])


def _columns(*functions: Callable[[Array, Array], Array]) -> Callable[[Array, Array], Array]:
    return lambda x, bends: np.column_stack([function(x, bends) for function in functions])


def _threshold(name: str = "c") -> Bend:
    """A positive distance from zero."""
    return Bend(
        name,
        1,
        lambda r: [share * r.largest for share in (0.04, 0.08, 0.15, 0.25, 0.35, 0.5, 0.7, 0.85)],
        lambda r: (0.01 * r.largest, r.largest),
    )


def _scale(name: str = "c") -> Bend:
    """A positive length over which something bends, up to a few times the range."""
    return Bend(
        name,
        1,
        lambda r: [share * r.half for share in WIDTHS],
        lambda r: (WIDTH_BOUNDS[0] * r.half, WIDTH_BOUNDS[1] * r.half),
    )


def _centre(name: str = "x0") -> Bend:
    return Bend(name, 1, lambda r: [r.low + share * r.width for share in CENTRES], lambda r: (r.low, r.high))


def _place(name: str) -> Bend:
    return Bend(name, 1, lambda r: [r.low + share * r.width for share in PLACES], lambda r: (r.low, r.high))


def _exponent() -> Bend:
    return Bend("p", 0, lambda r: list(EXPONENTS), lambda r: EXPONENT_BOUNDS)


def _period() -> Bend:
    return Bend(
        "L",
        1,
        lambda r: [r.width / count for count in PERIODS],
        lambda r: (r.width / PERIOD_BOUNDS[1], r.width / PERIOD_BOUNDS[0]),
    )


def _beyond(above: bool) -> Bend:
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


def _bell(x: Array, b: Array) -> Array:
    return np.asarray(np.exp(-(((x - b[0]) / b[1]) ** 2)))


def _dead_zone(x: Array, c: float) -> Array:
    return np.asarray(x - np.clip(x, -c, c))


def _inverse(power: int) -> Callable[[Array, Array], Array]:
    return lambda x, b: (1.0 / (b[0] - x) ** power)[:, None]


def _exponential(sign: float) -> Callable[[Array, Array], Array]:
    return lambda x, b: np.exp(np.clip(sign * x / b[0], -60.0, 60.0))[:, None]


def _wave(order: int) -> tuple[Callable[[Array, Array], Array], ...]:
    return (
        lambda x, b: np.sin(2.0 * np.pi * order * x / b[0]),
        lambda x, b: np.cos(2.0 * np.pi * order * x / b[0]),
    )


def _power(name: str, text: str, power: float, family: str, function: Callable[[Array], Array]) -> Form:
    return Form(name, family, text, (("a", power),), _columns(lambda x, b: function(x)))


POWERS = (
    Form("straight line", "line", "a·x", (("a", 1.0),), _columns(lambda x, b: x), curved=False),
    _power("absolute value", "a·|x|", 1.0, "even power", np.abs),
    _power("square", "a·x²", 2.0, "even power", np.square),
    _power("fourth power", "a·x⁴", 4.0, "even power", lambda x: x**4),
    _power("root of the size", "a·√|x/X|", 0.0, "even power", lambda x: np.sqrt(np.abs(x))),
    _power("sign", "a·sign(x)", 0.0, "odd power", np.sign),
    _power("square with the sign", "a·x·|x|", 2.0, "odd power", lambda x: x * np.abs(x)),
    _power("cube", "a·x³", 3.0, "odd power", lambda x: x**3),
    _power("fifth power", "a·x⁵", 5.0, "odd power", lambda x: x**5),
    _power("root with the sign", "a·sign(x)·√|x/X|", 0.0, "odd power", lambda x: np.sign(x) * np.sqrt(np.abs(x))),
    Form(
        "power with the sign",
        "odd power",
        "a·sign(x)·|x/X|^p",
        (("a", 0.0),),
        _columns(lambda x, b: np.sign(x) * np.abs(x) ** b[0]),
        (_exponent(),),
        symmetric=True,
    ),
    Form(
        "power of the size",
        "even power",
        "a·|x/X|^p",
        (("a", 0.0),),
        _columns(lambda x, b: np.abs(x) ** b[0]),
        (_exponent(),),
        symmetric=True,
    ),
    Form(
        "square and cube",
        "polynomial",
        "a·x² + b·x³",
        (("a", 2.0), ("b", 3.0)),
        _columns(lambda x, b: x**2, lambda x, b: x**3),
    ),
    Form(
        "cube and fifth power",
        "polynomial",
        "a·x³ + b·x⁵",
        (("a", 3.0), ("b", 5.0)),
        _columns(lambda x, b: x**3, lambda x, b: x**5),
    ),
)
# Forms of a fixed exponent.
FIXED_POWERS = {
    0.0: ("sign",),
    0.5: ("root of the size", "root with the sign"),
    1.0: ("absolute value",),
    2.0: ("square", "square with the sign"),
    3.0: ("cube",),
    4.0: ("fourth power",),
    5.0: ("fifth power",),
}
WAVES = (
    Form("sine", "sine", "a·sin(2π·x/L) + b·cos(2π·x/L)", (("a", 0.0), ("b", 0.0)), _columns(*_wave(1)), (_period(),)),
    Form(
        "sine with a second harmonic",
        "sine",
        "a·sin(2π·x/L) + b·cos(2π·x/L) + c·sin(4π·x/L) + d·cos(4π·x/L)",
        (("a", 0.0), ("b", 0.0), ("c", 0.0), ("d", 0.0)),
        _columns(*_wave(1), *_wave(2)),
        (_period(),),
    ),
)
BUMPS = (
    Form("bump", "bump", "a·exp(−((x − x0)/c)²)", (("a", 0.0),), _columns(_bell), (_centre(), _scale())),
    Form(
        "pull to a point",
        "pull to a point",
        "a·(x − x0)/c·exp(−((x − x0)/c)²)",
        (("a", 0.0),),
        _columns(lambda x, b: (x - b[0]) / b[1] * _bell(x, b)),
        (_centre(), _scale()),
    ),
    Form(
        "rational bump",
        "rational bump",
        "a/(1 + ((x − x0)/c)²)",
        (("a", 0.0),),
        _columns(lambda x, b: 1.0 / (1.0 + ((x - b[0]) / b[1]) ** 2)),
        (_centre(), _scale()),
    ),
)
GROWTH = (
    Form("exponential", "exponential", "a·exp(x/c)", (("a", 0.0),), _exponential(1.0), (_scale(),)),
    Form("exponential", "exponential", "a·exp(−x/c)", (("a", 0.0),), _exponential(-1.0), (_scale(),)),
    *(
        Form(
            "inverse square of a distance" if power == 2 else "inverse of a distance",
            f"inverse distance {power}",
            "a/(x0 − x)" + ("²" if power == 2 else ""),
            (("a", -float(power)),),
            _inverse(power),
            (_beyond(above),),
        )
        for power in (1, 2)
        for above in (True, False)
    ),
)
SATURATION = (
    Form(
        "peak at a point",
        "peak",
        "a·x/(1 + (x/c)²)",
        (("a", 1.0),),
        _columns(lambda x, b: x / (1.0 + (x / b[0]) ** 2)),
        (_scale(),),
        symmetric=True,
    ),
    Form(
        "saturation, tanh",
        "tanh",
        "a·tanh(x/c)",
        (("a", 0.0),),
        _columns(lambda x, b: np.tanh(x / b[0])),
        (_scale(),),
        symmetric=True,
    ),
    Form(
        "saturation, rational",
        "slow saturation",
        "a·x/(1 + |x|/c)",
        (("a", 1.0),),
        _columns(lambda x, b: x / (1.0 + np.abs(x) / b[0])),
        (_scale(),),
        symmetric=True,
    ),
    Form(
        "smooth step",
        "smooth step",
        "a·tanh((x − x0)/c)",
        (("a", 0.0),),
        _columns(lambda x, b: np.tanh((x - b[0]) / b[1])),
        (_centre(), _scale()),
    ),
    Form(
        "step",
        "smooth step",
        "a·sign(x − x0)",
        (("a", 0.0),),
        _columns(lambda x, b: np.sign(x - b[0])),
        (_place("x0"),),
    ),
)
KINKS = (
    Form(
        "dead zone",
        "kinks",
        "a·dead_zone(x, c)",
        (("a", 1.0),),
        _columns(lambda x, b: _dead_zone(x, b[0])),
        (_threshold(),),
        symmetric=True,
    ),
    Form(
        "kink",
        "kink",
        "a·max(x − c, 0)",
        (("a", 1.0),),
        _columns(lambda x, b: np.maximum(x - b[0], 0.0)),
        (_place("c"),),
    ),
    Form(
        "two kinks",
        "kinks",
        "a·max(x − c, 0) + b·min(x − d, 0)",
        (("a", 1.0), ("b", 1.0)),
        _columns(lambda x, b: np.maximum(x - b[0], 0.0), lambda x, b: np.minimum(x - b[1], 0.0)),
        (_centre("c"), _centre("d")),
    ),
)
_CONTAINED = {
    "square and cube": ("square", "cube"),
    "cube and fifth power": ("cube", "fifth power"),
    "sine": ("square", "cube"),
    "bump": ("square",),
    "pull to a point": ("cube",),
    "rational bump": ("square",),
    "exponential": ("square", "straight line"),
    "inverse of a distance": ("square", "straight line"),
    "inverse square of a distance": ("square", "straight line"),
    "peak at a point": ("cube", "straight line"),
    "saturation, tanh": ("sign", "cube", "straight line"),
    "saturation, rational": ("sign", "square with the sign", "straight line"),
    "smooth step": ("sign", "step", "saturation, tanh", "cube", "straight line"),
    "step": ("sign",),
    "dead zone": ("sign",),
    "kink": ("absolute value", "straight line"),
    "two kinks": ("absolute value", "kink", "dead zone", "straight line"),
}
_EVERY = (*POWERS, *WAVES, *BUMPS, *GROWTH, *SATURATION, *KINKS)
FORMS = tuple(replace(form, contains=frozenset(_CONTAINED.get(form.name, ()))) for form in _EVERY)
