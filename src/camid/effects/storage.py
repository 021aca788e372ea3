"""Tanks and other storages of the plant: an outflow that follows the square root of the level, and an overflow.

A plant of one pole is one storage; one of two real poles and no zero is a storage whose outflow fills a second one.
With the static gain 1/k, the rates a (upper) and b (lower), and an excess flow e that leaves the upper storage and of
which the share s reaches the lower one, in units of the output,

    ẋ/a = (u − e)/k − x,    ẏ/b = x + s e/k − y.

Only y is measured, but S = y + ẏ/b = x + s e/k is known from its motion, so that what leaves the upper storage is a
force at the plant's input that depends on y, ẏ and u. With a steep edge, e = κ k max(x − h, 0), it is

    f = κ k (S − h) − s κ (u − k h)    where S > h.
"""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.parameter import Parameter
from camid.effects.plant_force import GUESS, AgainstMotion, mobility, motion_sign, static_stiffness
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

# Damping ratio from which two poles are those of two storages; fits wander about the double pole.
LEAST_DAMPING = 0.8
# A single storage that is full fills this many times slower than without its edge.
TIGHTNESS = 1e3
# A step that crosses the edge leads beyond it; that flows off with this many times the rate of the storage.
RETURN = 8.0
# The flow over the edge of the upper of two storages grows by this many times its outflow for a unit of the level.
STEEPNESS = 30.0
# Of the rate of a storage at its edge, the share that counts for the length of a step: explicit steps stay stable.
STEP_SHARE = 0.125
# Speed of the outflow near the empty storage, in rates of the storage, above which it is in proportion to the level:
# a trickle is not turbulent.
FASTEST_TRICKLE = 10.0
# An edge this much beyond the motion, in the largest displacement, does nothing.
BEYOND = 1.001
# A level, in any unit, whose square is still a number.
NO_LEVEL = 1e-150
NO_STORAGE = (
    "only a storage flows out or over: a plant of one pole, or of two real ones, without zeros; this plant is not one"
)


def time_constants(plant: TransferFunction) -> list[float]:
    """Time constants in s of the storages that a plant consists of, the shortest first; none where it does not."""
    monic = plant.monic
    if len(monic.numerator) != 1 or monic.order not in (1, 2) or monic.denominator[-1] <= 0.0:
        return []
    if monic.order == 1:
        return [1.0 / monic.denominator[1]]
    rate, square = 0.5 * monic.denominator[1], monic.denominator[2]
    if rate < LEAST_DAMPING * sqrt(square):
        return []
    spread = sqrt(max(rate * rate - square, 0.0))
    return [1.0 / (rate + spread), (rate + spread) / square]


class _Storage(Effect):
    """An effect of a storage."""

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """Other plants have no storage."""
        return None if time_constants(situation.plant) else NO_STORAGE


class SquareRootOutflow(_Storage, AgainstMotion):
    """An outflow with the square root of the level (Torricelli), beside the part that is in proportion to it."""

    identifier = "square-root-outflow"
    place = "plant"
    title = "Outflow with the square root of the level"
    equation = r"f = c\,\mathrm{sgn}(y)\,\sqrt{|y|}"
    reference = "Johansson (2000), IEEE Trans. Control Syst. Technol. 8, 456-465 (tanks; Torricelli's law)"
    parameters = (Parameter("coefficient", "u/y^0.5", "outflow c at the level one", 0.0),)
    separated_by = (SeparatingExperiment.HELD_POSITIONS,)
    strength = "coefficient"

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * position / sqrt(sqrt(position * position + values[1] * values[1]))

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Coefficient with the sign of the gain, and the level below which the outflow is in proportion to it."""
        return [motion_sign(plant) * self.values["coefficient"], self._trickle(plant)]

    @compiled
    def switch(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return position

    def _trickle(self, plant: TransferFunction) -> float:
        stiffness = abs(static_stiffness(plant))
        return (
            (self.values["coefficient"] / (FASTEST_TRICKLE * stiffness)) ** 2 + NO_LEVEL
            if stiffness > 0.0
            else NO_LEVEL
        )

    def frequency(self, plant: TransferFunction) -> float:
        """Of a trickle."""
        constants = time_constants(plant)
        return STEP_SHARE * FASTEST_TRICKLE / constants[0] if constants else 0.0

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to it."""
        for share in (GUESS, 0.3):
            yield cls(coefficient=share * situation.largest("signal") / sqrt(situation.largest("position")))


class Overflow(_Storage):
    """A storage that is full: its level exceeds its edge no more, and the excess is lost, or a share of it is."""

    identifier = "overflow"
    place = "plant"
    title = "Overflow (limited level)"
    equation = r"x \leq h:\quad \dot x/a = (u - e)/k - x,\quad e > 0\ \mathrm{only\ at}\ x = h"
    reference = "Schoukens & Noël (2017), IFAC-PapersOnLine 50, 446-451 (cascaded tanks)"
    parameters = (
        Parameter("height", "y", "level h of the edge: the output at rest with the storage just full"),
        Parameter("share", "", "share of the excess that reaches the storage below", 0.0, 1.0),
        Parameter(
            "below", "", "storage below the full one: none, the faster or the slower", choices=("none", "fast", "slow")
        ),
    )
    separated_by = (SeparatingExperiment.HELD_POSITIONS, SeparatingExperiment.SCALE_IN_THE_IMAGE)

    # At the edge of a single storage the force follows from the speed that it leaves.
    uses_velocity = True

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        side = values[0]
        excess = side * (position + values[1] * velocity - values[2])
        if excess < 0.0:
            return 0.0
        held = values[6] * side * max(side * velocity + values[7] * excess, 0.0)
        return held + side * values[3] * excess - values[4] * (signal - values[5])

    @compiled
    def switch(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return position + values[1] * velocity - values[2]

    def _below(self, plant: TransferFunction) -> float:
        """Time constant in s of the storage below."""
        constants = time_constants(plant) or [0.0]
        choice = self.values["below"]
        return 0.0 if choice == "none" or plant.order < 2 else constants[0 if choice == "fast" else -1]

    def force_values(self, plant: TransferFunction) -> list[float]:
        """What the compiled parts need.

        Side, time constant below, height, force for a unit of the level beyond it, part of the excess that passes on,
        input that just fills the storage, force for a unit of the speed beyond the edge, and rate of the return to it.
        """
        height, stiffness, below = self.values["height"], static_stiffness(plant), self._below(plant)
        side = 1.0 if height >= 0.0 else -1.0
        if plant.order == 1:
            return [side, 0.0, height, 0.0, 0.0, 0.0, TIGHTNESS / plant.monic.numerator[0], self._return(plant)]
        passed = STEEPNESS * self.values["share"] if below > 0.0 else 0.0
        return [side, below, height, STEEPNESS * stiffness, passed, stiffness * height, 0.0, 0.0]

    def _return(self, plant: TransferFunction) -> float:
        """Rate in 1/s with which what a step has led beyond the edge flows off."""
        return RETURN * float(np.max(np.abs(plant.poles()), initial=0.0))

    def frequency(self, plant: TransferFunction) -> float:
        """Of a full storage above another one."""
        if plant.order == 1:
            return 0.0
        constants = time_constants(plant)
        if not constants:
            return sqrt(mobility(plant) * STEEPNESS * abs(static_stiffness(plant)))
        return STEP_SHARE * STEEPNESS / (constants[0] if self.values["below"] != "fast" else constants[-1])

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Several heights on both sides, of the storage itself or of the upper one of two."""
        count = len(time_constants(situation.plant))
        belows = ("fast", "slow") if count == 2 else ("none",) * count
        for edge in (float(np.max(situation.position)), float(np.min(situation.position))):
            for share in (0.9, 0.7, 0.4) if edge != 0.0 else ():
                for below in belows:
                    yield cls(height=share * edge, share=0.0, below=below).measured_from(BEYOND * edge, 0.0)
