"""End stop of two curved bodies, which stiffens as they are pressed together."""

from __future__ import annotations

from collections.abc import Iterator
from math import copysign, sqrt
from typing import Any

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.damped_end_stop import DampedEndStop
from camid.effects.end_stop_of_any_power import EndStopOfAnyPower
from camid.effects.overflow_over_weir import STEEPEST_AT, OverflowOverWeir
from camid.effects.parameter import Parameter
from camid.effects.plant_force import mobility
from camid.effects.situation import Situation
from camid.effects.stiffness import EndStop

# Depths at which a contact is as stiff as the stop with a straight law that it is started from, as shares of the
# largest one.
DEPTHS = (0.3, 0.9)
# Largest depth, as a share of the largest displacement, below which a stop is hard: how its force grows is not seen.
LEAST_DEPTH = 0.01
# The same of the position of a stop where the straight law in its place is as stiff.
TYPICAL_DEPTH = 0.2


class HertzEndStop(EndStop):
    """A stop whose force grows with the power 3/2 of the depth, as that of two curved elastic bodies does."""

    title = "End stop with a Hertz contact"
    equation = r"f = k_h\,\max(y - y_s,\ 0)^{3/2}\ \ (y_s > 0),\quad f = -k_h\,\max(y_s - y,\ 0)^{3/2}\ \ (y_s < 0)"
    reference = "Johnson (1985), Contact Mechanics, section 4.2 (Hertz 1882)"
    parameters = (
        Parameter("position", "y", "start y_s of the contact"),
        Parameter("hertz", "u/y^1.5", "stiffness k_h of the contact", 0.0),
    )
    strength = "hertz"

    # A weir is the same law, of another thing.
    force = OverflowOverWeir.force

    def frequency(self, plant: TransferFunction) -> float:
        """Of the body deep in the stop."""
        deep = STEEPEST_AT * abs(self.values["position"])
        return sqrt(mobility(plant) * 1.5 * self.values["hertz"] * sqrt(deep))

    def simplified(self) -> EndStop:
        """The straight law that is as stiff, and pushes as hard, at a depth."""
        position, depth = self.values["position"], TYPICAL_DEPTH * abs(self.values["position"])
        return EndStop(
            position=position + copysign(depth / 3.0, position), stiffness=1.5 * self.values["hertz"] * sqrt(depth)
        )

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """Another power, and a straight law that takes energy, which shows as well as the power."""
        position, hertz = self.values["position"], self.values["hertz"]
        power = EndStopOfAnyPower(position=position, stiffness=hertz * sqrt(abs(position)), power=1.5)
        return (power, *DampedEndStop.starts(situation, **self.simplified().values))

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """A storage that flows off over a weir, which is the same force."""
        return (OverflowOverWeir(height=self.values["position"], weir=self.values["hertz"]),)

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From contacts that are as stiff at a small depth and at a large one; from none where the stop is hard."""
        side = 1.0 if values["position"] >= 0.0 else -1.0
        deepest = float(np.max(side * situation.position)) - abs(values["position"])
        if deepest >= LEAST_DEPTH * situation.largest("position"):
            for share in DEPTHS:
                yield cls.as_stiff_as(EndStop(**values), share * deepest)

    @classmethod
    def as_stiff_as(cls, straight: EndStop, depth: float) -> HertzEndStop:
        """The contact that is as stiff as a straight law, and pushes as hard, at a depth beyond its own beginning."""
        position = straight.values["position"]
        start = position - copysign(depth / 3.0, position)
        return cls(position=start, hertz=straight.values["stiffness"] / (1.5 * sqrt(depth)))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a stop that was found."""
        yield from ()
