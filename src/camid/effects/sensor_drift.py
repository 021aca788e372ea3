"""A sensor whose zero wanders, at a constant rate or until what holds it is warm."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from camid.effects.base import Array, Effect
from camid.effects.drift import LEAST_TIME_CONSTANT, Settling
from camid.effects.parameter import Parameter
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

# Drift over the recording of a first guess, as a share of the largest displacement.
SIZE = 0.05


class SensorDrift(Effect):
    """The zero of the image wanders."""

    identifier = "sensor-drift"
    place = "sensor"
    title = "Drift of the measurement"
    drawn_against = "time"
    equation = r"w = y + r\,t"
    reference = "Ljung (1999), System Identification, 2nd ed., section 14.1"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("rate", "y/s", "rate r"),)
    separated_by = (SeparatingExperiment.REPEATED_INPUT,)
    of_one_recording = True
    strength = "rate"

    def observe(self, output: Array, time: Array) -> Array:
        """Add what has drifted."""
        return output + self.values["rate"] * time

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small, as the effect is proportional to it, at a constant rate, early on, or all at once.

        What settles within a fifth of the recording is no drift at a constant rate, and is not found by way of one.
        """
        drift = cls(rate=SIZE * situation.largest("position") / situation.duration)
        yield drift
        yield next(SettlingSensorDrift.starts(situation, **drift.values))
        for law in cls.finer_laws:
            yield from law.candidates(situation)

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """Of a clock that began long before, the drift is an offset."""
        return situation.far_from_zero


class SettlingSensorDrift(Settling, SensorDrift):
    """The zero of an image that wanders until the camera, or what holds it, is warm."""

    title = "Drift of the measurement that settles"
    equation = r"w = y + r\,\tau\,(1 - e^{-t/\tau})"
    reference = "Incropera et al. (2007), Fundamentals of Heat and Mass Transfer, 6th ed., section 5.1"
    parameters = (*SensorDrift.parameters, Parameter("time_constant", "s", "time constant τ", LEAST_TIME_CONSTANT))

    def observe(self, output: Array, time: Array) -> Array:
        """Add what has drifted."""
        constant = self.values["time_constant"]
        return np.asarray(output + self.values["rate"] * constant * (1.0 - np.exp(-time / constant)))

    def simplified(self) -> SensorDrift:
        """The same rate for ever."""
        return SensorDrift(rate=self.values["rate"])
