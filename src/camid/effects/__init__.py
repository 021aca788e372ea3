"""The catalogue of effects: one class per effect, in modules by place and kind."""

from camid.effects import (
    actuator,
    damping,
    disturbance,
    friction,
    modes,
    noise,
    periodic_in_position,
    plant,
    sensor,
    storage,
)
from camid.effects.base import PLACES, Effect, Parameter, Situation, compiled, known_effects

__all__ = [
    "PLACES",
    "Effect",
    "Parameter",
    "Situation",
    "actuator",
    "compiled",
    "damping",
    "disturbance",
    "friction",
    "known_effects",
    "modes",
    "noise",
    "periodic_in_position",
    "plant",
    "sensor",
    "storage",
]
