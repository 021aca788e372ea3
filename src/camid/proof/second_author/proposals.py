"""Laws to conceal in a rig: each draws its shape once, and then has a size between 0 and 1."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .excitations import TWO_LEVELS, Generator
from .laws import CATALOGUE, Law, Parameters
from .rigs import Rig


@dataclass(frozen=True)
class Situation:
    """How far and how fast a rig moves without anything concealed: what the size of a law is measured against."""

    position: float  # y, largest distance from rest
    velocity: float  # y/s, root mean square
    force: float  # u, largest input, or what a free decay's spring does at its largest distance
    duration: float  # s
    grid: float  # s, step of the integration


Sized = Callable[[float], Parameters]


def _log(rng: Generator, low: float, high: float) -> float:
    """Return a number that is equally likely in each part of a logarithmic scale."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _sign(rng: Generator) -> float:
    """Return plus or minus one."""
    return 1.0 if rng.random() < 0.5 else -1.0


def _actuator(identifier: str, rng: Generator, rig: Rig, now: Situation) -> Sized | None:
    """Return the laws of an actuator."""
    force, period = now.force, rig.period
    sign = _sign(rng)
    laws: dict[str, Sized] = {
        "actuator-lag": lambda size: {"time_constant": size * 0.8 * rig.pace},
        "backlash": lambda size: {"half_width": size * 0.3 * force},
        "dead-zone": lambda size: {"half_width": size * 0.4 * force},
        "gain-asymmetry": lambda size: {"ratio": 1.0 - 0.5 * size if sign > 0 else 1.0 + 0.6 * size},
        "input-bias": lambda size: {"bias": sign * size * 0.4 * force},
        "rate-limit": lambda size: {"rate": force / (12.0 * size * period)},
        "saturation": lambda size: {"limit": force * (1.0 - 0.7 * size)},
        "input-hold": lambda _: {"hold": "zoh" if rig.straight else "foh"},
    }
    return laws.get(identifier)


def _friction(identifier: str, rng: Generator, now: Situation) -> Sized | None:
    """Return the laws of dry friction."""
    force, ratio, excess = now.force, float(rng.uniform(0.2, 0.6)), float(rng.uniform(1.4, 2.2))
    slow = float(rng.uniform(0.1, 0.5)) * now.velocity
    sign = _sign(rng)
    load = float(rng.uniform(0.5, 2.0))
    laws: dict[str, Sized] = {
        "coulomb-friction": lambda size: {"force": 0.4 * size * force},
        "asymmetric-friction": lambda size: {
            "forward": 0.4 * size * force * (1.0 if sign > 0 else ratio),
            "backward": 0.4 * size * force * (1.0 if sign < 0 else ratio),
        },
        "load-dependent-friction": lambda size: {"force": 0.1 * size * force, "coefficient": 0.2 * load * size},
        "position-dependent-friction": lambda size: {
            "force": 0.2 * size * force,
            "gradient": sign * 0.2 * size * force / now.position,
        },
        "stribeck-friction": lambda size: {
            "coulomb": 0.25 * size * force,
            "breakaway": 0.25 * size * force * excess,
            "velocity": slow,
        },
    }
    return laws.get(identifier)


def _springs(identifier: str, rng: Generator, rig: Rig, now: Situation) -> Sized | None:
    """Return the laws that depend on the position, on the speed, or on both."""
    far, fast, force = now.position, now.velocity, now.force
    stiffness = rig.stiffness if rig.stiffness > 0.0 else force / far
    sign = _sign(rng)
    share, phase = float(rng.uniform(0.4, 1.2)), float(rng.uniform(-np.pi, np.pi))
    start, shape = sign * float(rng.uniform(0.45, 0.85)), float(rng.uniform(2.0, 10.0))
    laws: dict[str, Sized] = {
        "cogging": lambda size: {"amplitude": 0.4 * size * force, "period": share * far, "phase": phase},
        "cubic-stiffness": lambda size: {
            "coefficient": size * stiffness / far**2 * (1.0 if sign > 0 and not rig.integrates else -0.25)
        },
        "quadratic-stiffness": lambda size: {"coefficient": sign * 0.35 * size * stiffness / far},
        "end-stop": lambda size: {"position": start * far, "stiffness": 15.0 * size * stiffness},
        "hysteresis": lambda size: {"strength": 0.4 * size * force, "shape": shape / far},
        "pendulum-gravity": lambda size: {"amplitude": far / (1.7 * np.sqrt(size))},
        "quadratic-drag": lambda size: {"coefficient": 0.6 * size * force / fast**2},
        "amplitude-dependent-damping": lambda size: {"coefficient": 2.0 * size * force / (far**2 * fast)},
        "square-root-outflow": lambda size: {"coefficient": 0.6 * size * force / np.sqrt(far), "below": "none"},
        "overflow": lambda size: {"height": far * (1.0 - 0.5 * size), "share": 0.0, "below": "none"},
    }
    return laws.get(identifier)


def _dynamics(identifier: str, rng: Generator, rig: Rig, now: Situation) -> Sized | None:
    """Return modes, drifts and disturbances."""
    natural, sign = 1.0 / rig.pace, _sign(rng)
    damping, factor = _log(rng, 0.02, 0.2), float(rng.uniform(2.5, 6.0))
    phase, frequency = float(rng.uniform(-np.pi, np.pi)), natural * _log(rng, 0.3, 2.0)
    onset = rig.start + now.grid * round(float(rng.uniform(0.2, 0.75)) * now.duration / now.grid)
    choices = ["stiffness", "gain"] if rig.order == 1 else ["stiffness", "damping", "gain"]
    if not rig.driven:
        choices = ["stiffness", "damping"]
    if rig.integrates:
        choices = ["damping", "gain"]
    coefficient = str(rng.choice(choices))
    laws: dict[str, Sized] = {
        "extra-mode": lambda size: {"natural_frequency": natural * 2.5 / size, "damping": damping},
        "parallel-mode": lambda size: {
            "gain": 0.4 * size * rig.numerator[-1] / max(rig.denominator[-1], 1e-300),
            "natural_frequency": natural * factor,
            "damping": damping,
        },
        "parameter-drift": lambda size: {"coefficient": coefficient, "rate": sign * 0.5 * size / now.duration},
        "periodic-disturbance": lambda size: {
            "amplitude": 0.4 * size * now.force,
            "frequency": frequency,
            "phase": phase,
        },
        "step-disturbance": lambda size: {"size": sign * 0.6 * size * now.force, "time": onset},
        "impulse-disturbance": lambda size: {"size": sign * 1.5 * size * now.force * rig.pace, "time": onset},
    }
    return laws.get(identifier)


def _sensor(identifier: str, rng: Generator, rig: Rig, now: Situation) -> Sized | None:
    """Return the laws of a sensor."""
    far, period, sign = now.position, rig.period, _sign(rng)
    turn, phase = float(rng.uniform(0.5, 1.5)) * far, float(rng.uniform(-np.pi, np.pi))
    ratio = float(rng.uniform(0.3, 1.0))

    def exposure(size: float) -> Parameters:
        """Return another exposure than the declared one: shorter than a long one, longer than a short one."""
        declared = rig.exposure
        change = -0.95 * size * declared if declared > 0.5 * period else size * (period - declared)
        return {"exposure": declared + change}

    laws: dict[str, Sized] = {
        "absolute-value": lambda _: {},
        "speed-weighted-centroid": lambda _: {},
        "clipping": lambda size: {"low": -far * (1.0 - 0.7 * ratio * size), "high": far * (1.0 - 0.7 * size)},
        "clock-skew": lambda size: {"skew": sign * size * rig.pace / now.duration},
        "delay": lambda size: {"delay": 3.0 * size * period},
        "encoder-eccentricity": lambda size: {"amplitude": 0.1 * size * turn, "period": turn, "phase": phase},
        "exposure": exposure,
        "lens-distortion": lambda size: {"k1": sign * 0.25 * size / far**2},
        "perspective": lambda size: {"obliqueness": sign * 0.3 * size / far},
        "rolling-shutter": lambda size: {"time_per_unit": sign * min(size * period, 0.3 * far / now.velocity) / far},
        "sensor-drift": lambda size: {"rate": sign * 0.6 * size * far / now.duration},
        "sensor-offset": lambda size: {"offset": sign * size * far},
    }
    return laws.get(identifier)


def catalogue_law(identifier: str, rng: Generator, rig: Rig, now: Situation) -> Callable[[float], Law]:
    """Return a law of the catalogue as a function of its size; it is nearly none at 0, and strong at 1."""
    sized = (
        _actuator(identifier, rng, rig, now)
        or _friction(identifier, rng, now)
        or _springs(identifier, rng, rig, now)
        or _dynamics(identifier, rng, rig, now)
        or _sensor(identifier, rng, rig, now)
    )
    if sized is None:
        raise KeyError(identifier)

    def law(size: float) -> Law:
        """Return the law of that size."""
        return Law(identifier, CATALOGUE[identifier], "catalogue", {
            name: value if isinstance(value, str) else float(value) for name, value in sized(size).items()
        })  # fmt: skip

    return law


_OSCILLATORS = {"spring carriage", "damped stage", "two masses"}
_STATIC = {"dead-zone", "saturation", "gain-asymmetry", "command-levels", "power-law-gain"}
_OUTSIDE_ACTUATOR = {"command-levels", "power-law-gain", "missed-commands", "thermal-fade"}
_MOTION = {
    *("coulomb-friction", "asymmetric-friction", "position-dependent-friction", "stribeck-friction", "hysteresis"),
    *("load-dependent-friction", "quadratic-drag", "amplitude-dependent-damping", "cogging", "one-sided-damper"),
    *("centrifugal-force", "eddy-brake"),
}


def suits(identifier: str, rig: Rig, excitation: str) -> bool:
    """Return whether a law, of the catalogue or not, makes sense in a rig under an excitation."""
    name = rig.name
    where: dict[str, bool] = {
        "input-hold": rig.controller is None and rig.driven and excitation not in TWO_LEVELS,
        "square-root-outflow": name == "tank",
        "overflow": name == "tank",
        "pendulum-gravity": name in {"spring carriage", "free decay"},
        "end-stop": name not in {"tank", "heater"},
        "extra-mode": name in {"spring carriage", "damped stage"} and rig.initial is None,
        "parallel-mode": name == "spring carriage",
        "exposure": rig.kind == "camera" and excitation != "free decay",
        "speed-weighted-centroid": rig.kind == "camera" and rig.exposure >= 0.7 * rig.period,
        "absolute-value": name == "motor position" and rig.exposure <= rig.period,
        "input-bias": (rig.controller is not None or name in {"motor position", "spring carriage"}),
        "sensor-offset": rig.pendulum is None and name != "motor position",
        "clock-skew": rig.driven,
        "cubic-stiffness": name in {*_OSCILLATORS, "free decay", "heater", "pendulum"},
        "quadratic-stiffness": name in {*_OSCILLATORS, "free decay", "heater"},
        "parameter-drift": rig.pendulum is None and name != "two masses",
        "freeplay-spring": name in {*_OSCILLATORS, "free decay"},
        "relaxing-spring": name in {*_OSCILLATORS},
        "pumped-stiffness": name in {*_OSCILLATORS, "free decay"},
        "fading-force": name in {*_OSCILLATORS, "servo"},
        "missed-commands": name in {*_OSCILLATORS, "motor position", "heater"},
    }
    place = CATALOGUE.get(identifier, "")
    driving = place == "actuator" or identifier in _OUTSIDE_ACTUATOR
    senses = place == "sensor" or identifier in {"bumped-camera", "breathing-scale"}
    refused = (
        rig.one_sided and identifier in {"gain-asymmetry", "dead-zone", "quadratic-stiffness"},
        not rig.driven and (driving or identifier == "load-dependent-friction"),
        rig.straight and driving and identifier != "input-hold",
        excitation in TWO_LEVELS and identifier in _STATIC,
        rig.order == 1 and identifier in _MOTION,
        rig.controller is not None and senses,
    )
    return not any(refused) and where.get(identifier, True)
