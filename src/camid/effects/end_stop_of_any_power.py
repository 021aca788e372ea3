"""End stops whose force grows with any power of the depth: felt, foam, rubber, a cone."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt
from typing import Any

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.damped_end_stop import SHARES, DampedEndStop
from camid.effects.parameter import Parameter
from camid.effects.plant_force import mobility
from camid.effects.situation import Situation
from camid.effects.stiffness import EndStop

# Depth in which a body is taken to be where steps of the integrator are chosen, as a share of the distance of the stop.
DEEP = 0.25
LEAST_POWER, LARGEST_POWER = 1.0, 6.0
POWER = Parameter("power", "", "power n of the depth that the force grows with", LEAST_POWER, LARGEST_POWER)
# The power of a contact that is started from one with a straight law.
FIRST_POWER = 1.3


class EndStopOfAnyPower(EndStop):
    """A stop whose force grows with a power of the depth."""

    title = "End stop of any power"
    equation = r"f = k_s\,d\,(d/|y_s|)^{n-1},\ d = \max(y - y_s,\ 0)\ \ (y_s > 0);\quad \mathrm{mirrored\ for}\ y_s < 0"
    reference = "Johnson (1985), Contact Mechanics, section 5.1 (Sneddon 1965: any profile)"
    parameters = (*EndStop.parameters, POWER)

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        side = 1.0 if values[0] >= 0.0 else -1.0
        depth = side * (position - values[0])
        if depth <= 0.0 or values[0] == 0.0:
            return 0.0
        return side * values[1] * depth * (depth / abs(values[0])) ** (values[2] - 1.0)

    def frequency(self, plant: TransferFunction) -> float:
        """Of the body deep in the stop."""
        steepness = self.values["power"] * DEEP ** (self.values["power"] - 1.0)
        return sqrt(mobility(plant) * self.values["stiffness"] * steepness)

    def simplified(self) -> EndStop:
        """The straight law of the same stiffness."""
        return EndStop(position=self.values["position"], stiffness=self.values["stiffness"])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """One that takes energy, too."""
        return tuple(DampedEndStopOfAnyPower.starts(situation, **self.values))

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """It is started from a Hertz contact, which is the first power that is tried."""
        yield from ()

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a contact that was found."""
        yield from ()


class DampedEndStopOfAnyPower(DampedEndStop):
    """A stop whose force grows with a power of the depth, and is larger against what comes than against what goes."""

    title = "End stop of any power that takes energy"
    equation = (
        r"f = k_s\,d\,(d/|y_s|)^{n-1}\,\max(1 + a\,\dot y,\ 0),\ d = \max(y - y_s,\ 0)\ \ (y_s > 0);"
        r"\quad \mathrm{mirrored\ for}\ y_s < 0"
    )
    reference = "Hunt & Crossley (1975), J. Appl. Mech. 42, 440-445"
    parameters = (*DampedEndStop.parameters, POWER)

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        side = 1.0 if values[0] >= 0.0 else -1.0
        depth = side * (position - values[0])
        if depth <= 0.0 or values[0] == 0.0:
            return 0.0
        level = values[1] * depth * (depth / abs(values[0])) ** (values[3] - 1.0)
        return side * level * max(1.0 + values[2] * side * velocity, 0.0)

    frequency = EndStopOfAnyPower.frequency

    def simplified(self) -> EndStop:
        """The same without a loss."""
        kept = {name: value for name, value in self.values.items() if name != "loss"}
        return EndStopOfAnyPower(**kept)

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """None."""
        return ()

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From a power that takes no energy, with a little loss or a large one; from a loss, with a power above one."""
        usual = float(np.std(situation.velocity)) or 1.0
        if "loss" in values:
            yield cls(**{"power": FIRST_POWER, **values})
        elif "power" in values:
            yield from (cls(**{"loss": share / usual, **values}) for share in SHARES)
