"""What is concealed in a scene, and how large it is made."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .actuators import ACTUATORS
from .detectable import Rows, Windows, rows_of
from .fields import FIELDS
from .frictions import FRICTIONS
from .inexact import INEXACT
from .motion import SUBSTEPS, Motion
from .observation import observe
from .outside import OUTSIDE
from .rigs import Array, Generator
from .scenes import Scene, draw_scene
from .sensors import SENSORS
from .setup import Draft, Drafter, Setup

CATALOGUE: dict[str, tuple[Drafter, ...]] = {**FRICTIONS, **FIELDS, **ACTUATORS, **SENSORS}
# laws with a side that holds, or a hidden state, want a plant of order two
PLAIN = frozenset({*FRICTIONS, "parameter-drift", "wavy", "falling", "other loop", "creep"})
# the recording begins at rest where a law remembers what was before, or goes by the clock
MEMORY = frozenset({
    "backlash", "actuator-lag", "rate-limit", "output-backlash", "extra-mode", "parallel-mode", "hysteresis",
    "coulomb-friction", "step-disturbance", "periodic-disturbance", "impulse-disturbance", "parameter-drift",
    "clock-skew", "sensor-drift", "sensor-offset", "input-bias", "compliant play", "other loop", "soft rate", "rising",
    "creep",
})  # fmt: skip
# what changes the noise alone
NOISE_LIKE = frozenset({"quantisation", "outliers", "timestamp-jitter", "dropped-frames"})
BEHIND = frozenset({"extra-mode", "parallel-mode", "output-backlash"})
# what of the catalogue is put together: one of each of two or three of these
GROUPS: dict[str, tuple[str, ...]] = {
    "friction": ("coulomb-friction", "coulomb-friction", "stribeck-friction", "asymmetric-friction",
                 "position-dependent-friction", "load-dependent-friction"),
    "force": ("quadratic-drag", "cogging", "cubic-stiffness", "quadratic-stiffness", "end-stop", "step-disturbance",
              "periodic-disturbance"),
    "actuator": ("saturation", "dead-zone", "backlash", "gain-asymmetry", "input-quantisation", "actuator-lag",
                 "rate-limit"),
    "sensor": ("lens-distortion", "perspective", "encoder-eccentricity", "delay", "exposure", "quantisation",
               "outliers", "output-backlash", "rolling-shutter"),
}  # fmt: skip
LOWEST, HIGHEST = 1.5, 60.0


@dataclass(frozen=True)
class Law:
    """A law with its size: as it stands in the truth, with what installs it."""

    identifier: str
    place: str
    law: str
    parameters: dict[str, Any]
    install: Callable[[Setup, dict[str, Any]], None]


def installed(scene: Scene, laws: list[Law]) -> Setup:
    """Return what acts in the scene, in the order of the laws."""
    setup = Setup(camera=scene.camera)
    for law in laws:
        law.install(setup, law.parameters)
    return setup


def draw_company(rng: Generator) -> tuple[str, ...]:
    """Draw two, sometimes three laws for different places or roles."""
    groups = list(GROUPS)
    count = 3 if rng.random() < 0.2 else 2
    chosen = sorted(int(k) for k in rng.permutation(len(groups))[:count])
    return tuple(str(rng.choice(GROUPS[groups[k]])) for k in chosen)


def drafter(rng: Generator, name: str) -> Drafter:
    """Return what drafts a law by its id, or by its name where it is no law of the catalogue."""
    if name in CATALOGUE:
        return CATALOGUE[name][int(rng.integers(len(CATALOGUE[name])))]
    return INEXACT[name] if name in INEXACT else OUTSIDE[name]


def stage(rng: Generator, names: tuple[str, ...]) -> Scene:
    """Draw a scene that suits the laws."""
    kept = {"timestamp-jitter", "clock-skew", "sensor-drift", "exposure", "rolling-shutter", "quantisation", "clipping"}
    return draw_scene(
        rng,
        plain=any(name in PLAIN for name in names),
        moving=not any(name in MEMORY for name in names),
        turning="pendulum-gravity" in names,
        instant=any(name in kept for name in names),
    )


def _sized(drafts: list[Draft], sizes: list[float]) -> list[Law]:
    return [Law(d.identifier, d.place, d.law, d.parameters(size), d.install)
            for d, size in zip(drafts, sizes, strict=True)]  # fmt: skip


def _own_force(scene: Scene, setup: Setup, name: str, motion: Motion) -> Array:
    """Mean over the rows of a force without memory (u), along a motion."""
    force, first = setup.forces[name], scene.lead * motion.substeps
    made = np.zeros(scene.rows)
    for row in range(scene.rows):
        u = float(motion.arrived[scene.lead + row])
        total = 0.0
        for part in range(motion.substeps + 1):
            k = first + row * motion.substeps + part
            weight = 0.5 if part in (0, motion.substeps) else 1.0
            time = row * scene.rig.period + part * motion.step
            total += weight * force(time, float(motion.position[k]), float(motion.velocity[k]), u)
        made[row] = total / motion.substeps
    return made


def _part(scene: Scene, laws: list[Law], index: int, motion: Motion, rows: Rows) -> tuple[Array | None, Array | None]:
    """What one law adds: what its absence gives to the drive (u), or what it changes of the readings (y)."""
    law, setup = laws[index], installed(scene, laws)
    if law.place == "sensor" or law.identifier in BEHIND:
        without = installed(scene, laws[:index] + laws[index + 1 :])
        start = -scene.lead
        return None, observe(motion, setup, start, scene.rows) - observe(motion, without, start, scene.rows)
    if law.place == "actuator":
        return rows.command - rows.arrived, None
    plant = [k for k, other in enumerate(laws) if other.place in {"plant", "disturbance"}
             and other.identifier not in BEHIND]  # fmt: skip
    missing = rows.lacking - (rows.command - rows.arrived)
    if len(plant) == 1:
        return missing, None
    if law.identifier in setup.forces:
        return _own_force(scene, setup, law.identifier, motion), None
    for other in plant:
        if other != index:
            missing = missing - _own_force(scene, setup, laws[other].identifier, motion)
    return missing, None


def multiples(scene: Scene, laws: list[Law], motion: Motion) -> list[float]:
    """Return the size of each law, as a multiple of what shows (see :mod:`.detectable`)."""
    rows = rows_of(scene.rig, motion, scene.lead, scene.rows)
    windows = Windows(scene.rig, rows, all(law.identifier != "input-bias" for law in laws))
    found = []
    for k in range(len(laws)):
        drive, change = _part(scene, laws, k, motion, rows)
        effect = windows.split(change) if change is not None else windows.driven(np.asarray(drive))
        found.append(windows.multiple(effect, scene.noise))
    return found


def plausible(scene: Scene, laws: list[Law], motion: Motion) -> bool:
    """Say whether a machine neither runs away, nor sticks, nor asks for what its drive cannot do."""
    inner = slice(scene.lead * motion.substeps, (scene.lead + scene.rows) * motion.substeps, motion.substeps)
    position, speed = motion.position[inner], motion.velocity[inner]
    if not np.all(np.isfinite(motion.position)):
        return False
    wide, command = scene.scales.way, motion.command[scene.lead : scene.lead + scene.rows]
    held = float(np.mean(np.abs(command) > 0.999 * scene.rig.limit))
    most = 0.5 if any(law.identifier == "saturation" for law in laws) else 0.2
    reference = scene.reference[scene.lead : scene.lead + scene.rows]
    missed = float(np.std(reference - position) / np.std(reference))
    resting = float(np.mean(np.abs(speed) < 1e-9 * scene.scales.speed))
    far = max(float(position.max()) - scene.scales.high, scene.scales.low - float(position.min()))
    swing = float(np.abs(np.diff(command)).mean()) / (float(np.abs(command).mean()) + 1e-300)
    return far < 0.6 * wide and held < most and missed < 0.85 and resting < 0.7 and swing < 1.0


def _step(sizes: list[float], caps: list[float], found: list[float], aims: list[float]) -> list[float]:
    """Next sizes, nearer to what is aimed at."""
    ratios = [min(max((aim / max(size, 1e-9)) ** 0.9, 0.05), 12.0) for aim, size in zip(aims, found, strict=True)]
    return [min(size * ratio, cap) for size, ratio, cap in zip(sizes, ratios, caps, strict=True)]


def _fit(scene: Scene, drafts: list[Draft], aims: list[float]) -> tuple[list[Law], list[float]] | None:
    """Give laws their sizes; None where they cannot have any that shows."""
    caps, sizes = [draft.cap for draft in drafts], [min(draft.first, draft.cap) for draft in drafts]
    for turn in range(7):
        laws = _sized(drafts, sizes)
        motion = scene.moved(installed(scene, laws), 3)
        if not plausible(scene, laws, motion):
            caps = [0.6 * size for size in sizes]
            sizes = [min(size, cap) for size, cap in zip(sizes, caps, strict=True)]
            continue
        found = multiples(scene, laws, motion)
        after = _step(sizes, caps, found, aims)
        if turn == 6 or all(abs(np.log(b / a)) < 0.12 for a, b in zip(sizes, after, strict=True)):
            break
        sizes = after
    laws = _sized(drafts, sizes)
    motion = scene.moved(installed(scene, laws), SUBSTEPS)
    if not plausible(scene, laws, motion):
        return None
    found = multiples(scene, laws, motion)
    shows = all(np.isfinite(one) and LOWEST * 0.9 <= one <= HIGHEST * 1.3 for one in found)
    return (laws, found) if shows else None


def conceal(rng: Generator, names: tuple[str, ...]) -> tuple[Scene, list[Law], list[float]]:
    """Draw a scene with the laws in it; scenes in which they cannot show are drawn anew."""
    while True:
        scene = stage(rng, names)
        drafts = [drafter(rng, name)(scene.scales, rng) for name in names]
        aims = [float(np.exp(rng.uniform(np.log(LOWEST), np.log(HIGHEST)))) for _ in names]
        made = _fit(scene, drafts, aims)
        if made is not None:
            return scene, made[0], made[1]


def with_offset(scene: Scene, laws: list[Law], rng: Generator) -> Scene:
    """Return the scene with a camera whose zero is elsewhere, where that conceals no law's own zero."""
    free = scene.lead == 0 and all(law.place != "sensor" for law in laws)
    if not free or rng.random() < 0.5:
        return scene
    offset = float(np.round(rng.normal(0.0, 0.5) * scene.scales.way, 4))
    return replace(scene, camera=replace(scene.camera, offset=offset))
