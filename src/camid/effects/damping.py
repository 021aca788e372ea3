"""Damping that is not in proportion to the speed."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.parameter import Parameter
from camid.effects.plant_force import GUESS, AgainstMotion
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation


class QuadraticDrag(AgainstMotion):
    """Resistance that grows with the square of the speed."""

    identifier = "quadratic-drag"
    place = "plant"
    title = "Quadratic drag"
    equation = r"f = c\,|\dot y|\,\dot y"
    reference = "Worden & Tomlinson (2001), Nonlinearity in Structural Dynamics, chapter 1"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("coefficient", "u s^2/y^2", "drag c", 0.0),)
    separated_by = (SeparatingExperiment.FREE_DECAY,)
    strength = "coefficient"
    uses_velocity = True

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * abs(velocity) * velocity

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to it."""
        for share in (GUESS, 0.3):
            yield cls(coefficient=share * situation.largest("signal") / situation.largest("velocity") ** 2)


class AmplitudeDependentDamping(AgainstMotion):
    """Damping that grows with the square of the displacement."""

    identifier = "amplitude-dependent-damping"
    place = "plant"
    title = "Damping that depends on the amplitude"
    equation = r"f = c\,y^2\,\dot y"
    reference = "Elliott, Ghandchi Tehrani & Langley (2015), Phil. Trans. R. Soc. A 373, 20140402"
    parameters = (Parameter("coefficient", "u s/y^3", "damping c for a unit of the squared displacement"),)
    separated_by = (SeparatingExperiment.FREE_DECAY, SeparatingExperiment.HELD_POSITIONS)
    strength = "coefficient"
    uses_velocity = True

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * position * position * velocity

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to it."""
        size = situation.largest("position") ** 2 * situation.largest("velocity")
        for share in (GUESS, 0.3):
            yield cls(coefficient=share * situation.largest("signal") / size)
