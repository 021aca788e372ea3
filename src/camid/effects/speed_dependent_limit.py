"""Saturation of the actuator whose limit falls with the speed, as that of a motor under a limited voltage."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

from camid.chain.plant import TransferFunction
from camid.effects.actuator import Saturation
from camid.effects.base import Array, Effect
from camid.effects.compiled_part import compiled
from camid.effects.parameter import Parameter
from camid.effects.plant_force import LEAST_FACTOR, motion_sign
from camid.effects.situation import Situation

# First guesses: the limit at rest in largest inputs, and the speed at which nothing is left of it in largest speeds.
SHARES, SPEEDS = (0.6, 1.2, 2.4), (1.5, 4.0)


class SpeedDependentSaturation(Saturation):
    """A limit that falls in the direction of the motion and grows against it: the motor's own voltage takes its share.

    It acts where the plant is driven, so that what bends the command itself stands before it.
    """

    title = "Saturation of the actuator that depends on the speed"
    equation = r"u' = \max(-s\,(1 + \dot y/v),\ \min(u,\ s\,(1 - \dot y/v)))"
    reference = "Hughes & Drury (2019), Electric Motors and Drives, 5th ed., section 3.4"
    parameters = (
        Parameter("limit", "u", "largest force s at rest, in units of the command", 0.0),
        Parameter("no_load_speed", "y/s", "speed v at which nothing is left of it", 0.0),
    )
    drawn_against = "velocity"
    uses_velocity = True
    keeps_hold = False
    actuated = None  # type: ignore[assignment] # in a loop, too, the force does it

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        taken = values[0] * velocity / values[1]
        return signal - max(-values[0] - taken, min(signal, values[0] - taken))

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Limit at rest, and the speed along the motion that the input causes."""
        limit, speed = self.vector.tolist()
        return [limit, motion_sign(plant) * max(speed, 1e-300)]

    def transform(self, start: Array, end: Array, step: float) -> tuple[Array, Array]:
        """The command arrives as it is: the motion limits it."""
        return start, end

    def scaled(self, factor: float) -> SpeedDependentSaturation:
        """Another limit at rest: the lower it is, the more is taken."""
        limit, speed = self.vector.tolist()
        return type(self)(limit=limit / max(factor, LEAST_FACTOR), no_load_speed=speed)

    def simplified(self) -> Saturation:
        """The same limit at any speed."""
        return Saturation(limit=self.values["limit"])

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From limits that fall much, and hardly."""
        for speed in SPEEDS:
            yield cls(**{**values, "no_load_speed": speed * situation.largest("velocity")})

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Limits beyond the largest input, and within, which hardly fall, and much."""
        for share, speed in product(SHARES, SPEEDS):
            yield cls(limit=share * situation.largest("signal"), no_load_speed=speed * situation.largest("velocity"))
