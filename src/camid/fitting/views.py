"""What first guesses need of a recording, with positions counted in three ways."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from camid.effects.base import Array, Effect
from camid.effects.situation import Situation

if TYPE_CHECKING:
    from camid.fitting.plant_with_effects import Model
    from camid.fitting.problem import Problem


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
        As the plant's forces count them: without what effects of the sensor add.
    """

    reading: Situation
    sensor: Situation
    plant: Situation

    def of(self, effect: type[Effect]) -> Situation:
        """As an effect sees them."""
        if effect.place != "sensor":
            return self.plant
        return self.reading if effect.acts_on_reading else self.sensor


def added_by_sensor(problem: Problem, model: Model, index: int, simulated: Array) -> Array | None:
    """What a model's effects on the sensor add to the position in a recording, shape (N,); None where it has none.

    ``simulated``, shape (N,), is the reading that the model makes, from the sensor's zero.
    """
    if not any(effect.place == "sensor" for effect in model.effects):
        return None
    return simulated - problem.motion(model)[index][0]
