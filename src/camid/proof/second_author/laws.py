"""What each law, of the catalogue or not, changes in the chain from the command to the measurement."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .quantities import Actuator, Force, Friction
from .rigs import Rig

Array = np.ndarray[Any, np.dtype[np.float64]]
Parameters = dict[str, float | str]

PLACES = {
    "actuator": "actuator-lag backlash dead-zone gain-asymmetry input-bias input-hold rate-limit saturation",
    "plant": "amplitude-dependent-damping asymmetric-friction cogging coulomb-friction cubic-stiffness end-stop "
    "extra-mode hysteresis load-dependent-friction overflow parallel-mode parameter-drift pendulum-gravity "
    "position-dependent-friction quadratic-drag quadratic-stiffness square-root-outflow stribeck-friction",
    "disturbance": "impulse-disturbance periodic-disturbance step-disturbance",
    "sensor": "absolute-value clipping clock-skew delay dropped-frames encoder-eccentricity exposure "
    "lens-distortion outliers perspective quantisation rolling-shutter sensor-drift sensor-offset "
    "speed-weighted-centroid timestamp-jitter",
    "noise": "coloured-noise",
}
CATALOGUE = {identifier: place for place, names in PLACES.items() for identifier in names.split()}
NOISE_LAWS = frozenset({"dropped-frames", "outliers", "quantisation", "timestamp-jitter", "coloured-noise"})


@dataclass(frozen=True)
class Law:
    """A law that acts on a rig: its id, place, name of the law ("catalogue" or another), and parameters in u, y, s."""

    identifier: str
    place: str
    law: str
    parameters: Parameters


@dataclass
class Sensing:
    """What is between the motion and the measured value without its noise; in seconds, and in the output's unit y."""

    exposure: float
    latency: float
    skew: float = 0.0
    rolling: float = 0.0  # s/y
    radial: tuple[float, float] = (0.0, 0.0)  # 1/y^2, 1/y^4
    obliqueness: tuple[float, float] = (0.0, 0.0)  # 1/y, 1/y^2
    eccentricity: tuple[float, float, float, float] = (0.0, 1.0, 0.0, 0.0)  # y, y, rad, second harmonic
    drift: tuple[float, float] = (0.0, 0.0)  # y/s, s after which it comes to rest (0: never)
    offset: float = 0.0
    bump: tuple[float, float] = (0.0, 0.0)  # y, s
    breathing: tuple[float, float] = (0.0, 1.0)  # relative change of the scale, rad/s
    clipping: tuple[float, float] = (-np.inf, np.inf)
    absolute: bool = False
    speed_weighted: bool = False


@dataclass
class Chain:
    """A rig with the numbers of all laws that act on it."""

    rig: Rig
    sensing: Sensing
    straight: bool
    actuator: Array = field(default_factory=lambda: np.zeros(len(Actuator)))
    force: Array = field(default_factory=lambda: np.zeros(len(Force)))
    friction: Array = field(default_factory=lambda: np.zeros(len(Friction)))
    periodic: list[tuple[float, float, float]] = field(default_factory=list)  # u, rad/s, rad
    steps: list[tuple[float, float, float]] = field(default_factory=list)  # u, s, s of rise
    impulses: list[tuple[float, float]] = field(default_factory=list)  # u s, s
    series: list[tuple[float, float]] = field(default_factory=list)  # rad/s, damping ratio
    parallel: list[tuple[float, float, float]] = field(default_factory=list)  # y/u, rad/s, damping ratio
    missed: tuple[float, int] = (0.0, 0)  # share of commands that are not heard, seed


# laws that set numbers of the actuator, the forces or the friction to their parameters, as they are
_DIRECT: dict[str, dict[str, Actuator | Force | Friction]] = {
    "actuator-lag": {"time_constant": Actuator.LAG, "second_time_constant": Actuator.SECOND_LAG},
    "backlash": {"half_width": Actuator.BACKLASH, "slope": Actuator.BACKLASH_SLOPE},
    "dead-zone": {"half_width": Actuator.DEAD_ZONE, "softness": Actuator.DEAD_ZONE_SOFTNESS},
    "input-bias": {"bias": Actuator.BIAS},
    "rate-limit": {"rate": Actuator.RATE, "softness": Actuator.RATE_SOFTNESS},
    "saturation": {"limit": Actuator.SATURATION, "rounded": Actuator.SATURATION_ROUNDED},
    "command-levels": {"distance": Actuator.LEVELS},
    "power-law-gain": {"excess": Actuator.POWER_EXCESS, "scale": Actuator.POWER_SCALE},
    "amplitude-dependent-damping": {"coefficient": Force.AMPLITUDE_DAMPING},
    "asymmetric-friction": {"forward": Friction.FORWARD, "backward": Friction.BACKWARD},
    "cogging": {
        "amplitude": Force.COGGING,
        "period": Force.COGGING_PERIOD,
        "phase": Force.COGGING_PHASE,
        "second": Force.COGGING_SECOND,
    },
    "cubic-stiffness": {"coefficient": Force.CUBIC, "fifth": Force.QUINTIC},
    "hysteresis": {"strength": Force.HYSTERESIS, "shape": Force.SHAPE, "exponent": Force.SHAPE_EXPONENT},
    "quadratic-drag": {"coefficient": Force.DRAG, "exponent": Force.DRAG_EXPONENT},
    "quadratic-stiffness": {"coefficient": Force.QUADRATIC},
    "square-root-outflow": {"coefficient": Force.OUTFLOW, "exponent": Force.OUTFLOW_EXPONENT},
    "freeplay-spring": {"stiffness": Force.GAP_STIFFNESS, "half_width": Force.GAP_WIDTH},
    "one-sided-damper": {"coefficient": Force.ONE_SIDED_DAMPING},
    "fading-force": {"coefficient": Force.FADING_GAIN},
    "centrifugal-force": {"coefficient": Force.CENTRIFUGAL},
    "eddy-brake": {"coefficient": Force.EDDY, "velocity": Force.EDDY_VELOCITY},
    "thermal-fade": {"coefficient": Force.HEAT, "time_constant": Force.HEAT_TIME},
    "relaxing-spring": {"stiffness": Force.RELAXING_STIFFNESS, "time_constant": Force.RELAXING_TIME},
    "pumped-stiffness": {"stiffness": Force.PUMP, "frequency": Force.PUMP_FREQUENCY},
}
# exponents of the catalogue's laws
_USUAL = {Force.DRAG_EXPONENT: 2.0, Force.STOP_EXPONENT: 1.0, Force.SHAPE_EXPONENT: 1.0, Force.OUTFLOW_EXPONENT: 0.5}
OUTSIDE = (
    *("command-levels", "power-law-gain", "freeplay-spring", "one-sided-damper", "fading-force", "centrifugal-force"),
    *("eddy-brake", "thermal-fade", "relaxing-spring", "pumped-stiffness", "missed-commands", "bumped-camera"),
    "breathing-scale",
)


def _number(law: Law, name: str, default: float = 0.0) -> float:
    """Return a parameter of a law."""
    return float(law.parameters.get(name, default))


def _friction(chain: Chain, law: Law) -> bool:
    """Set dry friction; return whether the law is one."""
    friction = chain.friction
    if law.law == "bristles":
        chain.force[Force.LUGRE_FORCE] = _number(law, "force")
        chain.force[Force.LUGRE_STIFFNESS] = _number(law, "stiffness")
        chain.force[Force.LUGRE_DAMPING] = _number(law, "damping")
        return True
    if law.identifier in {"coulomb-friction", "load-dependent-friction", "position-dependent-friction"}:
        friction[Friction.FORWARD] = friction[Friction.BACKWARD] = _number(law, "force")
        friction[Friction.GRADIENT] = _number(law, "gradient")
        friction[Friction.LOAD] = _number(law, "coefficient")
        return True
    if law.identifier == "stribeck-friction":
        friction[Friction.FORWARD] = friction[Friction.BACKWARD] = _number(law, "coulomb")
        friction[Friction.BREAKAWAY_EXCESS] = _number(law, "breakaway") - _number(law, "coulomb")
        friction[Friction.VELOCITY] = _number(law, "velocity")
        friction[Friction.LORENTZIAN] = float(law.law == "rational decay")
        return True
    return False


def _forces(chain: Chain, law: Law) -> bool:
    """Set a force that takes more than a copy; return whether the law is one."""
    rig, force = chain.rig, chain.force
    if law.identifier == "gain-asymmetry":
        chain.actuator[Actuator.NEGATIVE_GAIN_EXCESS] = _number(law, "ratio") - 1.0
    elif law.identifier == "end-stop":
        force[Force.STOP_POSITION] = _number(law, "position")
        force[Force.STOP_STIFFNESS] = _number(law, "stiffness")
        force[Force.STOP_EXPONENT] = _number(law, "exponent", 1.0)
    elif law.identifier == "pendulum-gravity":
        force[Force.SINE_AMPLITUDE] = _number(law, "amplitude")
        force[Force.SINE_STIFFNESS] = rig.stiffness
    elif law.identifier == "overflow":
        force[Force.CEILING] = _number(law, "height")
        force[Force.CEILING_ON] = 1.0
    elif law.identifier == "parameter-drift":
        rate = _number(law, "rate")
        force[Force.DRIFT_MEMORY] = _number(law, "memory")
        drifting = {
            "gain": (Force.GAIN_DRIFT, 1.0),
            "damping": (Force.DAMPING_DRIFT, rig.denominator[-2] / rig.numerator[-1]),
            "stiffness": (Force.STIFFNESS_DRIFT, rig.stiffness),
        }
        index, coefficient = drifting[str(law.parameters["coefficient"])]
        force[index] = rate * coefficient
    else:
        return False
    return True


def _additions(chain: Chain, law: Law) -> bool:
    """Set a mode, a disturbance or another hold; return whether the law is one."""
    if law.identifier == "extra-mode":
        chain.series.append((_number(law, "natural_frequency"), _number(law, "damping")))
    elif law.identifier == "parallel-mode":
        chain.parallel.append((_number(law, "gain"), _number(law, "natural_frequency"), _number(law, "damping")))
    elif law.identifier == "missed-commands":
        chain.missed = (_number(law, "share"), int(_number(law, "seed")))
    elif law.identifier == "periodic-disturbance":
        amplitude, frequency, phase = (_number(law, name) for name in ("amplitude", "frequency", "phase"))
        chain.periodic.append((amplitude, frequency, phase))
        if law.law != "catalogue":
            chain.periodic.append((amplitude * _number(law, "second"), 2.0 * frequency, 2.0 * phase))
    elif law.identifier == "step-disturbance":
        chain.steps.append((_number(law, "size"), _number(law, "time"), _number(law, "rise")))
    elif law.identifier == "impulse-disturbance":
        chain.impulses.append((_number(law, "size"), _number(law, "time")))
    elif law.identifier == "input-hold":
        chain.straight = law.parameters["hold"] == "foh"
    else:
        return False
    return True


def _sensor(chain: Chain, law: Law) -> None:
    """Set what the sensor does."""
    number = {name: float(value) for name, value in law.parameters.items() if not isinstance(value, str)}
    get = number.get
    changes: dict[str, dict[str, Any]] = {
        "absolute-value": {"absolute": True},
        "speed-weighted-centroid": {"speed_weighted": True},
        "clipping": {"clipping": (get("low", -np.inf), get("high", np.inf))},
        "clock-skew": {"skew": get("skew", 0.0)},
        "delay": {"latency": chain.sensing.latency + get("delay", 0.0)},
        "exposure": {"exposure": get("exposure", 0.0)},
        "encoder-eccentricity": {
            "eccentricity": (get("amplitude", 0.0), get("period", 1.0), get("phase", 0.0), get("second", 0.0))
        },
        "lens-distortion": {"radial": (get("k1", 0.0), get("k2", 0.0))},
        "perspective": {"obliqueness": (get("obliqueness", 0.0), get("curvature", 0.0))},
        "rolling-shutter": {"rolling": get("time_per_unit", 0.0)},
        "sensor-drift": {"drift": (get("rate", 0.0), get("memory", 0.0))},
        "sensor-offset": {"offset": get("offset", 0.0)},
        "bumped-camera": {"bump": (get("size", 0.0), get("time", 0.0))},
        "breathing-scale": {"breathing": (get("amplitude", 0.0), get("frequency", 1.0))},
    }
    if law.identifier not in changes and law.identifier not in NOISE_LAWS:
        raise KeyError(law.identifier)
    chain.sensing = replace(chain.sensing, **changes.get(law.identifier, {}))


def build(rig: Rig, laws: list[Law]) -> Chain:
    """Return a rig with the laws that act on it."""
    chain = Chain(rig, Sensing(rig.exposure, rig.latency, offset=rig.offset), rig.straight)
    for usual, exponent in _USUAL.items():
        chain.force[usual] = exponent
    if rig.pendulum is not None:
        chain.force[Force.PENDULUM] = rig.pendulum[0] ** 2
        chain.sensing.offset = rig.pendulum[3]
    for law in laws:
        if _friction(chain, law) or _forces(chain, law) or _additions(chain, law):
            continue
        if law.identifier in _DIRECT:
            for name, index in _DIRECT[law.identifier].items():
                if name in law.parameters:
                    array = {Actuator: chain.actuator, Force: chain.force, Friction: chain.friction}[type(index)]
                    array[index] = _number(law, name)
            continue
        _sensor(chain, law)
    return chain
