"""What first guesses need of a recording, with positions counted in three ways."""

from __future__ import annotations

from dataclasses import dataclass

from camid.effects.base import Effect
from camid.effects.situation import Situation


@dataclass(frozen=True)
class Views:
    """What first guesses need of one recording, with positions counted in three ways.

    Attributes
    ----------
    reading : Situation
        As they were recorded.
    sensor : Situation
        From the sensor's zero, without its offset.
    plant : Situation
        As the plant's forces count them.
    """

    reading: Situation
    sensor: Situation
    plant: Situation

    def of(self, effect: type[Effect]) -> Situation:
        """As an effect sees them."""
        if effect.place != "sensor":
            return self.plant
        return self.reading if effect.acts_on_reading else self.sensor
