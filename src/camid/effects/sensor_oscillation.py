"""A reading with a hum of its own: the mains in an analogue cable, or a camera that sways.

A periodic force leaves the same behind a linear plant, but for how it begins: from rest, it moves the plant out of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import ClassVar

import numpy as np

from camid.effects.base import Array, Effect
from camid.effects.disturbance import FEWEST_PERIODS
from camid.effects.extent import Extent
from camid.effects.parameter import Parameter
from camid.effects.residual_spectrum import highest_lines, phasor_at
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

# Spectral lines of the residual that are looked into.
LINES = 3
# Prior odds beside a periodic force: few cables hum, and few cameras sway, and many machines turn.
ODDS = 1.0 / 3.0


def oscillation_at(situation: Situation, angular: float) -> dict[str, float]:
    """Amplitude and phase at time zero of the sinusoid that the residual shows at an angular frequency in rad/s."""
    phasor = phasor_at(situation, angular, situation.time)
    return {"amplitude": float(abs(phasor)), "phase": float(np.angle(phasor))}


class SensorOscillation(Effect):
    """A sinusoid that is added to the reading, and moves nothing."""

    identifier = "sensor-oscillation"
    place = "sensor"
    title = "Oscillation of the measurement"
    drawn_against = "time"
    equation = r"w = y + a\,\sin(\omega t + \varphi)"
    reference = "Morrison (2016), Grounding and Shielding, 6th ed., chapter 6 (mains in cables)"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "y", "amplitude a", 0.0),
        Parameter("frequency", "rad/s", "angular frequency ω", 0.0, scale="resolution"),
        Parameter("phase", "rad", "phase φ at time zero", scale="one"),
    )
    # A force makes a body move that is held in no position.
    separated_by = (SeparatingExperiment.HELD_POSITIONS, SeparatingExperiment.REPEATED_INPUT)
    of_one_recording = True
    prior_odds = ODDS
    strength = "amplitude"
    trials = "frequencies"

    def observe(self, output: Array, time: Array) -> Array:
        """Add it."""
        amplitude, angular, phase = self.vector[:3]
        return output + amplitude * np.sin(angular * time + phase)

    def is_plausible(self, extent: Extent) -> bool:
        """Whether the recording holds enough periods."""
        return bool(self.values["frequency"] * extent.duration >= 2.0 * pi * FEWEST_PERIODS)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """The highest lines of the residual's spectrum."""
        for angular in highest_lines(situation, LINES):
            yield cls(frequency=angular, **oscillation_at(situation, angular))
