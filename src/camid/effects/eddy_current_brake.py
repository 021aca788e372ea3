"""Drag that grows with the speed to a peak and falls beyond it, as that of an eddy-current brake."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.extent import Extent
from camid.effects.friction import StribeckFriction
from camid.effects.gradual_friction import GradualStribeckFriction
from camid.effects.parameter import Parameter
from camid.effects.plant_force import GUESS, mobility, motion_sign
from camid.effects.situation import Situation

# The friction that falls and turns round gradually which is nearest up to four times the speed of the peak, to 1.3 % of
# that: levels over the peak, and the speeds at which it turns round and falls over that of the peak.
LOW, HIGH, TURN, FALL = 0.436, 1.174, 0.575, 2.414
# Speeds of the peak of first guesses, and the largest that a recording shows, in standard deviations of the velocity.
PEAKS, FASTEST_PEAK = (0.7, 2.0), 4.0


class EddyCurrentBrake(StribeckFriction):
    """Drag of a conductor in a magnetic field: viscous at low speeds, and beyond a peak the field is driven out."""

    title = "Drag with a peak, as of an eddy-current brake"
    equation = r"f = 2 f_m\,\dot y\,v_m\,/\,(v_m^2 + \dot y^2)"
    reference = "Wouterse (1991), IEE Proc. B 138, 153-158"
    parameters = (
        Parameter("peak", "u", "largest drag f_m", 0.0),
        Parameter("velocity", "y/s", "speed v_m of the peak", 1e-300),
    )
    friction_level = None  # type: ignore[assignment] # nothing holds the body
    strength = "peak"

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return 2.0 * values[0] * velocity * values[1] / (values[1] * values[1] + velocity * velocity)

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Peak with the sign of the plant's gain, and its speed."""
        return [motion_sign(plant) * self.values["peak"], self.values["velocity"]]

    def frequency(self, plant: TransferFunction) -> float:
        """Rate at which it brings a slow body to rest."""
        return 2.0 * mobility(plant) * self.values["peak"] / self.values["velocity"]

    def is_plausible(self, extent: Extent) -> bool:
        """Whether its peak lies within the speeds recorded: below it is viscous."""
        return bool(self.values["velocity"] <= FASTEST_PEAK * extent.speed)

    @property
    def branch(self) -> tuple[Any, ...]:
        """What falls from a level at rest is no start for what rises from nothing there."""
        return (*super().branch, "peak")

    def simplified(self) -> StribeckFriction:  # type: ignore[override] # with less detail, and not another name
        """Friction that falls and turns round gradually, which is nearly such."""
        peak, speed = self.values["peak"], self.values["velocity"]
        return GradualStribeckFriction(
            coulomb=LOW * peak, breakaway=HIGH * peak, velocity=FALL * speed, transition=TURN * speed
        )

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """None."""
        return ()

    def scaled(self, factor: float) -> EddyCurrentBrake:
        """The peak, scaled."""
        return self.with_vector(self.vector * [max(factor, 0.0), 1.0])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """None."""
        return ()

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From friction that falls as the speed grows: where it turns round, if it does, and where it falls."""
        turn = values.get("transition", TURN / FALL * values["velocity"])
        speeds = turn / TURN, (turn / TURN * values["velocity"] / FALL) ** 0.5
        yield from (cls(peak=values["breakaway"] / HIGH, velocity=speed) for speed in speeds)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small, with a peak at usual speeds and at large ones: as far as it is viscous the plant has it already."""
        spread = float(np.std(situation.velocity)) or 1.0
        for share in PEAKS:
            yield cls(peak=GUESS * situation.largest("signal"), velocity=share * spread)
