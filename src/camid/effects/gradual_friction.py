"""Coulomb friction that turns round over a range of speeds instead of at once, as that of a lubricated contact does."""

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
from camid.effects.friction import CoulombFriction
from camid.effects.parameter import Parameter
from camid.effects.plant_force import mobility, motion_sign
from camid.effects.situation import Situation

# Speeds of first guesses over which the friction turns round, as shares of the standard deviation of the speed.
SHARES = (0.1, 0.4)
# Largest rate at which such a friction brings the body to rest, in rates of the plant: beyond it turns round at once.
FASTEST = 1e3


class GradualCoulombFriction(CoulombFriction):
    """Coulomb friction that holds nothing at rest: it is viscous at speeds below that at which it turns round."""

    title = "Coulomb friction that turns round gradually"
    equation = r"f = f_c\,\tanh(\dot y/v_t)"
    reference = "Andersson, Soderberg & Bjorklund (2007), Tribology Int. 40, 580-587"
    parameters = (
        *CoulombFriction.parameters,
        Parameter("transition", "y/s", "speed v_t over which the friction turns round", 1e-300),
    )
    friction_level = None  # type: ignore[assignment] # nothing holds the body

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * tanh(velocity / values[1])

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Level with the sign of the plant's gain, and speed."""
        return [motion_sign(plant) * self.values["force"], self.values["transition"]]

    def frequency(self, plant: TransferFunction) -> float:
        """Rate at which it brings a slow body to rest."""
        rate = mobility(plant) * self.values["force"] / self.values["transition"]
        return min(rate, FASTEST * float(np.max(np.abs(plant.poles()), initial=1.0)))

    def simplified(self) -> CoulombFriction:
        """Coulomb friction of the same level."""
        return CoulombFriction(force=self.values["force"])

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """Of small and of middle speeds."""
        spread = float(np.std(situation.velocity)) or 1.0
        for share in SHARES:
            yield cls(**values, transition=share * spread)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a friction that was found."""
        yield from ()
