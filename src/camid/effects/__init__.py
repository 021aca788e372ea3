"""The catalogue of effects: one module per place, one class per effect."""

from camid.effects import actuator, disturbance, noise, plant, sensor
from camid.effects.base import PLACES, Effect, Parameter, Situation, compiled, known_effects

__all__ = [
    "PLACES",
    "Effect",
    "Parameter",
    "Situation",
    "actuator",
    "compiled",
    "disturbance",
    "known_effects",
    "noise",
    "plant",
    "sensor",
]
