"""Effects of the camera: when it looks, what an exposure yields, and what becomes of the sample."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from camid.chain.acquisition import Acquisition
from camid.effects.base import Array, Effect, Parameter, Situation
from camid.effects.separating_experiment import SeparatingExperiment

if TYPE_CHECKING:
    from camid.chain.motion import Motion

# Exposures below this share of the period are an instant.
INSTANT = 1e-6


# Delays beyond this many periods are not a latency but another recording.
LONGEST_DELAY = 1000.0
# Smallest distance to the camera, in that of the centre.
NEAREST = 1e-3


class Exposure(Effect):
    """The exposure is not the declared one."""

    identifier = "exposure"
    place = "sensor"
    title = "Exposure of the camera"
    equation = r"w_k = \frac{1}{\tau}\int_{t_k-\ell-\tau}^{t_k-\ell} y\,\mathrm{d}t"
    reference = "Laroche & Delavigne, equation (6)"
    parameters = (Parameter("exposure", "s", "exposure τ; 0 for an instant sensor", 0.0),)
    separated_by = (SeparatingExperiment.FASTER_CAMERA,)
    corrects_declaration = True

    def bounds(self, acquisition: Acquisition) -> list[tuple[float, float]]:
        """From an instant to the period."""
        return [(0.0, acquisition.period)]

    def declare(self, acquisition: Acquisition) -> Acquisition:
        """The camera with this exposure, at most the period; periods of several recordings differ by a hair."""
        exposure = min(self.values["exposure"], acquisition.period)
        if exposure <= INSTANT * acquisition.period:
            return replace(acquisition, sensor="instant")
        return replace(acquisition, sensor="camera", exposure=exposure)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Several shares of the period, away from the declared one."""
        acquisition = situation.acquisition
        declared = 0.0 if acquisition.sensor == "instant" else float(acquisition.exposure or 0.0)
        for share in (0.05, 0.25, 0.5, 0.75, 1.0):
            exposure = share * acquisition.period
            if abs(exposure - declared) > 0.02 * acquisition.period:
                yield cls(exposure=exposure).measured_from(declared)


class Delay(Effect):
    """Transport delay or sensor latency, which input and output cannot tell apart."""

    identifier = "delay"
    place = "sensor"
    title = "Delay (transport delay or latency of the camera)"
    equation = r"w_k = w(t_k - \theta)"
    reference = "Ljung (1999), System Identification, 2nd ed., section 4.2"
    parameters = (Parameter("delay", "s", "delay θ beyond the declared latency"),)
    separated_by = (SeparatingExperiment.FASTER_CAMERA,)
    corrects_declaration = True
    strength = "delay"

    def declare(self, acquisition: Acquisition) -> Acquisition:
        """A longer latency, or a shorter one down to zero; ValueError for one that no recording of the kind has."""
        if abs(self.values["delay"]) > LONGEST_DELAY * acquisition.period:
            raise ValueError(f"a delay of more than {LONGEST_DELAY:g} periods")
        return replace(acquisition, latency=max(acquisition.latency + self.values["delay"], 0.0))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """From a share of a period to several, and back to no latency at all."""
        for periods in (0.05, 0.5, 1.0, 2.0, 4.0):
            yield cls(delay=periods * situation.acquisition.period)
        if situation.acquisition.latency > 0.0:
            for share in (-0.1, -0.5, -1.0):
                yield cls(delay=share * situation.acquisition.latency)

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """Without input there is nothing that it is late after."""
        return None if np.any(situation.signal) else "without input a delay only shifts the start of the motion"


class RollingShutter(Effect):
    """Rows are read one after the other, so the marker's position decides when it is seen."""

    identifier = "rolling-shutter"
    place = "sensor"
    title = "Rolling shutter"
    equation = r"w_k = w(t_k + \rho\,w_k)"
    reference = "Liang, Chang & Chen (2008), IEEE Trans. Image Process. 17, 1323-1330"
    parameters = (Parameter("time_per_unit", "s/y", "readout time ρ for a unit of position"),)
    strength = "time_per_unit"

    def windows(self, motion: Motion, start: Array, end: Array) -> tuple[Array, Array]:
        """Exposures shifted by where the marker is then: a fixed point."""
        first, last = start, end
        limit = 4.0 * float(np.median(np.diff(end)))
        for _ in range(3):
            shift = np.clip(self.values["time_per_unit"] * motion.mean(start, end), -limit, limit)
            start, end = first + shift, last + shift
        return start, end

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """A tenth of a period over the motion: the effect is proportional to it."""
        yield cls(time_per_unit=0.1 * situation.acquisition.period / situation.largest("position"))


class ClockSkew(Effect):
    """The camera's clock runs at another rate than that of the input."""

    identifier = "clock-skew"
    place = "sensor"
    title = "Clock skew between camera and input"
    equation = r"w_k = w((1 + \epsilon)\,t_k)"
    reference = "Moon, Skelly & Towsley (1999), Proc. IEEE INFOCOM, 227-234"
    parameters = (Parameter("skew", "", "relative rate ε", -0.5, 0.5),)
    separated_by = (SeparatingExperiment.REPEATED_INPUT,)
    strength = "skew"

    def windows(self, motion: Motion, start: Array, end: Array) -> tuple[Array, Array]:
        """Exposures at the camera's times."""
        shift = self.values["skew"] * end
        return start + shift, end + shift

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """A share of a period over the recording: the effect is proportional to it."""
        for periods in (0.1, 1.0):
            yield cls(skew=periods * situation.acquisition.period / max(abs(situation.time[-1]), situation.duration))


class LensDistortion(Effect):
    """Radial distortion: the image is larger, or smaller, away from its centre."""

    identifier = "lens-distortion"
    place = "sensor"
    title = "Lens distortion"
    equation = r"w = y\,(1 + k_1 y^2)"
    reference = "Brown (1966), Photogramm. Eng. 32, 444-462"
    parameters = (Parameter("k1", "1/y^2", "first radial coefficient k₁"),)
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


class SensorDrift(Effect):
    """The zero of the image wanders."""

    identifier = "sensor-drift"
    place = "sensor"
    title = "Drift of the measurement"
    equation = r"w = y + r\,t"
    reference = "Ljung (1999), System Identification, 2nd ed., section 14.1"
    parameters = (Parameter("rate", "y/s", "rate r"),)
    separated_by = (SeparatingExperiment.REPEATED_INPUT,)
    strength = "rate"

    def observe(self, output: Array, time: Array) -> Array:
        """Add what has drifted."""
        return output + self.values["rate"] * time

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to it."""
        yield cls(rate=0.05 * situation.largest("position") / situation.duration)

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """Of a clock that began long before, the drift is an offset."""
        return situation.far_from_zero


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
    equation = r"w_k = \int y\,|\dot y|\,\mathrm{d}t \ /\ \int |\dot y|\,\mathrm{d}t"
    reference = "Laroche & Delavigne, equation (2)"
    parameters = ()

    def measure(self, motion: Motion, start: Array, end: Array) -> Array | None:
        """Mean over the path in the exposure instead of over its time."""
        share = np.linspace(0.0, 1.0, 33)
        points = motion.at(start[:, None] + (end - start)[:, None] * share)
        lengths = np.abs(np.diff(points, axis=1))
        total = np.sum(lengths, axis=1)
        weighted = np.sum(0.5 * (points[:, 1:] + points[:, :-1]) * lengths, axis=1)
        still = total <= 1e-12 * max(float(np.max(np.abs(points))), 1e-300)
        return np.where(still, points[:, 0], weighted / np.where(still, 1.0, total))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """There is one; an instant sensor has none."""
        if situation.acquisition.sensor == "camera":
            yield cls()
