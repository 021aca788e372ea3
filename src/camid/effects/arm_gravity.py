"""Gravity on an arm: its torque where no spring of the plant holds it already, as in a joint that a motor turns.

A pendulum's law is what gravity has beside the linear spring that the plant contains. A joint that is declared as an
inertia with damping has no such spring: what is left out then is the whole torque, and where the arm hangs is another
number.
"""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from math import ceil, pi, sin, sqrt
from typing import Any

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.actuator import InputBias
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.parameter import Parameter
from camid.effects.periodic_in_position import LARGEST_PERIOD
from camid.effects.plant_force import GUESS, mobility, motion_sign
from camid.effects.recorded_force import waves_of_force
from camid.effects.situation import Situation
from camid.effects.stiffness import PendulumGravity

# First guesses: angles at the largest displacement, and angles from where the arm hangs at the sensor's zero.
ANGLES = (0.5, 1.2, 2.5)
QUADRANTS = (0, 1, 2, 3)
# Angles at the largest displacement of which the recorded motion is asked, and how many of them are kept.
SEEN_ANGLES, BEST = np.geomspace(0.3, 12.0, 60), 2


class ArmGravity(PendulumGravity):
    """The torque of gravity on an arm, which pulls it to where it hangs."""

    title = "Gravity on an arm"
    equation = r"f = m\,\sin(y/A + \varphi)"
    reference = "Spong, Hutchinson & Vidyasagar (2006), Robot Modeling and Control, section 7.3"
    parameters = (
        *PendulumGravity.parameters,
        Parameter("torque", "u", "torque m of the arm held level", 0.0),
        Parameter("phase", "rad", "angle φ from where it hangs at y = 0", scale="one"),
    )
    strength = "torque"

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[1] * sin(position / values[0] + values[2])

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Amplitude, torque with the sign of the plant's gain, and phase."""
        amplitude, torque, phase = self.vector.tolist()
        return [amplitude, motion_sign(plant) * torque, phase]

    def frequency(self, plant: TransferFunction) -> float:
        """Of small oscillations where it hangs."""
        return sqrt(mobility(plant) * self.values["torque"] / self.values["amplitude"])

    def is_plausible(self, span: float, duration: float) -> bool:
        """Whether the motion holds hardly more than a turn: what repeats along the way is cogging."""
        return bool(2.0 * pi * self.values["amplitude"] >= LARGEST_PERIOD * span)

    @property
    def branch(self) -> tuple[Any, ...]:
        """An arm that stands is no start for one that hangs."""
        return (*super().branch, ceil(self.values["phase"] / (0.5 * pi) - 0.5) % len(QUADRANTS))

    def simplified(self) -> InputBias:
        """A constant, which it is where the arm hardly turns."""
        return InputBias(bias=-self.values["torque"] * sin(self.values["phase"]))

    def scaled(self, factor: float) -> Effect:  # type: ignore[override] # in its torque, as most laws
        """Another torque."""
        return Effect.scaled(self, factor)

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """A plant with a spring of its own leaves nothing of this to be told from it."""
        return iter(())

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """As the recorded motion shows it; else from small angles to large ones, from each quarter of a turn."""
        periods = 2.0 * pi * situation.largest("recorded") / SEEN_ANGLES
        found = waves_of_force(situation, periods, BEST)
        for wave in found:
            yield cls(amplitude=wave["period"] / (2.0 * pi), torque=wave["amplitude"], phase=wave["phase"])
        if found:
            return
        torque, largest = GUESS * situation.largest("signal"), situation.largest("position")
        for angle, quadrant in product(ANGLES, QUADRANTS):
            yield cls(amplitude=largest / angle, torque=torque, phase=0.5 * pi * quadrant)
