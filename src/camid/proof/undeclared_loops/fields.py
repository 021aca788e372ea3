"""Forces of position, speed and time, and what drifts or swings, as the catalogue's formulas state them."""

import math
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
from scipy.signal import cont2discrete, lfilter, ss2tf

from .rigs import Array
from .setup import Draft, Drafter, Force, Scales, Setup

Generator = np.random.Generator
Parameters = dict[str, Any]
TURN = 2.0 * math.pi


def with_force(name: str, make: Callable[[Parameters], Force]) -> Callable[[Setup, Parameters], None]:
    """Return an installer of the force (u, against the motion) that ``make`` makes of the parameters."""

    def install(setup: Setup, p: Parameters) -> None:
        setup.forces[name] = make(p)

    return install


def _sign(rng: Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def drag(scales: Scales, rng: Generator) -> Draft:
    """Resistance with the square of the speed."""

    def make(p: Parameters) -> Force:
        c = p["coefficient"]
        return lambda t, y, v, u: c * abs(v) * v

    return Draft("quadratic-drag", "plant", "catalogue",
                 lambda size: {"coefficient": size * scales.command / scales.speed**2},
                 with_force("quadratic-drag", make), 0.8, 0.2)  # fmt: skip


def damping(scales: Scales, rng: Generator) -> Draft:
    """Damping with the square of the displacement."""

    def make(p: Parameters) -> Force:
        c = p["coefficient"]
        return lambda t, y, v, u: c * y * y * v

    return Draft("amplitude-dependent-damping", "plant", "catalogue",
                 lambda size: {"coefficient": size * scales.command / (scales.reach**2 * scales.speed)},
                 with_force("amplitude-dependent-damping", make), 1.2, 0.2)  # fmt: skip


def cogging(scales: Scales, rng: Generator) -> Draft:
    """Poles along the way."""
    period, phase = 2.0 * scales.way / float(rng.uniform(3.0, 12.0)), float(rng.uniform(-math.pi, math.pi))

    def make(p: Parameters) -> Force:
        a, k, f = p["amplitude"], TURN / p["period"], p["phase"]
        rest = math.sin(f)
        return lambda t, y, v, u: a * (math.sin(k * y + f) - rest)

    return Draft("cogging", "plant", "catalogue",
                 lambda size: {"amplitude": size * scales.command, "period": period, "phase": phase},
                 with_force("cogging", make), 0.3, 0.1)  # fmt: skip


def cubic(scales: Scales, rng: Generator) -> Draft:
    """A spring with the cube."""

    def make(p: Parameters) -> Force:
        c = p["coefficient"]
        return lambda t, y, v, u: c * y * y * y

    return Draft("cubic-stiffness", "plant", "catalogue",
                 lambda size: {"coefficient": size * scales.command / scales.reach**3},
                 with_force("cubic-stiffness", make), 0.6, 0.15)  # fmt: skip


def quadratic(scales: Scales, rng: Generator) -> Draft:
    """A spring that is stiffer to one side."""
    sign = _sign(rng)

    def make(p: Parameters) -> Force:
        c = p["coefficient"]
        return lambda t, y, v, u: c * y * y

    return Draft("quadratic-stiffness", "plant", "catalogue",
                 lambda size: {"coefficient": sign * size * scales.command / scales.reach**2},
                 with_force("quadratic-stiffness", make), 0.45, 0.15)  # fmt: skip


def gravity(scales: Scales, rng: Generator) -> Draft:
    """Gravity on an arm, for machines that turn."""
    phase = float(rng.uniform(-0.6, 0.6))

    def make(p: Parameters) -> Force:
        m, a, f = p["torque"], p["amplitude"], p["phase"]
        return lambda t, y, v, u: m * math.sin(y / a + f)

    return Draft("pendulum-gravity", "plant", "catalogue",
                 lambda size: {"amplitude": scales.turn, "torque": size * scales.command, "phase": phase},
                 with_force("pendulum-gravity", make), 0.45, 0.15)  # fmt: skip


def end_stop(scales: Scales, rng: Generator) -> Draft:
    """A stop that the machine runs into a little."""
    end = scales.high if scales.high > -scales.low else scales.low
    position = end * float(rng.uniform(0.6, 0.88))

    def install(setup: Setup, p: Parameters) -> None:
        at, k = p["position"], p["stiffness"]
        setup.guards.append(lambda y, v: y - at)
        if at > 0.0:
            setup.forces["end-stop"] = lambda t, y, v, u: k * (y - at) if y > at else 0.0
        else:
            setup.forces["end-stop"] = lambda t, y, v, u: k * (y - at) if y < at else 0.0

    stiffest = (0.4 / scales.period) ** 2 / scales.gain * abs(end - position) / scales.command
    return Draft("end-stop", "plant", "catalogue",
                 lambda size: {"position": position, "stiffness": size * scales.command / abs(end - position)},
                 install, min(stiffest, 8.0), 0.5)  # fmt: skip


def step(scales: Scales, rng: Generator) -> Draft:
    """A force that sets in."""
    sign, rows = _sign(rng), int(rng.uniform(0.25, 0.7) * scales.duration / scales.period)

    def install(setup: Setup, p: Parameters) -> None:
        size, time = -p["size"], p["time"]
        setup.onset = time
        setup.forces["step-disturbance"] = lambda t, y, v, u: size if t >= time else 0.0

    return Draft("step-disturbance", "disturbance", "catalogue",
                 lambda size: {"size": sign * size * scales.command, "time": (rows + 0.53) * scales.period},
                 install, 0.35, 0.1)  # fmt: skip


def periodic(scales: Scales, rng: Generator) -> Draft:
    """A sinusoidal force."""
    frequency = scales.bandwidth * float(np.exp(rng.uniform(np.log(0.4), np.log(3.0))))
    phase = float(rng.uniform(-math.pi, math.pi))

    def make(p: Parameters) -> Force:
        a, w, f = -p["amplitude"], p["frequency"], p["phase"]
        return lambda t, y, v, u: a * math.sin(w * t + f)

    return Draft("periodic-disturbance", "disturbance", "catalogue",
                 lambda size: {"amplitude": size * scales.command, "frequency": frequency, "phase": phase},
                 with_force("periodic-disturbance", make), 0.3, 0.1)  # fmt: skip


def impulse(scales: Scales, rng: Generator) -> Draft:
    """A blow."""
    sign, rows = _sign(rng), int(rng.uniform(0.2, 0.75) * scales.duration / scales.period)

    def install(setup: Setup, p: Parameters) -> None:
        setup.blow = (p["time"], p["size"])

    return Draft("impulse-disturbance", "disturbance", "catalogue",
                 lambda size: {"size": sign * size * scales.command / scales.bandwidth,
                               "time": (rows + 0.5) * scales.period},
                 install, 1.0, 0.2)  # fmt: skip


def drift(scales: Scales, rng: Generator) -> Draft:
    """A coefficient that changes in proportion to the time, settles, or changes once."""
    kind, coefficient = str(rng.choice(["rate", "rate", "settles", "change"])), str(rng.choice(["gain", "damping"]))
    sign, rows = _sign(rng), int(rng.uniform(0.3, 0.7) * scales.duration / scales.period)

    def parameters(size: float) -> Parameters:
        if kind == "change":
            return {"coefficient": coefficient, "change": sign * size, "time": (rows + 0.53) * scales.period}
        if kind == "rate":
            return {"coefficient": coefficient, "rate": sign * size / scales.duration}
        constant = 0.3 * scales.duration
        return {"coefficient": coefficient, "rate": sign * size / constant, "time_constant": constant}

    def install(setup: Setup, p: Parameters) -> None:
        def factor(t: float) -> float:
            if "change" in p:
                return 1.0 + (p["change"] if t >= p["time"] else 0.0)
            if "time_constant" in p:
                constant = float(p["time_constant"])
                return 1.0 + float(p["rate"]) * constant * (1.0 - math.exp(-max(t, 0.0) / constant))
            return 1.0 + float(p["rate"]) * t

        setup.onset = p.get("time")
        if p["coefficient"] == "gain":
            setup.gain = factor
        else:
            setup.damping = factor

    return Draft("parameter-drift", "plant", "catalogue", parameters, install, 0.6, 0.15)


def _swung(drive: Array, step_size: float, frequency: float, ratio: float, method: Literal["foh", "zoh"]) -> Array:
    """Return what a mode of unit gain makes of a drive, held over the steps (s) or in straight lines between them."""
    a = np.array([[0.0, 1.0], [-(frequency**2), -2.0 * ratio * frequency]])
    b, c, d = np.array([[0.0], [frequency**2]]), np.array([[1.0, 0.0]]), np.array([[0.0]])
    discrete = cont2discrete((a, b, c, d), step_size, method=method)
    numerator, denominator = ss2tf(*discrete[:4])
    return np.asarray(lfilter(np.ravel(numerator), np.ravel(denominator), drive))


def series_mode(scales: Scales, rng: Generator) -> Draft:
    """A mode behind the plant; the smaller its frequency the larger the effect."""
    ratio = float(np.exp(rng.uniform(np.log(0.03), np.log(0.4))))

    def install(setup: Setup, p: Parameters) -> None:
        w, d = p["natural_frequency"], p["damping"]
        setup.behind = lambda position, velocity, step_size: _swung(position, step_size, w, d, "foh")

    return Draft("extra-mode", "plant", "catalogue",
                 lambda size: {"natural_frequency": scales.fast * 1.2 / math.sqrt(size), "damping": ratio},
                 install, 1.0, 0.3)  # fmt: skip


def parallel_mode(scales: Scales, rng: Generator) -> Draft:
    """A mode that swings beside the plant."""
    frequency = scales.fast * float(np.exp(rng.uniform(np.log(0.7), np.log(2.0))))
    ratio = float(np.exp(rng.uniform(np.log(0.03), np.log(0.3))))

    def install(setup: Setup, p: Parameters) -> None:
        setup.beside = (p["gain"], p["natural_frequency"], p["damping"])

    return Draft("parallel-mode", "plant", "catalogue",
                 lambda size: {"gain": size * scales.way / scales.command, "natural_frequency": frequency,
                               "damping": ratio},
                 install, 0.12, 0.02)  # fmt: skip


def swing(arrived: Array, period: float, mode: tuple[float, float, float]) -> Array:
    """Return rows (y) of a mode of gain, frequency and ratio that is driven by rows of what arrives (u)."""
    gain, frequency, ratio = mode
    return _swung(gain * arrived, period, frequency, ratio, "zoh")


def play(position: Array, velocity: Array, step_size: float, half: float) -> Array:
    """Return what follows the nodes of a position (y) behind a gap of half width ``half``; it begins in its middle.

    Where the speed (y/s) changes its sign between two nodes, the place of the turn counts as well.
    """
    made, value = np.empty_like(position), float(position[0])
    before, pace = value, 0.0
    for k, (place, speed) in enumerate(zip(position.tolist(), velocity.tolist(), strict=True)):
        if pace * speed < 0.0:
            turn = before + 0.5 * step_size * pace * pace / (pace - speed)
            value = min(max(value, turn - half), turn + half)
        value = min(max(value, place - half), place + half)
        made[k], before, pace = value, place, speed
    return made


def output_play(scales: Scales, rng: Generator) -> Draft:
    """Play between the machine and its load, which the camera sees."""

    def install(setup: Setup, p: Parameters) -> None:
        half = p["half_width"]
        setup.behind = lambda position, velocity, step_size: play(position, velocity, step_size, half)

    return Draft("output-backlash", "plant", "catalogue", lambda size: {"half_width": size * scales.way},
                 install, 0.12, 0.01)  # fmt: skip


FIELDS: dict[str, tuple[Drafter, ...]] = {
    "quadratic-drag": (drag,), "amplitude-dependent-damping": (damping,), "cogging": (cogging,),
    "cubic-stiffness": (cubic,), "quadratic-stiffness": (quadratic,), "pendulum-gravity": (gravity,),
    "end-stop": (end_stop,), "step-disturbance": (step,), "periodic-disturbance": (periodic,),
    "impulse-disturbance": (impulse,), "parameter-drift": (drift,), "extra-mode": (series_mode,),
    "parallel-mode": (parallel_mode,), "output-backlash": (output_play,),
}  # fmt: skip
