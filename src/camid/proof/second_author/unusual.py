"""Laws that the catalogue lacks, and laws of the catalogue's names that are not exactly the catalogue's."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .excitations import Generator
from .laws import Law, Parameters
from .proposals import Situation, catalogue_law
from .rigs import Rig

# id of the catalogue and the name of another law for it
INEXACT: dict[str, str] = {
    "saturation": "hyperbolic tangent",
    "dead-zone": "rounded corner",
    "backlash": "gap that yields",
    "rate-limit": "rate that falls with the error",
    "actuator-lag": "second-order lag",
    "cubic-stiffness": "with a fifth power",
    "coulomb-friction": "bristles",
    "stribeck-friction": "rational decay",
    "end-stop": "Hertzian contact",
    "hysteresis": "squared transition",
    "quadratic-drag": "exponent 1.7",
    "cogging": "with a second harmonic",
    "square-root-outflow": "another exponent",
    "parameter-drift": "drift that comes to rest",
    "periodic-disturbance": "with a second harmonic",
    "step-disturbance": "ramp at the onset",
    "lens-distortion": "two terms",
    "sensor-drift": "drift that comes to rest",
    "encoder-eccentricity": "with a second harmonic",
    "perspective": "curved path",
}


def _bent(law: Law, rig: Rig, now: Situation, share: float) -> Parameters:
    """Return the parameters that make a law of the catalogue inexact; ``share`` is between 0 and 1."""
    number = {name: float(value) for name, value in law.parameters.items() if not isinstance(value, str)}
    inertia = 1.0 / rig.numerator[0] if rig.pendulum is None else 1.0 / (rig.pendulum[2] * rig.pendulum[0] ** 2)
    bristle = number.get("force", 0.0) / ((0.01 + 0.03 * share) * now.position)
    coefficient = number.get("coefficient", 0.0)
    exponent = 0.35 + 0.3 * share
    return {
        "coulomb-friction": {"stiffness": bristle, "damping": 0.6 * np.sqrt(bristle * inertia)},
        "cubic-stiffness": {"fifth": -0.5 * share * coefficient / now.position**2},
        "lens-distortion": {"k2": (share - 0.5) * number.get("k1", 0.0) / now.position**2},
        "perspective": {"curvature": 0.5 * share * abs(number.get("obliqueness", 0.0)) / now.position},
        "end-stop": {
            "exponent": 1.5,
            "stiffness": number.get("stiffness", 0.0) / np.sqrt(0.3 * abs(number.get("position", 1.0))),
        },
        "actuator-lag": {"second_time_constant": (0.3 + 0.6 * share) * number.get("time_constant", 0.0)},
        "saturation": {"rounded": 1.0},
        "dead-zone": {"softness": (0.1 + 0.2 * share) * number.get("half_width", 1.0)},
        "backlash": {"slope": 0.1 + 0.2 * share},
        "rate-limit": {"softness": (0.1 + 0.2 * share) * now.force},
        "hysteresis": {"exponent": 2.0},
        "quadratic-drag": {"exponent": 1.7, "coefficient": coefficient * now.velocity**0.3},
        "cogging": {"second": 0.2 + 0.2 * share},
        "square-root-outflow": {"exponent": exponent},
        "parameter-drift": {"memory": (0.4 + share) * now.duration},
        "periodic-disturbance": {"second": 0.15 + 0.25 * share},
        "step-disturbance": {"rise": (1.0 + 4.0 * share) * rig.pace},
        "sensor-drift": {"memory": (0.4 + share) * now.duration},
        "encoder-eccentricity": {"second": 0.15 + 0.25 * share},
    }.get(law.identifier, {})


def inexact_law(identifier: str, rng: Generator, rig: Rig, now: Situation) -> Callable[[float], Law]:
    """Return a law that has a name of the catalogue and not quite its equation, as a function of its size."""
    exact = catalogue_law(identifier, rng, rig, now)
    share = float(rng.random())

    def law(size: float) -> Law:
        """Return the law of that size."""
        plain = exact(size)
        extra = {
            name: value if isinstance(value, str) else float(value)
            for name, value in _bent(plain, rig, now, share).items()
        }
        return replace(plain, law=INEXACT[identifier], parameters={**plain.parameters, **extra})

    return law


def outside_law(identifier: str, rng: Generator, rig: Rig, now: Situation) -> Callable[[float], Law]:
    """Return a law that the catalogue has no name for, as a function of its size."""
    far, fast, force = now.position, now.velocity, now.force
    stiffness = rig.stiffness if rig.stiffness > 0.0 else force / far
    sign, share, seed = (1.0 if rng.random() < 0.5 else -1.0), float(rng.random()), int(rng.integers(2**31))
    natural = 1.0 / rig.pace
    onset = rig.start + (0.3 + 0.4 * share) * now.duration
    laws: dict[str, tuple[str, Callable[[float], Parameters]]] = {
        "command-levels": ("actuator", lambda size: {"distance": 0.8 * size * force}),
        "power-law-gain": ("actuator", lambda size: {"excess": 0.8 * size * sign if sign > 0 else -0.45 * size,
                                                     "scale": 0.7 * force}),
        "missed-commands": ("actuator", lambda size: {"share": 0.15 * size, "seed": float(seed)}),
        "thermal-fade": ("actuator", lambda size: {"coefficient": size / force**2,
                                                   "time_constant": 0.1 * now.duration}),
        "freeplay-spring": ("plant", lambda size: {"stiffness": 0.6 * stiffness, "half_width": 0.5 * size * far}),
        "one-sided-damper": ("plant", lambda size: {"coefficient": size * force / fast}),
        "fading-force": ("plant", lambda size: {"coefficient": 0.6 * size / far**2}),
        "centrifugal-force": ("plant", lambda size: {"coefficient": sign * size * force / (far * fast**2)}),
        "eddy-brake": ("plant", lambda size: {"coefficient": 1.5 * size * force / fast,
                                              "velocity": (0.3 + 0.5 * share) * fast}),
        "relaxing-spring": ("plant", lambda size: {"stiffness": 0.6 * size * stiffness,
                                                   "time_constant": (2.0 + 6.0 * share) * rig.pace}),
        "pumped-stiffness": ("plant", lambda size: {"stiffness": 0.3 * size * stiffness,
                                                    "frequency": (0.2 + 0.5 * share) * natural}),
        "bumped-camera": ("sensor", lambda size: {"size": sign * 0.4 * size * far, "time": onset}),
        "breathing-scale": ("sensor", lambda size: {"amplitude": 0.3 * size,
                                                    "frequency": (0.05 + 0.2 * share) * natural}),
    }  # fmt: skip
    place, sized = laws[identifier]
    return lambda size: Law(identifier, place, "outside the catalogue", dict(sized(size)))
