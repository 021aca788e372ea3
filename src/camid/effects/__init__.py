"""The catalogue of effects: one class per effect, in modules by place and kind."""

from camid.effects import (
    actuator,
    damping,
    disturbance,
    drift,
    friction,
    hysteresis,
    learned,
    modes,
    noise,
    periodic_in_position,
    sensor,
    sensor_geometry,
    sensor_reading,
    stiffness,
    storage,
)
from camid.effects.base import PLACES, Effect, known_effects
from camid.effects.compiled_part import compiled
from camid.effects.parameter import Parameter
from camid.effects.situation import Situation

__all__ = [
    "PLACES",
    "Effect",
    "Parameter",
    "Situation",
    "actuator",
    "compiled",
    "damping",
    "disturbance",
    "drift",
    "friction",
    "hysteresis",
    "known_effects",
    "learned",
    "modes",
    "noise",
    "periodic_in_position",
    "sensor",
    "sensor_geometry",
    "sensor_reading",
    "stiffness",
    "storage",
]
