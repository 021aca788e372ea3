"""Springs whose force has a quadratic and a cubic part, or a cubic and a fifth one, and the name of the larger one.

A spring that is bent, loaded beforehand or clamped beside its middle has the first two: the equation of Helmholtz and
Duffing (Kovacic & Brennan 2011, The Duffing Equation, chapter 8). A cubic one alone leaves what the other does to be
learned, and a quadratic one with a cubic part acts much like a stop. A membrane or a beam that is clamped at both ends
hardens by more than the cube where it is bent far.
"""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Self

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.extent import Extent
from camid.effects.gravity import pendulum_like
from camid.effects.parameter import Parameter
from camid.effects.plant_force import GUESS, AgainstMotion, motion_sign
from camid.effects.situation import Situation
from camid.effects.stiffness import CubicStiffness, QuadraticStiffness

# Smaller part at the largest displacement, as a share of the larger one: first guesses.
SHARES = (0.3, -0.3)
# Displacement, as a share of the way that a recording spans, at which the larger part gives its name.
TYPICAL_DISPLACEMENT = 0.25
# Share of the other part at the largest displacement below which a part may have any sign.
NEGLIGIBLE = 0.05


class TwoTermSpring(AgainstMotion):
    """What both laws share."""

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Both parts, with the sign of the plant's gain."""
        return list(motion_sign(plant) * self.vector)

    @property
    def branch(self) -> tuple[Any, ...]:
        """It may turn out to be the other law of both parts, so that it is no start for the one without."""
        return (*super().branch, "two terms")

    def scaled(self, factor: float) -> Self:
        """Both parts."""
        return self.with_vector(factor * self.vector)


class QuadraticStiffnessWithCubic(TwoTermSpring, QuadraticStiffness):
    """A spring that is stiffer to one side, with a smaller part that grows with the cube."""

    title = "Quadratic stiffness with a cubic part"
    equation = r"f = \gamma\,y^2 + \beta\,y^3"
    reference = "Kovacic & Brennan (2011), The Duffing Equation, chapter 8"
    parameters = (*QuadraticStiffness.parameters, Parameter("cubic", "u/y^3", "stiffness β of the smaller, cubic part"))

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return (values[0] + values[1] * position) * position * position

    def is_plausible(self, extent: Extent) -> bool:
        """Whether the cubic part is the smaller one: else the law has the other's name."""
        return abs(self.values["cubic"]) * TYPICAL_DISPLACEMENT * extent.span <= abs(self.values["coefficient"])

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """What a quadratic part alone resembles, and a pendulum that rests at an angle."""
        pendulums = pendulum_like(situation.plant, self.values["coefficient"], self.values["cubic"])
        return (*super().relatives(situation), *pendulums)

    def simplified(self) -> QuadraticStiffness:
        """The same without the cubic part."""
        return QuadraticStiffness(coefficient=self.values["coefficient"])

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From a spring that hardens farther out, and from one that softens."""
        for share in SHARES:
            yield cls(**{"cubic": share * values["coefficient"] / situation.largest("position"), **values})

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to both parts."""
        return cls.starts(
            situation, coefficient=GUESS * situation.largest("signal") / situation.largest("position") ** 2
        )


class CubicStiffnessWithQuadratic(TwoTermSpring, CubicStiffness):
    """A spring that hardens, or softens, with the cube of the displacement, with a smaller part that is one-sided."""

    title = "Cubic stiffness with a quadratic part"
    equation = r"f = \beta\,y^3 + \gamma\,y^2"
    reference = QuadraticStiffnessWithCubic.reference
    parameters = (
        *CubicStiffness.parameters,
        Parameter("quadratic", "u/y^2", "stiffness γ of the smaller, quadratic part"),
    )

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return (values[1] + values[0] * position) * position * position

    def is_plausible(self, extent: Extent) -> bool:
        """Whether the quadratic part is the smaller one: else the law has the other's name."""
        return abs(self.values["quadratic"]) <= abs(self.values["coefficient"]) * TYPICAL_DISPLACEMENT * extent.span

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """Where it softens, a pendulum that rests at an angle."""
        return pendulum_like(situation.plant, self.values["quadratic"], self.values["coefficient"])

    def simplified(self) -> CubicStiffness:
        """The same without the quadratic part."""
        return CubicStiffness(coefficient=self.values["coefficient"])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """The law with a fifth power in the place of the quadratic part, which may have stood for it."""
        return tuple(CubicStiffnessWithFifthPower.starts(situation, coefficient=self.values["coefficient"]))

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From a spring that is stiffer to either side."""
        for share in SHARES:
            yield cls(**{"quadratic": share * values["coefficient"] * situation.largest("position"), **values})

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to both parts."""
        return cls.starts(
            situation, coefficient=GUESS * situation.largest("signal") / situation.largest("position") ** 3
        )


class CubicStiffnessWithFifthPower(TwoTermSpring, CubicStiffness):
    """A spring that hardens, or softens, with the cube of the displacement and with its fifth power."""

    title = "Cubic stiffness with a fifth power"
    equation = r"f = \beta\,y^3 + \delta\,y^5"
    reference = "Kovacic & Brennan (2011), The Duffing Equation, chapter 2"
    parameters = (
        *CubicStiffness.parameters,
        Parameter("fifth", "u/y^5", "stiffness δ of the part with the fifth power"),
    )

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        square = position * position
        return (values[0] + values[1] * square) * position * square

    def is_plausible(self, extent: Extent) -> bool:
        """Whether both harden or both soften, or one is small: else they are the terms of some other law's series.

        So they are with a quadratic one beside them.
        """
        cubic, fifth = self.values["coefficient"], self.values["fifth"]
        if abs(fifth) * (TYPICAL_DISPLACEMENT * extent.span) ** 2 <= abs(cubic):
            return True
        if QuadraticStiffness.identifier in extent.beside:
            return False
        return cubic * fifth >= 0.0 or abs(cubic) <= NEGLIGIBLE * abs(fifth) * (0.5 * extent.span) ** 2

    def simplified(self) -> CubicStiffness:
        """The same without the fifth power."""
        return CubicStiffness(coefficient=self.values["coefficient"])

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From a spring that hardens farther out, and from one that softens."""
        for share in SHARES:
            yield cls(**{"fifth": share * values["coefficient"] / situation.largest("position") ** 2, **values})

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """None of its own: it is found from the cube alone."""
        return iter(())
