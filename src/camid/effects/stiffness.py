"""Forces that depend on the position alone: springs that are not linear, and a stop."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import sqrt
from typing import ClassVar

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.force_over_position import plant_beside_stops
from camid.effects.gravity import pendulum_like
from camid.effects.parameter import Parameter
from camid.effects.plant_force import GUESS, AgainstMotion, mobility, motion_sign, static_stiffness
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
        return pendulum_like(situation.plant, 0.0, self.values["coefficient"])


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


class EndStop(AgainstMotion):
    """A stop that pushes back beyond a position."""

    identifier = "end-stop"
    place = "plant"
    title = "End stop"
    equation = r"f = k_s\,\max(y - y_s,\ 0)\ \ (y_s > 0),\quad f = k_s\,\min(y - y_s,\ 0)\ \ (y_s < 0)"
    reference = "Shaw & Holmes (1983), J. Sound Vib. 90, 129-155"
    parameters: ClassVar[tuple[Parameter, ...]] = (
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
        for law in cls.finer_laws:
            yield from law.candidates(situation)

    @classmethod
    def with_plant(
        cls, situation: Situation, constants: Mapping[str, float]
    ) -> tuple[Effect, TransferFunction, dict[str, float]] | None:
        """Beside the plant that the recorded motion shows with it, where it integrates: without the stop it goes on."""
        if situation.plant.denominator[-1] != 0.0:
            return None
        found = plant_beside_stops(situation)
        if found is None:
            return None
        (position, stiffness), *others = found.stops
        values = {"position": position, "stiffness": stiffness}
        for place, other in others:
            values |= {"opposite": place, "opposite_stiffness": other}
        return EndStop.with_keys(values)(**values), found.plant, dict.fromkeys(constants.keys() & {"bias"}, found.bias)
