"""Effects of the camera on what is read from its image: range, zero, sign and centroid."""

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


# Exponents of the speed from which a search starts.
FIRST_EXPONENT, EXPONENTS = 0.5, (0.7, 1.4)


class Clipping(Effect):
    """The marker leaves the field of view, or the image its range of values."""

    identifier = "clipping"
    place = "sensor"
    acts_on_reading = True
    title = "Clipping of the measurement"
    equation = r"w = \max(c_-,\ \min(w,\ c_+))"
    reference = "Ljung (1999), System Identification, 2nd ed., section 14.1"
    parameters = (
        Parameter("low", "y", "smallest value c₋"),
        Parameter("high", "y", "largest value c₊"),
    )
    separated_by = (SeparatingExperiment.SCALE_IN_THE_IMAGE,)

    def observe(self, output: Array, time: Array) -> Array:
        """Clip."""
        return np.clip(output, self.values["low"], max(self.values["high"], self.values["low"]))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Edges inside the simulated range, at either side or both, and where the recorded values end."""
        position, recorded = situation.position, situation.recorded
        low, high = float(np.min(position)), float(np.max(position))
        span = (high - low) or 1.0
        far_low, far_high = low - span, high + span
        edges = [
            (float(np.quantile(recorded, 0.01)), float(np.quantile(recorded, 0.99))),
            (float(np.quantile(recorded, 0.005)), far_high),
            (far_low, float(np.quantile(recorded, 0.995))),
        ]
        for share in (0.95, 0.85, 0.7):
            near_low, near_high = high - share * span, low + share * span
            edges += [(near_low, near_high), (far_low, near_high), (near_low, far_high)]
        for edge_low, edge_high in edges:
            # An edge outside of the motion does nothing, wherever it is.
            neutral = (min(low, edge_low), max(high, edge_high))
            yield cls(low=edge_low, high=edge_high).measured_from(*neutral)


class SensorOffset(Effect):
    """The zero of the image is not the plant's position of rest."""

    identifier = "sensor-offset"
    place = "sensor"
    acts_on_reading = True
    title = "Offset of the measurement"
    equation = r"w = y + b"
    reference = "Ljung (1999), System Identification, 2nd ed., section 14.1"
    parameters = (Parameter("offset", "y", "offset b"),)
    separated_by = (SeparatingExperiment.REVERSED_INPUT,)
    strength = "offset"
    is_constant = True

    def observe(self, output: Array, time: Array) -> Array:
        """Add the offset."""
        return output + self.values["offset"]

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to it."""
        yield cls(offset=0.02 * situation.largest("position"))


class AbsoluteValue(Effect):
    """The sensor knows the distance from its zero, not the direction."""

    identifier = "absolute-value"
    place = "sensor"
    title = "Sensor without sign"
    equation = r"w = |y|"
    reference = "Wigren & Schoukens (2017), Coupled electric drives data set (pulse counters without sign)"
    parameters = ()
    bends_coefficients = True
    separated_by = (SeparatingExperiment.SCALE_IN_THE_IMAGE,)

    def observe(self, output: Array, time: Array) -> Array:
        """Drop the sign."""
        return np.abs(output)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """There is one."""
        yield cls()


class SpeedWeightedCentroid(Effect):
    """The centroid of a blurred marker whose contour counts for the speed at which it passes."""

    identifier = "speed-weighted-centroid"
    place = "sensor"
    title = "Speed-weighted centroid"
    drawn_against = "rate"
    equation = r"w_k = \int y\,|\dot y|\,\mathrm{d}t \ /\ \int |\dot y|\,\mathrm{d}t"
    reference = "Laroche & Delavigne, equation (2)"
    parameters: ClassVar[tuple[Parameter, ...]] = ()

    def measure(self, motion: Motion, start: Array, end: Array) -> Array | None:
        """Mean over the path in the exposure instead of over its time."""
        return motion.mean_over_path(start, end)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """The speed itself, and half of its power; an instant sensor has none.

        A contour that counts for little more than the others may be nearer to the mean over the time than to this.
        """
        if situation.acquisition.sensor == "camera":
            yield cls()
            yield GradedSpeedWeightedCentroid(exponent=FIRST_EXPONENT).measured_from(0.0)


class GradedSpeedWeightedCentroid(SpeedWeightedCentroid):
    """The centroid of a blurred marker whose contour counts for a power of its speed.

    A gradient that saturates, or a threshold on it, makes a fast contour count for less or for more than its speed.
    """

    title = "Centroid weighted with a power of the speed"
    equation = r"w_k = \int y\,|\dot y|^p\,\mathrm{d}t \ /\ \int |\dot y|^p\,\mathrm{d}t"
    parameters = (Parameter("exponent", "", "power p of the speed; 1 is its own", 0.0, 3.0, scale="one"),)

    def measure(self, motion: Motion, start: Array, end: Array) -> Array | None:
        """Mean over the exposure, weighted."""
        return motion.mean_over_path(start, end, self.values["exponent"])

    def simplified(self) -> SpeedWeightedCentroid:
        """Weighted with the speed itself."""
        return SpeedWeightedCentroid()

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From a contour that counts for less than its speed, and from one that counts for more."""
        for exponent in EXPONENTS:
            yield cls(exponent=exponent)
