"""Forces that depend on the position alone: springs that are not linear, gravity, a stop."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from math import cos, inf, sin, sqrt
from typing import Any, ClassVar

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.parameter import Parameter
from camid.effects.plant_force import GUESS, LEAST_FACTOR, AgainstMotion, mobility, motion_sign, static_stiffness
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation


class CubicStiffness(AgainstMotion):
    """A spring that hardens, or softens, with the cube of the displacement."""

    identifier = "cubic-stiffness"
    place = "plant"
    title = "Cubic stiffness"
    equation = r"f = \beta\,y^3"
    reference = "Kerschen et al. (2006), Mech. Syst. Signal Process. 20, 505-592"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("coefficient", "u/y^3", "stiffness β, negative where it softens"),
    )
    separated_by = (SeparatingExperiment.HELD_POSITIONS,)
    strength = "coefficient"

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * position * position * position

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to it."""
        for share in (GUESS, 0.3, -0.1):
            yield cls(coefficient=share * situation.largest("signal") / situation.largest("position") ** 3)
        for law in cls.finer_laws:
            yield from law.candidates(situation)

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """Where it softens, the pendulum whose sine begins with the same cube."""
        ratio = -abs(static_stiffness(situation.plant)) / (6.0 * self.values["coefficient"] or inf)
        return (PendulumGravity(amplitude=sqrt(ratio)),) if ratio > 0.0 else ()


class QuadraticStiffness(AgainstMotion):
    """A spring that is stiffer to one side than to the other."""

    identifier = "quadratic-stiffness"
    place = "plant"
    title = "Quadratic stiffness"
    equation = r"f = \gamma\,y^2"
    reference = "Kerschen et al. (2006), Mech. Syst. Signal Process. 20, 505-592"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("coefficient", "u/y^2", "stiffness γ"),)
    separated_by = (SeparatingExperiment.REVERSED_INPUT, SeparatingExperiment.HELD_POSITIONS)
    strength = "coefficient"

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * position * position

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to it."""
        for share in (GUESS, 0.2, -0.2):
            yield cls(coefficient=share * situation.largest("signal") / situation.largest("position") ** 2)
        for law in cls.finer_laws:
            yield from law.candidates(situation)

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """Of a storage that empties faster the less is in it, an outflow with the square root that bends as much."""
        from camid.effects.storage import SquareRootOutflow

        level = 0.5 * situation.largest("position")
        coefficient = -8.0 * self.values["coefficient"] * motion_sign(situation.plant) * level**1.5
        return (SquareRootOutflow(coefficient=coefficient),) if coefficient > 0.0 else ()


class PendulumGravity(Effect):
    """Restoring force that follows the sine of the displacement, as gravity on a pendulum does."""

    identifier = "pendulum-gravity"
    place = "plant"
    title = "Gravity on a pendulum"
    equation = r"f = k\,(A\,\sin(y/A) - y),\quad k = 1/G(0)"
    reference = "Nelson & Olsson (1986), Am. J. Phys. 54, 112-121"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("amplitude", "y", "displacement A of one radian", 1e-300),)
    separated_by = (SeparatingExperiment.HELD_POSITIONS,)

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[1] * (values[0] * sin(position / values[0]) - position)

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Amplitude and static stiffness."""
        return [self.values["amplitude"], static_stiffness(plant)]

    def scaled(self, factor: float) -> PendulumGravity:
        """Another amplitude: the force is proportional to the inverse of its square while the angle is small."""
        return self.with_vector(self.vector / sqrt(max(factor, LEAST_FACTOR)))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """From small angles to large ones; what pushes tells both apart. Without a spring it is an arm's."""
        if static_stiffness(situation.plant) == 0.0:
            from camid.effects.arm_gravity import ArmGravity

            yield from ArmGravity.candidates(situation)
            return
        laws = (PendulumGravity, PendulumDrivenAcross) if np.any(situation.signal) else (PendulumGravity,)
        for law in laws:
            for angle in (0.15, 0.5, 1.2):
                yield law(amplitude=situation.largest("position") / angle)


class PendulumDrivenAcross(PendulumGravity):
    """A pendulum that is pushed horizontally, as one is whose pivot is accelerated.

    Only the part of the input along the arc moves it then, and not all of it as with a motor at the pivot.
    """

    title = "Gravity on a pendulum that is driven horizontally"
    equation = r"f = k\,(A\,\sin(y/A) - y) + u\,(1 - \cos(y/A)),\quad k = 1/G(0)"
    reference = "Ogata (2010), Modern Control Engineering, 5th ed., section 3.3"
    parameters = (
        *PendulumGravity.parameters,
        Parameter("drive", "", "how the input pushes", choices=("horizontal",), default="horizontal"),
    )

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """The same amplitude; without an input nothing tells both laws apart."""
        if np.any(situation.signal):
            yield cls(**values)

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        angle = position / values[0]
        return values[1] * (values[0] * sin(angle) - position) + signal * (1.0 - cos(angle))


class EndStop(AgainstMotion):
    """A stop that pushes back beyond a position."""

    identifier = "end-stop"
    place = "plant"
    title = "End stop"
    equation = r"f = k_s\,\max(y - y_s,\ 0)\ \ (y_s > 0),\quad f = k_s\,\min(y - y_s,\ 0)\ \ (y_s < 0)"
    reference = "Shaw & Holmes (1983), J. Sound Vib. 90, 129-155"
    parameters = (
        Parameter("position", "y", "start y_s of the contact"),
        Parameter("stiffness", "u/y", "stiffness k_s of the contact", 0.0),
    )
    separated_by = (SeparatingExperiment.HELD_POSITIONS,)
    strength = "stiffness"
    signed = 1

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        if values[0] >= 0.0:
            return values[1] * max(position - values[0], 0.0)
        return values[1] * min(position - values[0], 0.0)

    @compiled
    def switch(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return position - values[0]

    def frequency(self, plant: TransferFunction) -> float:
        """Of the body on the stop."""
        return sqrt(mobility(plant) * self.values["stiffness"])

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Several positions on both sides, from near the middle on, soft and hard."""
        stiffness = abs(static_stiffness(situation.plant)) or situation.largest("signal") / situation.largest(
            "position"
        )
        position = situation.position
        for share in (0.1, 0.5, 0.75, 0.92):
            for edge in (np.max(position), np.min(position)):
                if share * edge != 0.0:
                    for factor in (0.3, 10.0):
                        yield cls(position=float(share * edge), stiffness=factor * stiffness)
