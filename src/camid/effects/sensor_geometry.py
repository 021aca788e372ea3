"""Effects of the camera on where the image of the marker lies."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from camid.effects.base import Array, Effect
from camid.effects.parameter import Parameter
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

if TYPE_CHECKING:
    from camid.chain.motion import Motion

# Smallest distance to the camera, in that of the centre.
NEAREST = 1e-3


class LensDistortion(Effect):
    """Radial distortion: the image is larger, or smaller, away from its centre."""

    identifier = "lens-distortion"
    place = "sensor"
    title = "Lens distortion"
    equation = r"w = y\,(1 + k_1 y^2)"
    reference = "Brown (1966), Photogramm. Eng. 32, 444-462"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("k1", "1/y^2", "first radial coefficient k₁"),)
    separated_by = (SeparatingExperiment.HELD_POSITIONS, SeparatingExperiment.SCALE_IN_THE_IMAGE)
    strength = "k1"

    def measure(self, motion: Motion, start: Array, end: Array) -> Array | None:
        """Mean of the distorted position over the exposure."""
        from camid.chain.motion import WEIGHTS

        points = motion.points(start, end)
        return np.asarray((points * (1.0 + self.values["k1"] * points**2)) @ (0.5 * WEIGHTS))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to it."""
        yield cls(k1=0.02 / situation.largest("position") ** 2)


class LensDistortionOfFourthOrder(LensDistortion):
    """Radial distortion that two coefficients describe, as lenses of wide angle need."""

    title = "Lens distortion (two coefficients)"
    equation = r"w = y\,(1 + k_1 y^2 + k_2 y^4)"
    parameters = (*LensDistortion.parameters, Parameter("k2", "1/y^4", "second radial coefficient k₂"))

    def measure(self, motion: Motion, start: Array, end: Array) -> Array | None:
        """Mean of the distorted position over the exposure."""
        from camid.chain.motion import WEIGHTS

        points = motion.points(start, end)
        squares = points**2
        factor = 1.0 + self.values["k1"] * squares + self.values["k2"] * squares**2
        return np.asarray((points * factor) @ (0.5 * WEIGHTS))

    def scaled(self, factor: float) -> LensDistortionOfFourthOrder:
        """Both coefficients in proportion."""
        return self.with_vector(self.vector * factor)

    def simplified(self) -> LensDistortion:
        """The first coefficient alone."""
        return LensDistortion(k1=self.values["k1"])

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """A second coefficient, of either sign, that does a quarter of what the first one does at the edge."""
        edge = situation.largest("position") ** 2
        for share in (0.25, -0.25):
            yield cls(**{"k2": share * values["k1"] / edge, **values})

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a distortion that was found."""
        yield from ()


class Perspective(Effect):
    """The plane of the motion is not parallel to the image: what is nearer to the camera looks larger."""

    identifier = "perspective"
    place = "sensor"
    title = "Perspective (oblique view)"
    equation = r"w = \frac{y}{1 + c\,y}"
    reference = "Hartley & Zisserman (2004), Multiple View Geometry in Computer Vision, 2nd ed., section 2.3"
    parameters = (Parameter("obliqueness", "1/y", "relative change c of the distance with the position"),)
    separated_by = (SeparatingExperiment.HELD_POSITIONS, SeparatingExperiment.SCALE_IN_THE_IMAGE)
    strength = "obliqueness"

    def measure(self, motion: Motion, start: Array, end: Array) -> Array | None:
        """Mean of the projected position over the exposure."""
        from camid.chain.motion import WEIGHTS

        points = motion.points(start, end)
        # Behind the camera nothing is seen; a fit that tries it gets a large value and no infinite one.
        distance = np.maximum(1.0 + self.values["obliqueness"] * points, NEAREST)
        return np.asarray((points / distance) @ (0.5 * WEIGHTS))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to it."""
        yield cls(obliqueness=0.02 / situation.largest("position"))
