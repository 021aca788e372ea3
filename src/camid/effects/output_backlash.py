"""Backlash behind the plant: the load rests on one side of a gap, and a reversal has to cross it first."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from camid.compiled import njit
from camid.effects.base import Array, Effect
from camid.effects.parameter import Parameter
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

# First guesses: half of the gap as a share of the largest displacement.
SHARES = (0.01, 0.05, 0.2)
# Where in the gap the drive begins.
STARTS = (-0.7, 0.7)


@njit
def _dragged(position: Array, half_width: float, place: float) -> Array:
    load = np.empty_like(position)
    value = position[0] - place * half_width
    for k in range(len(position)):
        value = min(max(value, position[k] - half_width), position[k] + half_width)
        load[k] = value
    return load


class OutputBacklash(Effect):
    """Play between the plant and what the sensor sees: a load that friction holds while the drive crosses the gap.

    The load follows the readings of the drive, so that a reversal between two of them is a little too late.
    """

    identifier = "output-backlash"
    place = "plant"
    title = "Backlash (play) behind the plant"
    equation = r"w_k = \min(\max(w_{k-1},\ y_k - b),\ y_k + b)"
    reference = "Nordin & Gutman (2002), Automatica 38, 1633-1649 (friction-driven hysteresis model)"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("half_width", "y", "half b of the gap", 0.0),)
    transforms_by_compiled_code = True
    separated_by = (SeparatingExperiment.MANY_LEVELS,)
    strength = "half_width"

    def observe(self, output: Array, time: Array) -> Array:
        """The load, from the middle of the gap."""
        return _dragged(np.ascontiguousarray(output), self.values["half_width"], 0.0)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Several shares of the largest displacement."""
        for share in SHARES:
            yield cls(half_width=share * situation.largest("position"))


class OutputBacklashFromAnywhere(OutputBacklash):
    """The same from any place in the gap."""

    parameters = (
        *OutputBacklash.parameters,
        Parameter("start", "", "where the drive begins in the gap, from −1 to 1", -1.0, 1.0, scale="one"),
    )

    def observe(self, output: Array, time: Array) -> Array:
        """The load."""
        return _dragged(np.ascontiguousarray(output), self.values["half_width"], self.values["start"])

    def simplified(self) -> OutputBacklash:
        """From the middle of the gap."""
        return OutputBacklash(half_width=self.values["half_width"])

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From either side."""
        for start in STARTS:
            yield cls(start=start, **values)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from the middle of the gap."""
        return iter(())
