"""Effects of the camera's lens on where the image of the marker lies."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from camid.effects.base import Array, Effect
from camid.effects.extent import Extent
from camid.effects.parameter import Parameter
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

if TYPE_CHECKING:
    from camid.chain.motion import Motion

# How far from the plant's zero the image may have its centre, in the recorded way: the motion fills some of the image.
FARTHEST_CENTRE = 0.75
# Where it is at first, in the largest recorded position.
CENTRES = (-0.4, 0.4)
# A second coefficient at first, as a share of what the first one does at the largest position.
SECOND = (0.25, -0.25)


def _mean_of(image: Callable[[Array], Array], motion: Motion, start: Array, end: Array) -> Array:
    """Mean of an image of the position over exposures, shape (N,)."""
    from camid.chain.motion import WEIGHTS

    return np.asarray(image(motion.points(start, end)) @ (0.5 * WEIGHTS))


def _about(centre: float, image: Callable[[Array], Array], position: Array) -> Array:
    """The image of a position about another centre, from the image of the position zero."""
    return np.asarray(image(position - centre) - image(np.array(-centre)))


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
        return _mean_of(self.distorted, motion, start, end)

    def distorted(self, position: Array) -> Array:
        """Where the image of a position lies, in units of the output."""
        return np.asarray(position * (1.0 + self.values["k1"] * position**2))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to it."""
        yield cls(k1=0.02 / situation.largest("position") ** 2)


class LensDistortionOfFourthOrder(LensDistortion):
    """Radial distortion that two coefficients describe, as lenses of wide angle need."""

    title = "Lens distortion (two coefficients)"
    equation = r"w = y\,(1 + k_1 y^2 + k_2 y^4)"
    parameters = (*LensDistortion.parameters, Parameter("k2", "1/y^4", "second radial coefficient k₂"))

    def distorted(self, position: Array) -> Array:
        """Where the image of a position lies, in units of the output."""
        squares = position**2
        return np.asarray(position * (1.0 + self.values["k1"] * squares + self.values["k2"] * squares**2))

    def scaled(self, factor: float) -> LensDistortionOfFourthOrder:
        """Both coefficients in proportion."""
        return self.with_vector(self.vector * factor)

    def simplified(self) -> LensDistortion:
        """The first coefficient alone."""
        return LensDistortion(k1=self.values["k1"])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """The same about another centre."""
        return tuple(LensDistortionOfFourthOrderOffCentre.starts(situation, **self.values))

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """A second coefficient, of either sign, that does a quarter of what the first one does at the edge."""
        edge = situation.largest("position") ** 2
        for share in SECOND:
            yield cls(**{"k2": share * values["k1"] / edge, **values})

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a distortion that was found."""
        yield from ()


class LensDistortionOffCentre(LensDistortion):
    """Radial distortion about a centre of the image that is not where the plant rests, as cameras usually stand."""

    title = "Lens distortion (centre elsewhere)"
    equation = r"w = r\,(1 + k_1 r^2) + c\,(1 + k_1 c^2),\; r = y - c"
    parameters = (*LensDistortion.parameters, Parameter("centre", "y", "position c that the centre of the image shows"))

    def distorted(self, position: Array) -> Array:
        """Where the image of a position lies, in units of the output, from that of the plant's zero."""
        return _about(self.values["centre"], super().distorted, position)

    def is_plausible(self, extent: Extent) -> bool:
        """Whether a camera that films the motion can have its centre there."""
        return bool(abs(self.values["centre"]) <= FARTHEST_CENTRE * extent.span)

    def simplified(self) -> LensDistortion:
        """About the plant's zero."""
        return LensDistortion(k1=self.values["k1"])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """A second coefficient."""
        edge = situation.largest("position") ** 2
        return tuple(
            LensDistortionOfFourthOrderOffCentre(k2=share * self.values["k1"] / edge, **self.values) for share in SECOND
        )

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From centres on either side."""
        edge = situation.largest("position")
        yield from (cls(**{"centre": share * edge, **values}) for share in CENTRES)

    @classmethod
    def as_oblique_as(cls, obliqueness: float, edge: float) -> tuple[LensDistortionOffCentre, ...]:
        """Those with the square of the position that a view of some obliqueness has, about centres at either edge."""
        return tuple(cls(k1=obliqueness / (3.0 * centre), centre=centre) for centre in (-edge, edge))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a distortion, or an oblique view, that was found."""
        yield from ()


class LensDistortionOfFourthOrderOffCentre(LensDistortionOfFourthOrder):
    """Radial distortion of two coefficients about a centre of the image that is not where the plant rests."""

    title = "Lens distortion (two coefficients, centre elsewhere)"
    equation = r"w = r\,(1 + k_1 r^2 + k_2 r^4) + c\,(1 + k_1 c^2 + k_2 c^4),\; r = y - c"
    parameters = (*LensDistortionOfFourthOrder.parameters, LensDistortionOffCentre.parameters[-1])
    is_plausible = LensDistortionOffCentre.is_plausible

    def distorted(self, position: Array) -> Array:
        """Where the image of a position lies, in units of the output, from that of the plant's zero."""
        return _about(self.values["centre"], super().distorted, position)

    def scaled(self, factor: float) -> LensDistortionOfFourthOrderOffCentre:
        """Both coefficients in proportion."""
        return type(self)(**{**self.values, "k1": factor * self.values["k1"], "k2": factor * self.values["k2"]})

    def simplified(self) -> LensDistortion:
        """The first coefficient alone, about the same centre."""
        return LensDistortionOffCentre(k1=self.values["k1"], centre=self.values["centre"])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """None."""
        return ()

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From a distortion of two coefficients, of centres on either side; none from one of the first alone."""
        if "k2" in values:
            edge = situation.largest("position")
            yield from (cls(**{"centre": share * edge, **values}) for share in CENTRES)
