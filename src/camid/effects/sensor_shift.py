"""A camera, or what it stands on, that is knocked: from then on it reads all positions elsewhere."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import sqrt
from typing import Any

import numpy as np

from camid.effects.base import Array, Effect
from camid.effects.parameter import Parameter
from camid.effects.sensor_drift import SIZE, SensorDrift
from camid.effects.situation import Situation

# Rows before and after a time whose means are compared, where other structure of the residual is slower.
ROWS = 5


class SensorShift(SensorDrift):
    """The zero of the image jumps, once."""

    title = "Shift of the measurement"
    equation = r"w = y + s\ \ (t \geq t_0),\quad w = y\ \ (t < t_0)"
    reference = "Basseville & Nikiforov (1993), Detection of Abrupt Changes, section 2.6"
    parameters = (Parameter("size", "y", "shift s"), Parameter("time", "s", "time t_0", scale="period"))
    strength = "size"
    trials = "frames"

    def observe(self, output: Array, time: Array) -> Array:
        """Add the shift: to the first frame after it the share that makes the time of it a continuous number."""
        period = time[1] - time[0] if len(time) > 1 else 1.0
        return output + self.values["size"] * np.clip((time - self.values["time"]) / period, 0.0, 1.0)

    def least_deviations(self, period: float) -> Mapping[str, float]:
        """Of the time: a knock at any moment after the last frame before it leaves the same readings."""
        return {"time": period / sqrt(3.0)}

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """Where the residual jumps, whatever drift was found."""
        yield from cls.candidates(situation)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Where a step in the residual, all of it or that of a few rows alone, explains most."""
        size = SIZE * situation.largest("position")
        for row in {_of_all_rows(situation.residual), _of_a_few_rows(situation.residual)} - {0}:
            yield cls(size=size, time=float(situation.time[row - 1]))

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """None: a jump is one however long the clock has run."""
        return None


def _of_all_rows(residual: Array) -> int:
    """First row of the step that explains most of a residual; 0 of too few rows."""
    count = len(residual)
    before = np.arange(1, count)
    gained = np.cumsum(residual - np.mean(residual))[:-1] ** 2 / (before * (count - before))
    return int(np.argmax(gained)) + 1 if count > 2 * ROWS else 0


def _of_a_few_rows(residual: Array) -> int:
    """First row after which a few rows differ most from as many before it; 0 of too few rows."""
    if len(residual) <= 2 * ROWS:
        return 0
    means = np.convolve(residual, np.full(ROWS, 1.0 / ROWS), mode="valid")
    return int(np.argmax(np.abs(means[ROWS:] - means[:-ROWS]))) + ROWS
