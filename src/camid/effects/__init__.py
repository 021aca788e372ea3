"""The catalogue of effects: a module a place, one class an effect."""

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
