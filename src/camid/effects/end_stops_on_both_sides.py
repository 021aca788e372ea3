"""Stops at both ends of a way, or play around a spring: the body is free, or held softly, between them."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt
from typing import Any

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.actuator import InputBias
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.extent import Extent
from camid.effects.parameter import Parameter
from camid.effects.plant_force import mobility, motion_sign, static_stiffness
from camid.effects.situation import Situation
from camid.effects.stiffness import EndStop

# Where stops are at first, in the largest and the least position, and how stiff they are, in the plant's own stiffness.
SHARES = (0.15, 0.4, 0.6, 0.8)
FACTORS = (0.5, 10.0)
# Way between the stops, as a share of that of a recording, below which they are a spring.
LEAST_GAP = 0.02


class EndStopsOnBothSides(EndStop):
    """A stop at each end of the way."""

    title = "End stops on both sides"
    equation = (
        r"f = k_s\,\max(y - y_s,\ 0) + k_o\,\min(y - y_o,\ 0)\ \ (y_o < y_s);\quad \mathrm{mirrored\ for}\ y_o > y_s"
    )
    reference = "Shaw & Holmes (1983), J. Sound Vib. 90, 129-155"
    parameters = (
        *EndStop.parameters,
        Parameter("opposite", "y", "start y_o of the contact on the other side"),
        Parameter("opposite_stiffness", "u/y", "stiffness k_o of the contact on the other side", 0.0),
    )

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        side = 1.0 if values[0] >= values[2] else -1.0
        beyond, below = side * (position - values[0]), side * (position - values[2])
        return side * (values[1] * max(beyond, 0.0) + values[3] * min(below, 0.0))

    @compiled
    def switch(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return (position - values[0]) * (position - values[2])

    def force_values(self, plant: TransferFunction) -> list[float]:
        """The parameters, both stiffnesses with the sign of the plant's gain."""
        position, stiffness, opposite, other = self.vector.tolist()
        sign = motion_sign(plant)
        return [position, sign * stiffness, opposite, sign * other]

    def frequency(self, plant: TransferFunction) -> float:
        """Of the body on the stiffer stop."""
        return sqrt(mobility(plant) * max(self.values["stiffness"], self.values["opposite_stiffness"]))

    def is_plausible(self, extent: Extent) -> bool:
        """Whether the body can go any way between them: without one they are a spring, as the plant has it already."""
        return bool(self._gap > LEAST_GAP * extent.span) and super().is_plausible(extent)

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """Of a spring about another zero than the sensor's a constant force: the rest of it the plant has already."""
        if self._gap > LEAST_GAP * float(np.ptp(situation.position)):
            return ()
        position, stiffness, opposite, other = self.vector.tolist()
        return (InputBias(bias=0.5 * motion_sign(situation.plant) * (stiffness * position + other * opposite)),)

    @property
    def _gap(self) -> float:
        return abs(float(self.values["position"] - self.values["opposite"]))

    def scaled(self, factor: float) -> EndStopsOnBothSides:
        """Both as much stiffer."""
        stiffer = {name: factor * self.values[name] for name in ("stiffness", "opposite_stiffness")}
        return type(self)(**{**self.values, **stiffer})

    def simplified(self) -> EndStop:
        """The first of them alone."""
        return EndStop(position=self.values["position"], stiffness=self.values["stiffness"])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """Another detail of the first stop alone: what it does otherwise, the other one may have made up for."""
        alone = self.simplified().values
        others = [law for law in EndStop.finer_laws if law is not EndStopsOnBothSides]
        loss = 0.5 / (float(np.std(situation.velocity)) or 1.0)
        kept = [start for law in others for start in law.starts(situation, **alone)]
        both = {"loss", "power"}
        kept += [law(**alone, loss=loss, power=1.5) for law in others if both <= {p.name for p in law.parameters}]
        return tuple(kept)

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From another one of the same stiffness, near the middle or near the end, on the other side."""
        ends = float(np.max(situation.position)), float(np.min(situation.position))
        other = ends[1] if values["position"] >= 0.5 * sum(ends) else ends[0]
        for share in SHARES[1::2]:
            yield cls(**{"opposite": share * other, "opposite_stiffness": values["stiffness"], **values})

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Near the middle and near the ends, soft and hard."""
        largest = situation.largest("signal") / situation.largest("position")
        stiffness = abs(static_stiffness(situation.plant)) or largest
        high, low = float(np.max(situation.position)), float(np.min(situation.position))
        for share in SHARES if low < 0.0 < high else ():
            for factor in FACTORS:
                each = factor * stiffness
                yield cls(position=share * high, stiffness=each, opposite=share * low, opposite_stiffness=each)
