"""Limits and inputs as the files of a rig have them: in the units of its columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.number_text import plain, printable, typeset
from camid.recording.units import Conversion
from camid.simulation.declared_units import UNNAMED
from camid.simulation.model import Simulation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Column:
    """A column whose values are factor · cell + zero."""

    factor: float = 1.0
    zero: float = 0.0

    @classmethod
    def of(cls, conversion: Conversion) -> Column:
        """From what a simulation declares."""
        return cls(conversion.factor, float(conversion(np.zeros(1))[0]))

    def value(self, cell: float) -> float:
        """What the simulation takes."""
        return self.factor * cell + self.zero

    def cells(self, values: Array) -> Array:
        """What the file has, shape (N,)."""
        return np.asarray((values - self.zero) / self.factor)

    def values_of(self, limits: tuple[float, float]) -> tuple[float, float]:
        """Two limits, the lower one first."""
        first, second = self.value(limits[0]), self.value(limits[1])
        return (first, second) if self.factor > 0.0 or limits[0] > limits[1] else (second, first)


@dataclass(frozen=True)
class Columns:
    """Columns of a rig's files: names and units.

    Attributes
    ----------
    time, signal, output : str
    seconds, inputs, outputs : Column
    input_unit, output_unit : str
        What their cells are in; the name of the column where nothing is declared.
    """

    time: str
    signal: str
    output: str
    seconds: Column
    inputs: Column
    outputs: Column
    input_unit: str = "u"
    output_unit: str = "y"

    def input_text(self, value: float, *, per_second: bool = False) -> str:
        """An input, or its change in a second, as its cells have it, and its unit."""
        if per_second:
            return _with_unit(value / abs(self.inputs.factor), f"{self.input_unit}/s")
        return _with_unit(float(self.inputs.cells(np.array(value))), self.input_unit)

    def input_range(self, low: float, high: float) -> str:
        """Two inputs as their cells have them."""
        return f"{plain(float(self.inputs.cells(np.array(low))))} to {self.input_text(high)}"

    def output_text(self, value: float) -> str:
        """A reading as its cells have it, and its unit."""
        return _with_unit(float(self.outputs.cells(np.array(value))), self.output_unit)

    def output_range(self, low: float, high: float) -> str:
        """Two readings as their cells have them."""
        first, second = (low, high) if self.outputs.factor > 0.0 else (high, low)
        return f"{plain(float(self.outputs.cells(np.array(first))))} to {self.output_text(second)}"

    @classmethod
    def of(cls, simulation: Simulation) -> Columns:
        """Of the recordings that a simulation reads."""
        reading = simulation.reading
        return cls(
            simulation.time_column,
            str(simulation.input_column),
            simulation.output_column,
            Column.of(reading.time),
            Column.of(reading.input),
            Column.of(reading.output),
            *(
                printable(column) if conversion.unit in UNNAMED else typeset(str(conversion.unit))
                for column, conversion in (
                    (str(simulation.input_column or "u"), reading.input),
                    (simulation.output_column, reading.output),
                )
            ),
        )


def _with_unit(value: float, unit: str) -> str:
    """With an ordinary space: a terminal shows errors, too."""
    return f"{plain(value)} {unit}"


# Of a rig whose files are as the simulation takes them.
AS_SIMULATED = Columns("t", "u", "y", Column(), Column(), Column())
