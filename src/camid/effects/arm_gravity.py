"""Gravity on an arm: the whole torque, on a joint that is declared as an inertia with damping and no spring."""

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
from camid.effects.extent import Extent
from camid.effects.gravity import PendulumGravity
from camid.effects.parameter import Parameter
from camid.effects.periodic_in_position import LARGEST_PERIOD
from camid.effects.plant_force import GUESS, mobility, motion_sign
from camid.effects.recorded_force import waves_of_force
from camid.effects.situation import Situation
from camid.effects.stiffness import QuadraticStiffness

# First guesses: angles at the largest displacement, and angles from where the arm hangs at the sensor's zero.
ANGLES = (0.5, 1.2, 2.5)
QUADRANTS = (0, 1, 2, 3)
# Angle over the whole way from which an arm turns at all.
LEAST_ANGLE = 0.05
# Angles at the largest displacement of which the recorded motion is asked, and how many of them are kept.
SEEN_ANGLES, BEST = np.geomspace(0.3, 12.0, 60), 2
# Sine of the angle from where an arm hangs from which it is level.
LEVEL = 0.9


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

    def is_plausible(self, extent: Extent) -> bool:
        """Whether the motion holds hardly more than a turn, and more than a small angle.

        What repeats along the way is cogging, and what hardly turns is a constant and a spring.
        """
        amplitude = self.values["amplitude"]
        return bool(LARGEST_PERIOD / (2.0 * pi) * extent.span <= amplitude <= extent.span / LEAST_ANGLE)

    @property
    def branch(self) -> tuple[Any, ...]:
        """An arm that stands is no start for one that hangs."""
        return (*super().branch, ceil(self.values["phase"] / (0.5 * pi) - 0.5) % len(QUADRANTS))

    def simplified(self) -> InputBias:
        """A constant, which it is where the arm hardly turns; a fit finds its sign, which is that of the plant, too."""
        return InputBias(bias=-self.values["torque"] * sin(self.values["phase"]))

    def scaled(self, factor: float) -> Effect:  # type: ignore[override] # in its torque, as most laws
        """Another torque; a negative one is that of an arm which stands where this one hangs."""
        return Effect.scaled(self if factor >= 0.0 else self.turned(), abs(factor))

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """About where the arm is level its torque is a constant and a square of the displacement."""
        amplitude, torque, phase = self.vector.tolist()
        level = abs(sin(phase)) > LEVEL
        return (QuadraticStiffness(coefficient=-0.5 * torque * sin(phase) / amplitude**2),) if level else ()

    def turned(self) -> ArmGravity:
        """That of an arm which hangs where this one stands."""
        amplitude, torque, phase = self.vector.tolist()
        return type(self)(amplitude=amplitude, torque=torque, phase=phase - pi if phase > 0.0 else phase + pi)

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """A plant with a spring of its own leaves nothing of this to be told from it."""
        return iter(())

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """As the recorded motion shows it; else from small angles to large ones, from each quarter of a turn."""
        periods = 2.0 * pi * situation.largest("recorded") / SEEN_ANGLES
        found = waves_of_force(situation, periods, BEST)
        # The torque counts with the sign of the plant's gain.
        turned = 0.0 if motion_sign(situation.plant) > 0.0 else pi
        for wave in found:
            yield cls(amplitude=wave["period"] / (2.0 * pi), torque=wave["amplitude"], phase=wave["phase"] + turned)
        if found:
            return
        torque, largest = GUESS * situation.largest("signal"), situation.largest("position")
        for angle, quadrant in product(ANGLES, QUADRANTS):
            yield cls(amplitude=largest / angle, torque=torque, phase=0.5 * pi * quadrant)
