"""Dry friction of a shaft whose speed is the output, as a tachometer reads it: what turns round is the output."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from math import tanh
from typing import Any

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.extent import Extent
from camid.effects.friction import CoulombFriction
from camid.effects.parameter import Parameter
from camid.effects.plant_force import GUESS, motion_sign
from camid.effects.situation import Situation

# Output over which it turns round in first guesses, as shares of the largest one.
SHARES = (0.005, 0.05)
# The same at most, as a share of what a recording spans: beyond it is viscous.
WIDEST = 0.2
# Largest rate at which it brings the shaft to rest, in those of the plant.
FASTEST = 1e3
NOT_A_SPEED = "the output of a plant of one pole that holds a speed is known to be one alone"


class FrictionOfAShaft(CoulombFriction):
    """Coulomb friction over the output, where that is a speed."""

    title = "Coulomb friction of a shaft whose speed is the output"
    equation = r"f = f_c\,\tanh(y/y_t)"
    reference = "Olsson, Astrom, Canudas de Wit, Gafvert & Lischinsky (1998), Eur. J. Control 4, 176-195"
    parameters = (
        *CoulombFriction.parameters,
        Parameter("standstill", "y", "speed y_t, in the output, over which the friction turns round", 1e-300),
    )
    friction_level = None  # type: ignore[assignment] # what holds the shaft is steep
    uses_velocity = False

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """Only a plant of one pole is taken for a shaft."""
        return None if _is_a_shaft(situation.plant) else NOT_A_SPEED

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * tanh(position / values[1])

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Level with the sign of the plant's gain, and the output over which it turns round."""
        return [motion_sign(plant) * self.values["force"], self.values["standstill"]]

    def frequency(self, plant: TransferFunction) -> float:
        """Rate at which it brings a slow shaft to rest."""
        rate = abs(float(plant.monic.numerator[0])) * self.values["force"] / self.values["standstill"]
        return min(rate, FASTEST * max(plant.fastest_pole, 1.0))

    def is_plausible(self, extent: Extent) -> bool:
        """Whether it turns round within the speeds recorded."""
        return bool(self.values["standstill"] <= WIDEST * extent.span)

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """None: what turns round with the acceleration is another friction."""
        return ()

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """None."""
        return ()

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """None from friction that turns round with the velocity of the output."""
        yield from ()

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small, and turning round at a small share of the output, where that is of either sign."""
        low, high = float(np.min(situation.position)), float(np.max(situation.position))
        if _is_a_shaft(situation.plant) and low < 0.0 < high:
            for share in SHARES:
                yield cls(force=GUESS * situation.largest("signal"), standstill=share * max(high, -low))

    @property
    def branch(self) -> tuple[Any, ...]:
        """It depends on something else than the law that it bears the name of."""
        return (*super().branch, "output")


def _is_a_shaft(plant: TransferFunction) -> bool:
    """Whether a plant has one pole, no zero and a speed that it holds."""
    return plant.order == 1 and len(plant.numerator) == 1 and plant.denominator[-1] != 0.0
