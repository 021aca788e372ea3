"""Units of columns: factors to SI by pint, and the conversion of cells to values that a simulation declares."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError, nearest_match

Array = NDArray[np.float64]

# What the nearest match of an unknown unit is looked for in: the whole registry of pint would offer barns and furlongs.
COMMON_UNITS = (
    "s ms us ns min h second millisecond m mm cm um km meter millimeter inch pixel rad mrad deg turn radian degree "
    "rad/s deg/s rpm Hz m/s mm/s m/s^2 N mN kN newton N*m V mV kV volt A mA ampere Pa kPa bar kg g percent"
)


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()


# The parser takes minutes for longer texts, and for ever to raise a power to a power.
LONGEST_UNIT = 60
POWER_OF_A_POWER = re.compile(r"(?:\^|\*\*)\s*[^*/·\s]*\s*(?:\^|\*\*)|\d{5}")


@cache
def si_factor(unit: str, where: str, dimension: str | None = None) -> tuple[float, float]:
    """Factor and offset that bring a number in a unit to SI: value = factor · number + offset.

    Parameters
    ----------
    unit : str
        As pint reads it: ``mm``, ``deg``, ``N*m``, ``m/s^2``. A pixel stays a pixel.
    where : str
        Place for messages.
    dimension : str, optional
        ``[time]`` and the like; other kinds of units are refused.

    Raises
    ------
    InputError
        If there is no such unit or it is of another kind.
    """
    import pint

    if len(unit) > LONGEST_UNIT or POWER_OF_A_POWER.search(unit):
        shown = unit if len(unit) <= LONGEST_UNIT else f"{unit[:LONGEST_UNIT]}…"
        raise InputError(f"'{shown}' is no unit", where=where, hint=f"common ones are {COMMON_UNITS}")
    registry = _registry()
    try:
        # For pint, px is the pixel of style sheets, 1/96 inch.
        parsed = registry.parse_units(re.sub(r"\bpx\b", "pixel", unit))
        zero, one = (float(registry.Quantity(v, parsed).to_base_units().magnitude) for v in (0.0, 1.0))
    except pint.UndefinedUnitError:
        raise InputError(
            f"unknown unit '{unit}'", where=where, hint=nearest_match(unit, COMMON_UNITS.split())
        ) from None
    except Exception as error:  # the parser lets errors of many kinds through, such as those of Python's tokenizer
        problem = " ".join(str(error).split())
        raise InputError(
            f"'{unit}' is not a unit ({problem})", where=where, hint="write it like mm, deg or m/s^2"
        ) from None
    if dimension is not None and dict(parsed.dimensionality) != {dimension: 1}:
        kind = dimension.strip("[]")
        raise InputError(f"'{unit}' is not a unit of {kind}", where=where, hint=f"give a unit of {kind}, such as ms")
    return one - zero, zero


@cache
def si_name(unit: str) -> str:
    """The SI unit that :func:`si_factor` brings numbers in a unit to, as people write it; that of mm is m."""
    # What is SI already keeps its name: V is not kg·m²/s³/A. The pixel of a header is pint's, too.
    if si_factor(unit, "") == (1.0, 0.0):
        return unit
    parsed = _registry().parse_units(re.sub(r"\bpx\b", "pixel", unit))
    for name in ("V", "N", "N*m", "A", "W", "Pa", "J", "T", "F", "C"):
        if _registry().parse_units(name).dimensionality == parsed.dimensionality:
            return name
    return f"{(1.0 * parsed).to_base_units().units:~C}".replace("**", "^")


def unit_in_header(header: str) -> tuple[str, str | None]:
    """Name and unit of a header such as ``angle [deg]`` or ``u (V)``; no unit where what is in brackets is none.

    Parameters
    ----------
    header : str

    Returns
    -------
    name : str
        Without the unit.
    unit : str or None
        As pint reads it.
    """
    match = re.fullmatch(r"\s*(.*\S)\s*[\[(]\s*([^\[\]()]*[^\W\d][^\[\]()]*|%|°)\s*[\])]\s*", header)
    return (match[1], match[2].strip()) if match and is_unit(match[2].strip()) else (header, None)


def with_bracketed_unit(header: str) -> str:
    """A header such as ``t/ms`` (a quantity over its unit, ISO 80000-1) as ``t [ms]``; any other as it is.

    Only common units are taken for one, and ``m/s`` for a name.
    """
    quantity, _, unit = header.partition("/")
    quantity, unit = quantity.strip(), unit.strip()
    common = {*COMMON_UNITS.split(), "px", "%", "°"}
    if not quantity or quantity in common or unit.strip("()") not in common:
        return header
    return f"{quantity} [{unit.strip('()')}]"


@cache
def is_unit(text: str, dimension: str | None = None) -> bool:
    """Whether pint knows a unit of this name, and of this dimension, such as ``[time]``."""
    if not text.strip():
        return False
    try:
        si_factor(text, "", dimension)
    except InputError:
        return False
    return True


@dataclass(frozen=True)
class Conversion:
    """From the cells of a column to numbers in SI units: value = scale · (cell in SI units) + offset.

    Attributes
    ----------
    unit : str or None
        Of the cells; None: they are in SI units.
    scale, offset : float
        In SI units.
    where : str
        Place in the simulation, for messages.
    """

    unit: str | None = None
    scale: float = 1.0
    offset: float = 0.0
    where: str = field(default="simulation", compare=False)

    def __call__(self, cells: Array) -> Array:
        """Values of cells.

        Raises
        ------
        InputError
            If the unit is unknown, or the values are zero or not finite because of the scale.
        """
        factor, base = (1.0, 0.0) if self.unit is None else si_factor(self.unit, f"{self.where}.unit")
        if (factor, base, self.scale, self.offset) == (1.0, 0.0, 1.0, 0.0):
            return cells
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            scaled = self.scale * (factor * cells + base)
            values = scaled + self.offset
        known = np.isfinite(cells)
        if not np.all(np.isfinite(values[known])):
            raise InputError(f"scale = {self.scale:g} makes numbers that are not finite", where=self.where)
        if np.any(cells[known]) and not np.any(scaled[known]):
            raise InputError(f"scale = {self.scale:g} makes every number zero", where=self.where)
        return values

    @property
    def factor(self) -> float:
        """Value of a cell that is larger by one.

        Raises
        ------
        InputError
            If the unit is unknown.
        """
        return self.scale * (1.0 if self.unit is None else si_factor(self.unit, f"{self.where}.unit")[0])

    def to_mapping(self) -> dict[str, Any]:
        """Part of the file: what differs from the default."""
        given = {"unit": self.unit, "scale": self.scale, "offset": self.offset}
        return {key: value for key, value in given.items() if value != getattr(Conversion(), key)}
