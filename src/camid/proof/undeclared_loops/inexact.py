"""Laws that are nearly, and not quite, those of the catalogue; each bears the id of the one that it resembles."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from .actuators import with_curve
from .fields import play, with_force
from .frictions import falling_levels, with_friction
from .rigs import Array
from .sensors import Shown, with_image
from .setup import Draft, Drafter, Force, Hidden, Level, Scales, Setup

Generator = np.random.Generator
Parameters = dict[str, Any]


def turning(scales: Scales, rng: Generator) -> Draft:
    """Friction that turns round by the error function, which no knee of the catalogue has."""
    width = scales.speed * float(np.exp(rng.uniform(np.log(0.01), np.log(0.1))))

    def make(p: Parameters) -> Force:
        f, w = p["force"], p["transition"]
        return lambda t, y, v, u: f * math.erf(v / w)

    return Draft("coulomb-friction", "plant", "f_c erf(v/v_t): turns round gradually, by the error function",
                 lambda size: {"force": size * scales.command, "transition": width},
                 with_force("coulomb-friction", make), 0.4, 0.1)  # fmt: skip


def wavy(scales: Scales, rng: Generator) -> Draft:
    """Friction that waxes and wanes along the way."""
    share, period = float(rng.uniform(0.4, 0.8)), scales.way * float(rng.uniform(0.5, 1.5))

    def make(p: Parameters) -> Level:
        f, k = p["force"], 2.0 * math.pi / p["period"]
        return lambda y, speed, u, side: f * (1.0 + share * math.sin(k * y))

    return Draft("coulomb-friction", "plant", f"f_c (1 + {share:.3f} sin(2π y/p)) sgn(v): varies along the way",
                 lambda size: {"force": size * scales.command, "period": period},
                 with_friction(make), 0.25, 0.1)  # fmt: skip


def falling(scales: Scales, rng: Generator) -> Draft:
    """Friction that falls from its break-away level by a rational function."""
    parameters = falling_levels(scales, rng)

    def make(p: Parameters) -> Level:
        low, rise, v = p["coulomb"], p["breakaway"] - p["coulomb"], p["velocity"]
        return lambda y, slide, u, side: low + rise / (1.0 + slide / v)

    return Draft("stribeck-friction", "plant", "f_c + (f_s − f_c)/(1 + |v|/v_s): falls as a hyperbola",
                 parameters, with_friction(make), 0.4, 0.12)  # fmt: skip


def smooth_limit(scales: Scales, rng: Generator) -> Draft:
    """A hyperbolic tangent as saturation."""

    def make(p: Parameters) -> Callable[[float], float]:
        s = p["limit"]
        return lambda u: s * math.tanh(u / s)

    return Draft("saturation", "actuator", "s tanh(u/s): a smooth limit", lambda size: {"limit": scales.command / size},
                 with_curve(make), 2.0, 0.7)  # fmt: skip


def rounded_zone(scales: Scales, rng: Generator) -> Draft:
    """A dead zone whose edges are parabolas."""
    share = float(rng.uniform(0.3, 0.9))

    def make(p: Parameters) -> Callable[[float], float]:
        d = p["half_width"]
        w = share * d

        def curve(u: float) -> float:
            beyond = abs(u) - d
            if beyond <= -w:
                return 0.0
            return math.copysign(beyond if beyond >= w else (beyond + w) ** 2 / (4.0 * w), u)

        return curve

    return Draft("dead-zone", "actuator", f"dead zone with parabolic edges over ±{share:.3f} of its half width",
                 lambda size: {"half_width": size * scales.command}, with_curve(make), 0.3, 0.07)  # fmt: skip


def three_waves(scales: Scales, rng: Generator) -> Draft:
    """Cogging with a second and a third harmonic at once."""
    period, phase = 2.0 * scales.way / float(rng.uniform(3.0, 9.0)), float(rng.uniform(-math.pi, math.pi))
    two, three = float(rng.uniform(0.25, 0.5)), float(rng.uniform(0.15, 0.35))

    def make(p: Parameters) -> Force:
        a, k, f = p["amplitude"], 2.0 * math.pi / p["period"], p["phase"]

        def wave(x: float) -> float:
            return a * (math.sin(x + f) + two * math.sin(2.0 * x) + three * math.cos(3.0 * x))

        rest = wave(0.0)
        return lambda t, y, v, u: wave(k * y) - rest

    return Draft("cogging", "plant", f"cogging with two harmonics, {two:.3f} sin 2x and {three:.3f} cos 3x",
                 lambda size: {"amplitude": size * scales.command, "period": period, "phase": phase},
                 with_force("cogging", make), 0.22, 0.1)  # fmt: skip


def growing_stop(scales: Scales, rng: Generator) -> Draft:
    """A stop whose force grows with the exponential of the depth."""
    end = scales.high if scales.high > -scales.low else scales.low
    position = end * float(rng.uniform(0.6, 0.88))
    depth = abs(end - position) * float(rng.uniform(0.4, 1.0))

    def install(setup: Setup, p: Parameters) -> None:
        at, k, side = p["position"], p["stiffness"], math.copysign(1.0, p["position"])
        setup.guards.append(lambda y, v: y - at)

        def force(t: float, y: float, v: float, u: float) -> float:
            into = side * (y - at)
            return side * k * depth * math.expm1(min(into / depth, 30.0)) if into > 0.0 else 0.0

        setup.forces["end-stop"] = force

    return Draft("end-stop", "plant", f"k d₀ (exp(d/d₀) − 1), d₀ = {depth:.6g}: an elastic exponential",
                 lambda size: {"position": position, "stiffness": size * scales.command / abs(end - position)},
                 install, 2.5, 0.4)  # fmt: skip


def compliant_play(scales: Scales, rng: Generator) -> Draft:
    """Play whose teeth give way: what follows lags by a little."""
    constant = scales.period * float(rng.uniform(1.0, 4.0))

    def install(setup: Setup, p: Parameters) -> None:
        half = p["half_width"]

        def behind(position: Array, velocity: Array, step: float) -> Array:
            keep, value = math.exp(-step / constant), float(position[0])
            made, before = play(position, velocity, step, half), float(position[0])
            for k, place in enumerate(made.tolist()):
                late = (place - before) * constant / step
                value = place - late + (value - before + late) * keep
                made[k], before = value, place
            return made

        setup.behind = behind

    return Draft("output-backlash", "plant", f"play with a compliant tooth, which lags by {constant:.6g} s",
                 lambda size: {"half_width": size * scales.way}, install, 0.12, 0.01)  # fmt: skip


def other_power(scales: Scales, rng: Generator) -> Draft:
    """Drag with a power between one and three that is not two."""
    power = float(rng.choice([1.55, 1.7, 2.4, 2.7]))

    def make(p: Parameters) -> Force:
        c, v0 = p["coefficient"], scales.speed
        return lambda t, y, v, u: c * v0 * v * abs(v / v0) ** (power - 1.0)

    return Draft("quadratic-drag", "plant", f"c v₀² |v/v₀|^{power} sgn(v), v₀ = {scales.speed:.6g}",
                 lambda size: {"coefficient": size * scales.command / scales.speed**2},
                 with_force("quadratic-drag", make), 0.8, 0.2)  # fmt: skip


def other_loop(scales: Scales, rng: Generator) -> Draft:
    """Hysteresis after Duhem, which bends by another power."""
    shape = 1.0 / (scales.way * float(np.exp(rng.uniform(np.log(0.05), np.log(0.4)))))

    def install(setup: Setup, p: Parameters) -> None:
        h, k = p["strength"], p["shape"]

        def rate(y: float, v: float, z: float) -> float:
            left = 1.0 - z if v > 0.0 else 1.0 + z
            return k * v * max(left, 0.0) ** 1.6

        setup.hidden = Hidden(lambda z: h * z, rate)

    return Draft("hysteresis", "plant", "h z, dz/dt = κ v (1 − z sgn v)^1.6: after Duhem",
                 lambda size: {"strength": size * scales.command, "shape": shape}, install, 0.4, 0.12)  # fmt: skip


def soft_rate(scales: Scales, rng: Generator) -> Draft:
    """A rate limit that slows down as it arrives."""
    constant = scales.period * float(rng.uniform(0.3, 1.5))

    def install(setup: Setup, p: Parameters) -> None:
        rate = p["rate"]

        def approach(last: float, wanted: float, time: float) -> float:
            x = (wanted - last) / (rate * constant)
            if abs(x) > 300.0:
                return last + math.copysign(rate * time, x)
            return wanted - rate * constant * math.asinh(math.sinh(x) * math.exp(-time / constant))

        setup.approach = approach

    return Draft("rate-limit", "actuator", f"du'/dt = r tanh((u − u')/(r τ)), τ = {constant:.6g} s: slows down",
                 lambda size: {"rate": scales.slope / size}, install, 6.0, 2.0)  # fmt: skip


def fisheye(scales: Scales, rng: Generator) -> Draft:
    """A lens that images by the inverse tangent, or the tangent, of the angle."""
    barrel = bool(rng.random() < 0.5)

    def make(p: Parameters) -> Shown:
        focus = 1.0 / math.sqrt(3.0 * abs(p["k1"]))
        return (lambda y: focus * np.arctan(y / focus)) if barrel else (lambda y: focus * np.tan(y / focus))

    return Draft("lens-distortion", "sensor",
                 f"F {'atan' if barrel else 'tan'}(y/F), F² = 1/(3 |k1|): a lens that follows the angle",
                 lambda size: {"k1": (-1.0 if barrel else 1.0) * size / scales.reach**2},
                 with_image(make), 0.2, 0.02)  # fmt: skip


def rising(scales: Scales, rng: Generator) -> Draft:
    """A force that sets in over a time."""
    sign, rows = float(rng.choice([-1.0, 1.0])), int(rng.uniform(0.25, 0.6) * scales.duration / scales.period)
    constant = float(rng.uniform(0.3, 3.0)) / scales.bandwidth

    def make(p: Parameters) -> Force:
        size, time = -p["size"], p["time"]
        return lambda t, y, v, u: size * -math.expm1(-(t - time) / constant) if t > time else 0.0

    return Draft("step-disturbance", "disturbance", f"s (1 − exp(−(t − t₀)/τ)), τ = {constant:.6g} s: sets in slowly",
                 lambda size: {"size": sign * size * scales.command, "time": rows * scales.period},
                 with_force("step-disturbance", make), 0.35, 0.1)  # fmt: skip


INEXACT: dict[str, Drafter] = {
    "turning": turning, "wavy": wavy, "falling": falling, "smooth limit": smooth_limit, "rounded zone": rounded_zone,
    "three waves": three_waves, "growing stop": growing_stop, "compliant play": compliant_play,
    "other power": other_power, "other loop": other_loop, "soft rate": soft_rate, "fisheye": fisheye,
    "rising": rising,
}  # fmt: skip
