"""Choice of what is concealed: rigs, excitations and laws that suit each other, at sizes that a recording shows."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .chain import run, substep
from .detectability import multiple, sensitivities
from .excitations import EXCITATIONS, Generator
from .laws import CATALOGUE, NOISE_LAWS, Law
from .noise import draw_noise_law
from .proposals import Situation, catalogue_law, suits
from .rigs import NAMES, Rig, draw_rig
from .unusual import inexact_law, outside_law

Array = np.ndarray[Any, np.dtype[np.float64]]

SMOOTH = frozenset({"multisine, sparse", "linear chirp", "filtered noise", "triangle", "ramps and rests",
                    "machine cycle", "sine bursts", "beat"})  # fmt: skip
LEAST, MOST = 0.5, 60.0  # multiples of what is detectable
LEAST_OF_SEVERAL = 1.5
LARGEST_SWING = 2.3  # rad; beyond it a pendulum turns over, and the least difference grows without limit
IMAGE = frozenset({"absolute-value", "clipping", "encoder-eccentricity", "lens-distortion", "perspective",
                   "rolling-shutter", "breathing-scale"})  # fmt: skip
FAMILIES: tuple[frozenset[str], ...] = (
    IMAGE.intersection(CATALOGUE),
    frozenset({"coulomb-friction", "asymmetric-friction", "load-dependent-friction", "position-dependent-friction",
               "stribeck-friction", "hysteresis"}),
    frozenset({"cubic-stiffness", "quadratic-stiffness", "pendulum-gravity", "end-stop", "cogging", "overflow",
               "square-root-outflow"}),
    frozenset({"quadratic-drag", "amplitude-dependent-damping"}),
    frozenset({"actuator-lag", "delay", "exposure", "clock-skew", "input-hold", "speed-weighted-centroid"}),
    frozenset({"saturation", "dead-zone", "gain-asymmetry", "backlash", "rate-limit"}),
    frozenset({"sensor-offset", "input-bias", "step-disturbance", "sensor-drift"}),
    frozenset({"periodic-disturbance"}),
    frozenset({"impulse-disturbance"}),
    frozenset({"parameter-drift"}),
    frozenset({"outliers"}),
    frozenset({"dropped-frames"}),
)  # fmt: skip


@dataclass(frozen=True)
class Scene:
    """A rig that is driven, without anything concealed; ``deviation`` is that of its noise in what is compared."""

    rig: Rig
    excitation: str
    drive: Array
    deviation: float
    situation: Situation
    bias_known: bool


def draw_drive(rng: Generator, rig: Rig, excitation: str) -> Array:
    """Return the command (u), or the reference (y) of a controller, one value a sample; zeros for a free decay."""
    if not rig.driven:
        return np.zeros(rig.samples)
    pace = rig.pace / rig.period * (0.5 if rig.controller is not None else 1.0)
    wave = EXCITATIONS[excitation](rng, rig.samples, pace)
    if rig.one_sided:
        wave = 0.6 + 0.4 * wave
    return np.asarray(rig.largest_input * wave)


def _prepared(rig: Rig, identifiers: tuple[str, ...]) -> tuple[Rig, bool]:
    """Return the rig with what has to be declared lest an effect is estimated away; and whether a bias is known."""
    bias_known = "input-bias" in identifiers
    if "sensor-offset" in identifiers or (bias_known and not rig.integrates):
        return replace(rig, offset=0.0, offset_known=True), bias_known
    if IMAGE.intersection(identifiers):
        return replace(rig, offset=0.0, offset_known=rig.offset_known or "absolute-value" in identifiers), bias_known
    return rig, bias_known


def turns_over(rig: Rig, output: Array) -> bool:
    """Return whether a pendulum swings so far that its motion is chaotic."""
    return rig.pendulum is not None and bool(np.abs(output - rig.pendulum[3]).max() > LARGEST_SWING)


def stage(rng: Generator, identifiers: tuple[str, ...]) -> Scene | None:
    """Draw a rig and an excitation that suit effects; None where they do not."""
    rig = draw_rig(rng, str(rng.choice(NAMES)))
    excitation = str(rng.choice(list(EXCITATIONS))) if rig.driven else "free decay"
    if rig.driven and rig.controller is None and excitation in SMOOTH and rng.random() < 0.5:
        rig = replace(rig, straight=True)
    if not all(suits(identifier, rig, excitation) for identifier in identifiers):
        return None
    rig, bias_known = _prepared(rig, identifiers)
    drive = draw_drive(rng, rig, excitation)
    decibels = float(rng.uniform(15.0, 50.0))
    base = run(rig, [], drive)
    if not np.all(np.isfinite(base.output)) or base.output.std() == 0.0 or turns_over(rig, base.output):
        return None
    rest = rig.pendulum[3] if rig.pendulum is not None else rig.offset
    far = float(np.abs(base.output - rest).max())
    fast = float(np.sqrt(np.mean(base.trajectory.motion[1] ** 2)))
    force = float(np.abs(base.command).max()) if rig.driven else rig.stiffness * far
    situation = Situation(far, fast, force, rig.samples * rig.period, substep(rig))
    deviation = float(base.compared(rig).std()) * 10.0 ** (-decibels / 20.0)
    return Scene(rig, excitation, drive, deviation, situation, bias_known)


def _difference(scene: Scene, laws: list[Law], base: Array) -> Array | None:
    """Return what laws change in the compared signal; None where the rig no longer moves as such a rig does."""
    signal = run(scene.rig, laws, scene.drive).compared(scene.rig)
    if turns_over(scene.rig, signal):
        return None
    if not np.all(np.isfinite(signal)) or not 0.15 < signal.std() / base.std() < 6.0:
        return None
    return np.asarray(signal - base)


def _sized(scene: Scene, law: Callable[[float], Law], target: float, columns: Array, base: Array) -> Law | None:
    """Return a law at the size at which its multiple is near a target, as far as it gets; None where it fails."""
    size, exponent = 0.3, 1.0
    best: tuple[float, Law] | None = None
    last: tuple[float, float] | None = None
    for _ in range(7):
        chosen = law(size)
        difference = _difference(scene, [chosen], base)
        if difference is None:
            size *= 0.4
            continue
        found = max(multiple(difference, columns, scene.deviation), 1e-9)
        error = abs(np.log(found / target))
        if best is None or error < best[0]:
            best = (error, chosen)
        if error < np.log(1.3):
            break
        if last is not None and size != last[0] and found != last[1]:
            exponent = float(np.clip(np.log(found / last[1]) / np.log(size / last[0]), 0.5, 3.0))
        last = (size, found)
        step = float(np.clip((target / found) ** (1.0 / exponent), 0.02, 50.0))
        following = float(np.clip(size * step, 1e-4, 1.0))
        if following == size:
            break
        size = following
    return None if best is None else best[1]


def multiples(scene: Scene, laws: list[Law]) -> list[float | None]:
    """Return the multiple of each law beside the others; None for one that acts on the measured values alone."""
    acting = [law for law in laws if law.identifier not in NOISE_LAWS]
    whole = run(scene.rig, acting, scene.drive).compared(scene.rig)
    found: list[float | None] = []
    for law in laws:
        if law.identifier in NOISE_LAWS:
            found.append(None)
            continue
        others = [other for other in acting if other is not law]
        columns = sensitivities(scene.rig, others, scene.drive, scene.bias_known)
        difference = whole - run(scene.rig, others, scene.drive).compared(scene.rig)
        found.append(multiple(difference, columns, scene.deviation))
    return found


Maker = Callable[[str, Generator, Rig, Situation], Callable[[float], Law]]
MAKERS: dict[str, Maker] = {"catalogue": catalogue_law, "inexact": inexact_law, "outside": outside_law}


def _noise_law(rng: Generator, scene: Scene, identifier: str) -> tuple[Scene, Law]:
    """Return an effect on the measured values."""
    law = draw_noise_law(identifier, rng, scene.deviation, scene.situation.velocity, scene.rig.period)
    if identifier == "timestamp-jitter":
        # where the noise would hide the jitter there is less of it
        shown = float(law.parameters["std"]) * scene.situation.velocity
        scene = replace(scene, deviation=min(scene.deviation, shown))
    return scene, law


class NotShownError(RuntimeError):
    """No rig that was drawn shows the laws that were asked for."""


def conceal(rng: Generator, identifiers: tuple[str, ...], way: str) -> tuple[Scene, list[Law], list[float | None]]:
    """Draw a scene and laws with these ids that it shows; ``way`` is "catalogue", "inexact" or "outside".

    Raises
    ------
    NotShownError
        If none of 400 scenes shows all of them.
    """
    several = len(identifiers) > 1
    for _ in range(400):
        scene = stage(rng, identifiers)
        if scene is None:
            continue
        laws: list[Law] = []
        if any(identifier not in NOISE_LAWS for identifier in identifiers):
            columns = sensitivities(scene.rig, [], scene.drive, scene.bias_known)
            base = run(scene.rig, [], scene.drive).compared(scene.rig)
        for identifier in identifiers:
            if identifier in NOISE_LAWS:
                if scene.rig.controller is None and identifier != "coloured-noise":
                    scene, law = _noise_law(rng, scene, identifier)
                    laws.append(law)
                continue
            target = float(np.exp(rng.uniform(np.log(3.0 if several else LEAST), np.log(MOST))))
            sized = _sized(scene, MAKERS[way](identifier, rng, scene.rig, scene.situation), target, columns, base)
            if sized is not None:
                laws.append(sized)
        if len(laws) < len(identifiers):
            continue
        whole = run(scene.rig, [law for law in laws if law.identifier not in NOISE_LAWS], scene.drive)
        if not np.all(np.isfinite(whole.output)) or turns_over(scene.rig, whole.output):
            continue
        found = multiples(scene, laws)
        least = LEAST_OF_SEVERAL if several else LEAST * 0.8
        if all(value is None or least <= value <= 4.0 * MOST for value in found):
            return scene, laws, found
    raise NotShownError(f"no rig shows {', '.join(identifiers)}")


def draw_company(rng: Generator) -> tuple[str, ...]:
    """Draw two or three ids of the catalogue from different families, of which at least one is of the rig's physics."""
    count = 2 if rng.random() < 0.7 else 3
    while True:
        chosen = rng.choice(len(FAMILIES), count, replace=False)
        names = tuple(str(rng.choice(sorted(FAMILIES[int(k)]))) for k in chosen)
        alone = {"absolute-value", "speed-weighted-centroid", "exposure", "overflow", "square-root-outflow"}
        if not alone.intersection(names) and any(CATALOGUE[name] in {"plant", "actuator"} for name in names):
            return names
