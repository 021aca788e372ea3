"""The pendulum as a plant: the restoring force follows the sine of the angle from rest."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.gravity import PendulumGravity
from camid.effects.parameter import Parameter
from camid.effects.plant_force import static_stiffness
from camid.effects.situation import Situation

Array = NDArray[np.float64]


class SineRestoringForce(PendulumGravity):
    """What turns a linear plant into the pendulum ÿ + 2ξωẏ + ω² sin(y − rest) = gain ω² u (design, section 2).

    It belongs to the declared plant, not to the catalogue of effects. Forces see the angle from rest, the sensor the
    angle itself.
    """

    parameters = (Parameter("rest", "y", "angle at which it hangs still", scale="one"),)

    def force_values(self, plant: TransferFunction) -> list[float]:
        """One radian, and the static stiffness."""
        return [1.0, static_stiffness(plant)]

    def observe(self, output: Array, time: Array) -> Array:
        """Angles count from where the sensor has its zero."""
        return output + float(self.values["rest"])

    def scaled(self, factor: float) -> SineRestoringForce:
        """It has no size."""
        return self

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """It is declared, never guessed."""
        yield from ()

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is declared, never guessed."""
        yield from ()
