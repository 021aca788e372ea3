"""Effects of the camera on when it looks: exposure, delay, order of the rows and clock."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from camid.chain.acquisition import Acquisition
from camid.effects.base import Array, Effect
from camid.effects.extent import Extent
from camid.effects.parameter import Parameter
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

if TYPE_CHECKING:
    from camid.chain.motion import Motion

# Exposures below this share of the period are an instant.
INSTANT = 1e-6
# Rounds of the fixed point of a rolling shutter, and the change of the shift, in periods, that ends them.
MOST_ROUNDS, SETTLED_SHIFT = 60, 1e-6
# Delays beyond this many periods are not a latency but another recording.
LONGEST_DELAY = 1000.0


class Exposure(Effect):
    """The exposure is not the declared one."""

    identifier = "exposure"
    place = "sensor"
    title = "Exposure of the camera"
    drawn_against = "rate"
    equation = r"w_k = \frac{1}{\tau}\int_{t_k-\ell-\tau}^{t_k-\ell} y\,\mathrm{d}t"
    reference = "Laroche & Delavigne, equation (6)"
    parameters = (Parameter("exposure", "s", "exposure τ; 0 for an instant sensor", 0.0),)
    linear_dynamics = True
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
    drawn_against = "time shift"
    equation = r"w_k = w(t_k - \theta)"
    reference = "Ljung (1999), System Identification, 2nd ed., section 4.2"
    parameters = (Parameter("delay", "s", "delay θ beyond the declared latency"),)
    linear_dynamics = True
    separated_by = (SeparatingExperiment.FASTER_CAMERA,)
    corrects_declaration = True
    strength = "delay"

    def declare(self, acquisition: Acquisition) -> Acquisition:
        """A longer latency, or a shorter one down to zero; ValueError for one that no recording of the kind has."""
        if abs(self.values["delay"]) > LONGEST_DELAY * acquisition.period:
            raise ValueError(f"a delay of more than {LONGEST_DELAY:g} periods")
        return replace(acquisition, latency=max(acquisition.latency + self.values["delay"], 0.0))

    def is_plausible(self, extent: Extent) -> bool:
        """Only the difference of a delay and a lead shows."""
        return "late-command" not in extent.beside

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
        return None if np.any(situation.all_signals) else "without input a delay only shifts the start of the motion"


class RollingShutter(Effect):
    """Rows are read one after the other, so the marker's position decides when it is seen."""

    identifier = "rolling-shutter"
    place = "sensor"
    title = "Rolling shutter"
    drawn_against = "time shift over the position"
    equation = r"w_k = w(t_k + \rho\,w_k)"
    reference = "Liang, Chang & Chen (2008), IEEE Trans. Image Process. 17, 1323-1330"
    parameters = (Parameter("time_per_unit", "s/y", "readout time ρ for a unit of position"),)
    strength = "time_per_unit"

    def windows(self, motion: Motion, start: Array, end: Array) -> tuple[Array, Array]:
        """Exposures shifted by where the marker is then: a fixed point."""
        first, last = start, end
        period = float(np.median(np.diff(end)))
        shift = np.zeros(len(end))
        # Where the marker passes a row in nearly the time in which that is read, each round leaves much of the error.
        for _ in range(MOST_ROUNDS):
            found = np.clip(self.values["time_per_unit"] * motion.mean(start, end), -4.0 * period, 4.0 * period)
            settled = np.max(np.abs(found - shift), initial=0.0) < SETTLED_SHIFT * period
            shift, start, end = found, first + found, last + found
            if settled:
                break
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
    drawn_against = "time shift"
    equation = r"w_k = w((1 + \epsilon)\,t_k)"
    reference = "Moon, Skelly & Towsley (1999), Proc. IEEE INFOCOM, 227-234"
    parameters = (Parameter("skew", "", "relative rate ε", -0.5, 0.5),)
    separated_by = (SeparatingExperiment.REPEATED_INPUT,)
    strength = "skew"

    def windows(self, motion: Motion, start: Array, end: Array) -> tuple[Array, Array]:
        """Exposures at the camera's times."""
        shift = self.values["skew"] * end
        return start + shift, end + shift

    def ahead(self, time: Array) -> float:
        """What the shift comes to at the first and at the last frame."""
        return max(self.values["skew"] * float(time[0]), self.values["skew"] * float(time[-1]), 0.0)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """A share of a period over the recording: the effect is proportional to it."""
        for periods in (0.1, 1.0):
            yield cls(skew=periods * situation.acquisition.period / max(abs(situation.time[-1]), situation.duration))


class FrameSkew(ClockSkew):
    """The same, counted from the first row of a recording: the skew that a simulation declares under ``sensor``."""

    def windows(self, motion: Motion, start: Array, end: Array) -> tuple[Array, Array]:
        """Exposures at the camera's times, the first one as it is."""
        shift = self.values["skew"] * (end - end[0])
        return start + shift, end + shift

    def ahead(self, time: Array) -> float:
        """What the shift comes to at the last frame."""
        return max(self.values["skew"] * float(time[-1] - time[0]), 0.0)
