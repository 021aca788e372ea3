"""The units in which people read results: those that a simulation declares for its columns.

Files and the fields of JSON hold SI units. What a person reads (terminal, page, pictures) is in the unit that a column
declares, and the unit is written; docs/units.md states the rule.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from camid.number_text import plain, printable, typeset, unit_text
from camid.recording.units import Conversion, si_factor, si_name

# What declares that there is none.
UNNAMED = {None, "dimensionless", "1", "-"}


@dataclass(frozen=True)
class SignalUnit:
    """How the values of a signal are shown.

    Attributes
    ----------
    letter : {"u", "y"}
        What stands for its unit in those of parameters.
    column : str or None
        Its name; None where there is no such signal.
    unit : str or None
        What its values are shown in; None where the simulation declares none.
    factor : float
        Value in SI units of one such unit.
    scale : float
        Value of a cell that is larger by one, where that is not one unit of what is shown.
    si : str or None
        Name of the SI unit; None where the simulation does not say what the column holds, or scales it to something
        else.
    """

    letter: str
    column: str | None
    unit: str | None = None
    factor: float = 1.0
    scale: float = 1.0
    si: str | None = None

    @classmethod
    def of(cls, letter: str, column: str | None, conversion: Conversion) -> SignalUnit:
        """Of a column and its conversion; a scale other than one makes another quantity, whose unit nobody names."""
        unit = conversion.unit
        if column is None or unit is None or unit in UNNAMED or abs(conversion.scale) != 1.0:
            return cls(letter, column, scale=conversion.factor)
        factor, zero = si_factor(unit, conversion.where)
        si = si_name(unit)
        # What has a zero of its own, as degrees Celsius have, is shown in SI units: differences and values differ.
        return cls(letter, column, si, si=si) if zero else cls(letter, column, unit, factor, si=si)

    @property
    def symbol(self) -> str:
        """What stands for it in units: the declared one, the column's name, or the letter where values are scaled."""
        if self.unit is not None:
            return typeset(self.unit)
        named = self.column is not None and self.scale == 1.0
        return printable(str(self.column)) if named else self.letter

    @property
    def label(self) -> str:
        """For an axis: the name and, where one is declared, the unit."""
        return self.symbol if self.unit is None else f"{printable(str(self.column))}, {self.symbol}"

    @property
    def explained(self) -> str | None:
        """What the symbol means, where it is neither the name of a column nor a unit: ``u = 35.15 · vir``."""
        if self.column is None:
            return f"{self.letter} = the input of the plant, which nothing drives" if self.letter == "u" else None
        if self.unit is not None or self.scale == 1.0:
            return None
        return f"{self.symbol} = {plain(self.scale, 6)} · {printable(self.column)}"

    def to_mapping(self) -> dict[str, Any]:
        """Part of JSON."""
        return {"column": self.column, "unit": self.si, "declared_unit": self.unit, "declared_in_si": self.factor}


@dataclass(frozen=True)
class DeclaredUnits:
    """Units of input and output, and of everything whose unit is made of those and of seconds."""

    input: SignalUnit
    output: SignalUnit

    @property
    def signals(self) -> dict[str, SignalUnit]:
        """By letter."""
        return {"u": self.input, "y": self.output}

    @property
    def explained(self) -> list[str]:
        """What symbols mean that are neither units nor names of columns."""
        return [text for text in (self.input.explained, self.output.explained) if text is not None]

    @property
    def sentence(self) -> str:
        """What units are written in, for a page: declared ones, and the names of columns that declare none."""
        signals = [signal for signal in (self.input, self.output) if signal.column is not None]
        declared = [f"{printable(str(s.column))} in {s.symbol}" for s in signals if s.unit is not None]
        named = [s.symbol for s in signals if s.unit is None and s.explained is None]
        said = f"Values are in the units that the simulation declares: {', '.join(declared)}. " if declared else ""
        stand = " and ".join(f"{name} stands for the unit of column {name}" for name in named)
        return said + (f"Units are written with the names of columns: {stand}." if named else "")

    def text(self, unit: str | None) -> str:
        """A unit in u, y and s as people read it: ``u/y^3`` becomes ``N/mm³``; empty for a pure number."""
        return unit_text(unit, _within(self.input, alone=unit == "u"), _within(self.output, alone=unit == "y"))

    def factor(self, unit: str | None) -> float:
        """SI value of one of a unit in u, y and s, as :meth:`text` writes it."""
        above, _, below = (unit or "").replace("**", "^").partition("/")
        found = 1.0
        for part, sign in ((above, 1.0), (below, -1.0)):
            for letter, power in re.findall(r"(?<![\w%])([uy])(?![\w%])(?:\^\(?(-?[\d.]+))?", part):
                found *= self.signals[letter].factor ** (sign * float(power or 1.0))
        return found

    def shown(self, value: Any, unit: str | None) -> Any:
        """A number, list or array in SI units as it is shown; None, texts and truth values stay."""
        factor = self.factor(unit)
        if value is None or isinstance(value, str | bool) or factor == 1.0:
            return value
        if isinstance(value, np.ndarray):
            return value / factor
        return [self.shown(v, unit) for v in value] if isinstance(value, Sequence) else float(value) / factor

    def declared(self, value: Any, deviation: Any, unit: str | None) -> dict[str, Any]:
        """Part of JSON: value, standard deviation and unit as people read them."""
        return {"value": self.shown(value, unit), "std": self.shown(deviation, unit), "unit": self.text(unit)}

    def to_mapping(self) -> dict[str, Any]:
        """Part of JSON: what u and y in units are; values are in ``unit``, and ``declared`` ones in the other."""
        return {letter: signal.to_mapping() for letter, signal in self.signals.items() if signal.column is not None}


def _within(signal: SignalUnit, *, alone: bool = False) -> str:
    """The symbol within a larger unit: in brackets where it has several parts."""
    symbol = signal.symbol
    if signal.unit is None:
        return symbol if re.fullmatch(r"\w+", symbol) else f"[{symbol}]"
    return symbol if alone or not re.search(r"[\s/·*^()]", symbol) else f"({symbol})"


# Where no simulation declares any.
IN_U_AND_Y = DeclaredUnits(SignalUnit("u", "u"), SignalUnit("y", "y"))
