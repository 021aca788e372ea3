"""The catalogue of effects: a module a place, one class an effect."""

from camid.physics import actuator, disturbance, noise, plant, sensor  # registers their effects
from camid.physics.effect import PLACES, Effect, Parameter, Situation, compiled, known_effects

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
