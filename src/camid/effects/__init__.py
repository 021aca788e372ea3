"""The catalogue of effects: one class per effect, in modules by place and kind."""

from camid.effects import (
    actuator,
    bristle_friction,
    damping,
    disturbance,
    drift,
    friction,
    gradual_dead_zone,
    gradual_friction,
    gradual_saturation,
    harmonics,
    hertz_contact,
    hysteresis,
    learned,
    modes,
    noise,
    overflow_over_weir,
    periodic_in_position,
    rate_limited_lag,
    sensor,
    sensor_drift,
    sensor_geometry,
    sensor_reading,
    stiffness,
    storage,
    two_term_springs,
)
from camid.effects.base import PLACES, Effect
from camid.effects.compiled_part import compiled
from camid.effects.curve import Curve, on_curve
from camid.effects.known import known_effects
from camid.effects.parameter import Parameter
from camid.effects.plant_force import motion_sign
from camid.effects.situation import Situation

__all__ = [
    "PLACES",
    "Curve",
    "Effect",
    "Parameter",
    "Situation",
    "actuator",
    "bristle_friction",
    "compiled",
    "damping",
    "disturbance",
    "drift",
    "friction",
    "gradual_dead_zone",
    "gradual_friction",
    "gradual_saturation",
    "harmonics",
    "hertz_contact",
    "hysteresis",
    "known_effects",
    "learned",
    "modes",
    "motion_sign",
    "noise",
    "on_curve",
    "overflow_over_weir",
    "periodic_in_position",
    "rate_limited_lag",
    "sensor",
    "sensor_drift",
    "sensor_geometry",
    "sensor_reading",
    "stiffness",
    "storage",
    "two_term_springs",
]
