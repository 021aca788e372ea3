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

from camid.diagnosis.laws.formula.bends import Bend, Range, beyond, centre, exponent, period, place, scale, threshold

Array = NDArray[np.float64]


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

    def __reduce__(self) -> tuple[Callable[..., Form], tuple[int, int]]:
        # Its functions have no name to be pickled by, and its own name is not its alone.
        places = ((group, i) for group, forms in enumerate((FORMS, POWERS)) for i, form in enumerate(forms))
        return form_at, next(place for place in places if form_at(*place) is self)

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
        (exponent(),),
        symmetric=True,
    ),
    Form(
        "power of the size",
        "even power",
        "a·|x/X|^p",
        (("a", 0.0),),
        _columns(lambda x, b: np.abs(x) ** b[0]),
        (exponent(),),
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
    Form("sine", "sine", "a·sin(2π·x/L) + b·cos(2π·x/L)", (("a", 0.0), ("b", 0.0)), _columns(*_wave(1)), (period(),)),
    Form(
        "sine with a second harmonic",
        "sine",
        "a·sin(2π·x/L) + b·cos(2π·x/L) + c·sin(4π·x/L) + d·cos(4π·x/L)",
        (("a", 0.0), ("b", 0.0), ("c", 0.0), ("d", 0.0)),
        _columns(*_wave(1), *_wave(2)),
        (period(),),
    ),
)
BUMPS = (
    Form("bump", "bump", "a·exp(−((x − x0)/c)²)", (("a", 0.0),), _columns(_bell), (centre(), scale())),
    Form(
        "pull to a point",
        "pull to a point",
        "a·(x − x0)/c·exp(−((x − x0)/c)²)",
        (("a", 0.0),),
        _columns(lambda x, b: (x - b[0]) / b[1] * _bell(x, b)),
        (centre(), scale()),
    ),
    Form(
        "rational bump",
        "rational bump",
        "a/(1 + ((x − x0)/c)²)",
        (("a", 0.0),),
        _columns(lambda x, b: 1.0 / (1.0 + ((x - b[0]) / b[1]) ** 2)),
        (centre(), scale()),
    ),
)
GROWTH = (
    Form("exponential", "exponential", "a·exp(x/c)", (("a", 0.0),), _exponential(1.0), (scale(),)),
    Form("exponential", "exponential", "a·exp(−x/c)", (("a", 0.0),), _exponential(-1.0), (scale(),)),
    *(
        Form(
            "inverse square of a distance" if power == 2 else "inverse of a distance",
            f"inverse distance {power}",
            "a/(x0 − x)" + ("²" if power == 2 else ""),
            (("a", -float(power)),),
            _inverse(power),
            (beyond(above),),
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
        (scale(),),
        symmetric=True,
    ),
    Form(
        "saturation, tanh",
        "tanh",
        "a·tanh(x/c)",
        (("a", 0.0),),
        _columns(lambda x, b: np.tanh(x / b[0])),
        (scale(),),
        symmetric=True,
    ),
    Form(
        "saturation, rational",
        "slow saturation",
        "a·x/(1 + |x|/c)",
        (("a", 1.0),),
        _columns(lambda x, b: x / (1.0 + np.abs(x) / b[0])),
        (scale(),),
        symmetric=True,
    ),
    Form(
        "smooth step",
        "smooth step",
        "a·tanh((x − x0)/c)",
        (("a", 0.0),),
        _columns(lambda x, b: np.tanh((x - b[0]) / b[1])),
        (centre(), scale()),
    ),
    Form(
        "step",
        "smooth step",
        "a·sign(x − x0)",
        (("a", 0.0),),
        _columns(lambda x, b: np.sign(x - b[0])),
        (place("x0"),),
    ),
)
KINKS = (
    Form(
        "dead zone",
        "kinks",
        "a·dead_zone(x, c)",
        (("a", 1.0),),
        _columns(lambda x, b: _dead_zone(x, b[0])),
        (threshold(),),
        symmetric=True,
    ),
    Form(
        "kink",
        "kink",
        "a·max(x − c, 0)",
        (("a", 1.0),),
        _columns(lambda x, b: np.maximum(x - b[0], 0.0)),
        (place("c"),),
    ),
    Form(
        "two kinks",
        "kinks",
        "a·max(x − c, 0) + b·min(x − d, 0)",
        (("a", 1.0), ("b", 1.0)),
        _columns(lambda x, b: np.maximum(x - b[0], 0.0), lambda x, b: np.minimum(x - b[1], 0.0)),
        (centre("c"), centre("d")),
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


def form_at(group: int, place: int) -> Form:
    """A form of the dictionary, or of the powers as they were before it was put together."""
    return (FORMS, POWERS)[group][place]
