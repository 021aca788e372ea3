"""A camera that looks at the motion from the side."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from camid.effects.base import Array, Effect
from camid.effects.lens_distortion import LensDistortionOffCentre
from camid.effects.parameter import Parameter
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

if TYPE_CHECKING:
    from camid.chain.motion import Motion

# Smallest distance to the camera, in that of the centre.
NEAREST = 1e-3


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

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """A lens whose centre is far from where the plant rests: the image bends to one side there, too."""
        return LensDistortionOffCentre.as_oblique_as(self.values["obliqueness"], situation.largest("position"))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to it."""
        yield cls(obliqueness=0.02 / situation.largest("position"))
