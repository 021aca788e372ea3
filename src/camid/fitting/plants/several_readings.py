"""A plant of equations that several columns of one sensor see: x and y of a marker, or several markers.

Each column of a run is an experiment of its own with what it reads of the states; they have the motion, the times and
the initial state in common, and each is weighted by its noise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.lens_distortion import LensDistortion
from camid.effects.perspective import Perspective
from camid.effects.sensor import RollingShutter
from camid.effects.situation import Situation
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.equations import EquationsKind
from camid.fitting.problem import Problem
from camid.fitting.views import Views
from camid.physical.equations import transfer_function_of

Array = NDArray[np.float64]

# What depends on where in the image the marker is, which one column does not say.
OF_THE_PLANE = (LensDistortion, Perspective, RollingShutter)


@dataclass(frozen=True)
class SeveralReadings(EquationsKind):
    """ẋ = f(x, u, constants), w_i = h_i(x)."""

    one_reading: ClassVar[bool] = False

    def recorded_positions(self, problem: Problem) -> list[Array]:
        """The simulated ones: no column holds the position itself."""
        nominal = Model(problem.structure.coefficients(), constants=self.constants())
        return [position for position, _ in problem.motion(problem.with_initial_states(nominal))]

    def seen_plant(self, problem: Problem, model: Model) -> TransferFunction:
        """From the input to what the first column reads, for small motions."""
        reads = replace(self.equations, output=self.equations.readings[0], readings=())
        return transfer_function_of(reads, self.values_of(model))

    def unseen(self, effect: type[Effect]) -> str | None:
        """What one column does not say."""
        if effect in OF_THE_PLANE:
            return "several columns read the states by expressions, and those say how a camera sees the plane"
        return super().unseen(effect)

    def situations(self, problem: Problem, model: Model, index: int) -> Views:
        """Forces depend on the simulated output of the equations, the sensor on what its column reads."""
        seen = super().situations(problem, model, index)
        position, velocity = problem.motion(model)[index]

        def at_plant(situation: Situation) -> Situation:
            return replace(situation, recorded=position, position=position, velocity=velocity)

        return Views(seen.reading, seen.sensor, at_plant(seen.plant))
