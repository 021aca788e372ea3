"""Which concealed recordings there are: the mix of effects, places and laws."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from camid.proof.concealed import (
    actuator_laws,
    changing_laws,
    disturbance_laws,
    outside_laws,
    plant_laws,
    reading_laws,
    sensor_laws,
    way_laws,
)
from camid.proof.concealed.excitations import KINDS, MANY_LEVELS
from camid.proof.concealed.rig_setup import Context, Effect

Law = Callable[[np.random.Generator, Context, bool], Effect]


@dataclass(frozen=True)
class Family:
    """One effect with all its laws.

    Attributes
    ----------
    law : callable
        Draws an effect for a context; its last argument asks for another law than the catalogue's.
    place : str
    alternatives : bool
        Whether there is another law.
    any_order : bool
        Whether it can be put into machines of any order, not only into a mass on a spring.
    storage : bool
        Whether it belongs to a machine of first order.
    instant : bool
        Whether it belongs to a sensor that is no camera.
    excitations : tuple of str
        Inputs that show it.
    """

    law: Law
    place: str
    alternatives: bool = True
    any_order: bool = True
    excitations: tuple[str, ...] = KINDS
    storage: bool = False
    instant: bool = False


CATALOGUE: dict[str, Family] = {
    "dead-zone": Family(actuator_laws.dead_zone, "actuator", excitations=MANY_LEVELS),
    "saturation": Family(actuator_laws.saturation, "actuator", excitations=MANY_LEVELS),
    "backlash": Family(actuator_laws.backlash, "actuator", excitations=MANY_LEVELS),
    "rate-limit": Family(actuator_laws.rate_limit, "actuator"),
    "actuator-lag": Family(actuator_laws.actuator_lag, "actuator"),
    "gain-asymmetry": Family(actuator_laws.gain_asymmetry, "actuator", alternatives=False),
    "input-hold": Family(actuator_laws.input_hold, "actuator"),
    "input-bias": Family(actuator_laws.input_bias, "actuator", alternatives=False),
    "input-quantisation": Family(actuator_laws.input_quantisation, "actuator", excitations=MANY_LEVELS),
    "position-dependent-gain": Family(way_laws.position_dependent_gain, "actuator", False, False),
    "coulomb-friction": Family(plant_laws.coulomb_friction, "plant", any_order=False),
    "stribeck-friction": Family(plant_laws.stribeck_friction, "plant", any_order=False),
    "quadratic-drag": Family(plant_laws.quadratic_drag, "plant", any_order=False),
    "cubic-stiffness": Family(plant_laws.cubic_stiffness, "plant", any_order=False),
    "quadratic-stiffness": Family(plant_laws.quadratic_stiffness, "plant", any_order=False),
    "pendulum-gravity": Family(plant_laws.pendulum_gravity, "plant", any_order=False),
    "end-stop": Family(plant_laws.end_stop, "plant", any_order=False),
    "hysteresis": Family(plant_laws.hysteresis, "plant", any_order=False),
    "extra-mode": Family(plant_laws.extra_mode, "plant", any_order=False),
    "parameter-drift": Family(plant_laws.parameter_drift, "plant", any_order=False),
    "asymmetric-friction": Family(way_laws.asymmetric_friction, "plant", False, False),
    "position-dependent-friction": Family(way_laws.position_dependent_friction, "plant", any_order=False),
    "load-dependent-friction": Family(way_laws.load_dependent_friction, "plant", False, False, MANY_LEVELS),
    "amplitude-dependent-damping": Family(way_laws.amplitude_dependent_damping, "plant", any_order=False),
    "cogging": Family(way_laws.cogging, "plant", any_order=False),
    "parallel-mode": Family(way_laws.parallel_mode, "plant", any_order=False),
    "output-backlash": Family(way_laws.output_backlash, "plant", alternatives=False),
    "square-root-outflow": Family(way_laws.square_root_outflow, "plant", storage=True),
    "overflow": Family(way_laws.overflow, "plant", storage=True),
    "periodic-disturbance": Family(disturbance_laws.periodic_disturbance, "disturbance"),
    "step-disturbance": Family(disturbance_laws.step_disturbance, "disturbance", alternatives=False),
    "impulse-disturbance": Family(disturbance_laws.impulse_disturbance, "disturbance"),
    "exposure": Family(sensor_laws.exposure, "sensor", alternatives=False),
    "delay": Family(sensor_laws.delay, "sensor"),
    "rolling-shutter": Family(sensor_laws.rolling_shutter, "sensor", alternatives=False),
    "clock-skew": Family(sensor_laws.clock_skew, "sensor", alternatives=False),
    "timestamp-jitter": Family(sensor_laws.timestamp_jitter, "sensor", alternatives=False),
    "lens-distortion": Family(sensor_laws.lens_distortion, "sensor"),
    "perspective": Family(sensor_laws.perspective, "sensor", alternatives=False),
    "encoder-eccentricity": Family(sensor_laws.encoder_eccentricity, "sensor"),
    "clipping": Family(reading_laws.clipping, "sensor"),
    "quantisation": Family(reading_laws.quantisation, "sensor", alternatives=False),
    "sensor-offset": Family(reading_laws.sensor_offset, "sensor", alternatives=False),
    "sensor-drift": Family(reading_laws.sensor_drift, "sensor", alternatives=False),
    "dropped-frames": Family(reading_laws.dropped_frames, "sensor"),
    "outliers": Family(reading_laws.outliers, "sensor"),
    "absolute-value": Family(reading_laws.absolute_value, "sensor"),
    "speed-weighted-centroid": Family(sensor_laws.speed_weighted_centroid, "sensor"),
    "sensor-oscillation": Family(reading_laws.sensor_oscillation, "sensor"),
    "late-command": Family(sensor_laws.late_command, "sensor", alternatives=False),
    "input-pickup": Family(reading_laws.input_pickup, "sensor", alternatives=False, instant=True),
    "coloured-noise": Family(reading_laws.coloured_noise, "noise"),
    # In images noise that changes with the position is common, and has no name.
    "multiplicative-noise": Family(reading_laws.multiplicative_noise, "noise", alternatives=False, instant=True),
}

OUTSIDE: dict[str, Family] = {
    "nonlinear-hidden-mass": Family(outside_laws.nonlinear_hidden_mass, "plant", False, False),
    "saturating-back-electromotive-force": Family(outside_laws.back_electromotive_force, "actuator", False, False),
    "viscoelastic-damping": Family(outside_laws.viscoelastic_damping, "plant", False, False),
    "force-ripple": Family(outside_laws.force_ripple, "actuator", False, False),
    # A command of two levels is always as hot, and as hungry.
    "heating-winding": Family(changing_laws.heating_winding, "actuator", False, True, MANY_LEVELS),
    "reluctance-force": Family(changing_laws.reluctance_force, "actuator", False, False, MANY_LEVELS),
    "travelling-wave": Family(changing_laws.travelling_wave, "plant", False, False),
    "swinging-stiffness": Family(changing_laws.swinging_stiffness, "plant", False, False),
    "sagging-supply": Family(changing_laws.sagging_supply, "sensor", False, True, MANY_LEVELS),
}

# Present in the machine, but this recording does not show it: levels that a two-level input never tells from a gain,
# stops and edges that are out of reach.
INVISIBLE = ("dead-zone", "saturation", "backlash", "end-stop", "clipping")
TWO_LEVELS_HIDE = ("dead-zone", "saturation", "backlash")

# What shares the input's or the camera's timing with others, or needs a sensor of its own, is concealed alone.
ALONE = {"absolute-value", "speed-weighted-centroid", "input-hold", "late-command", "input-pickup"}
ALONE |= {"coloured-noise", "multiplicative-noise"}

# Shares of the kinds in percent; what is left are single effects.
SHARES = {"none": 40.0, "several": 15.0, "outside-20": 8.0, "outside-40": 8.0, "invisible": 4.0}
SMALL_SHARES = {"none": 25.0, "several": 12.5, "outside-20": 8.3, "outside-40": 8.3, "invisible": 4.2}
LARGE_PLAN = 500


@dataclass(frozen=True)
class Case:
    """One recording to be made; the machine, the input and the sizes are drawn when it is made.

    Attributes
    ----------
    seed, index : int
        Of the plan, and within it.
    kind : {"none", "single", "several", "outside", "invisible"}
    effects : tuple of str
        Identities of what is concealed.
    snr_db : float or None
        Signal-to-noise ratio of effects outside the catalogue, 20 or 40 dB; None: drawn when it is made.
    """

    seed: int
    index: int
    kind: str
    effects: tuple[str, ...] = ()
    snr_db: float | None = None


def plan(seed: int, count: int) -> list[Case]:
    """The cases of a study, in an order that mixes the kinds.

    Parameters
    ----------
    seed : int
        Other seeds give other cases of the same mix.
    count : int
        From `LARGE_PLAN` cases on, 40 % have nothing concealed; a small sample has relatively more effects.

    Returns
    -------
    list of Case, length count

    Raises
    ------
    ValueError
        If the count is negative.
    """
    if count < 0:
        raise ValueError(f"count = {count}: it must not be negative")
    generator = np.random.default_rng(np.random.SeedSequence([seed, count, 1]))
    shares = SHARES if count >= LARGE_PLAN else SMALL_SHARES
    numbers = {kind: round(share * count / 100.0) for kind, share in shares.items()}
    numbers["single"] = max(count - sum(numbers.values()), 0)
    entries: list[tuple[str, tuple[str, ...], float | None]] = [("none", (), None)] * numbers["none"]
    entries += [("single", (name,), None) for name in _spread(generator, tuple(CATALOGUE), numbers["single"])]
    entries += [("several", _several(generator, i), None) for i in range(numbers["several"])]
    for snr in (20.0, 40.0):
        names = _spread(generator, tuple(OUTSIDE), numbers[f"outside-{snr:.0f}"])
        entries += [("outside", (name,), snr) for name in names]
    entries += [("invisible", (name,), None) for name in _spread(generator, INVISIBLE, numbers["invisible"])]
    order = generator.permutation(len(entries))[:count]
    return [Case(seed, index, *entries[i]) for index, i in enumerate(order)]


def _spread(generator: np.random.Generator, names: tuple[str, ...], count: int) -> list[str]:
    """Names in random order, each as often as any other, except for one."""
    rounds = [generator.permutation(np.array(names)) for _ in range(count // len(names) + 1)]
    return [str(name) for name in np.concatenate(rounds)[:count]]


def _several(generator: np.random.Generator, number: int) -> tuple[str, ...]:
    """Two effects, or every fourth time three, of different places; every fifth time coloured noise and another."""
    names = [name for name in CATALOGUE if name not in ALONE]
    if number % 5 == 4:
        return (str(generator.choice(np.array(names))), "coloured-noise")
    chosen: list[str] = []
    for name in generator.permutation(np.array(names)):
        if all(CATALOGUE[name].place != CATALOGUE[other].place for other in chosen):
            chosen.append(str(name))
        if len(chosen) == (3 if number % 4 == 3 else 2):
            break
    return tuple(chosen)
