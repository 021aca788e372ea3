"""Recordings of machines under controllers that were not declared: what a user has, and what is concealed."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas

from .concealment import CATALOGUE, NOISE_LIKE, Law, conceal, draw_company, installed, stage, with_offset
from .inexact import INEXACT
from .motion import SUBSTEPS
from .observation import observe
from .outside import OUTSIDE
from .rigs import Array, Generator
from .scenes import Scene, another

SHARES = {"none": 0.35, "single": 0.30, "several": 0.20, "inexact": 0.08, "outside": 0.07}
# laws that act by the clock: another recording does not have them
PASSING = frozenset({"impulse-disturbance", "periodic-disturbance", "step-disturbance", "parameter-drift",
                     "sensor-drift", "clock-skew"})  # fmt: skip
NOISES = ("white Gaussian", "white Gaussian", "white Gaussian", "white with slightly heavy tails", "white and rounded")


@dataclass(frozen=True)
class Made:
    """A recording, what its user believes, another recording of the same rig, and the truth.

    ``recording`` has the columns t (s), u (the command that the controller put out, held over the row) and y (what the
    camera read). ``again`` has one more column, ``clean``: y without noise. The parameters in ``truth`` are in seconds
    and in the units of u and y.
    """

    recording: pandas.DataFrame
    simulation: dict[str, Any]
    again: pandas.DataFrame | None
    truth: dict[str, Any]


def _generator(*numbers: int) -> Generator:
    return np.random.default_rng(np.random.SeedSequence([7451, *numbers]))


def kinds(seed: int, count: int) -> list[str]:
    """Return the kind of each of ``count`` recordings, with shares as near to those asked as whole numbers are."""
    edges = np.round(np.cumsum([0.0, *SHARES.values()]) * count).astype(int)
    listed = [kind for kind, low, high in zip(SHARES, edges[:-1], edges[1:], strict=True) for _ in range(high - low)]
    return [listed[int(k)] for k in _generator(seed, count, 1).permutation(count)]


def _names(seed: int, index: int, listed: list[str], rng: Generator) -> tuple[str, ...]:
    """Return what is concealed; every law of a kind has its turn before one comes again."""
    kind = listed[index]
    if kind == "none":
        return ()
    if kind == "several":
        return draw_company(rng)
    pool = sorted({"single": list(CATALOGUE), "inexact": list(INEXACT), "outside": list(OUTSIDE)}[kind])
    turn = listed[:index].count(kind)
    order = _generator(seed, len(pool), 2, turn // len(pool)).permutation(len(pool))
    return (pool[int(order[turn % len(pool)])],)


def _noise(rng: Generator, kind: str, rows: int, deviation: float) -> Array:
    """Return white noise (y) of a standard deviation."""
    if kind == "white with slightly heavy tails":
        return np.asarray(rng.standard_t(7.0, rows) * deviation * np.sqrt(5.0 / 7.0))
    return rng.normal(0.0, deviation, rows)


def _table(scene: Scene, laws: list[Law], rng: Generator, kind: str) -> pandas.DataFrame:
    """Return t (s), u, y, and ``clean``, which is y without noise and without laws that change the noise alone."""
    setup = installed(scene, laws)
    motion = scene.moved(setup, SUBSTEPS)
    noise = _noise(rng, kind, scene.rows, scene.noise)
    seen = observe(motion, setup, -scene.lead, scene.rows, noise)
    if kind == "white and rounded":
        # of a step of this size the multiple is below one, so that it is no quantisation to be found
        step = 0.25 * scene.noise
        seen = step * np.round(seen / step)
    quiet = installed(scene, [law for law in laws if law.identifier not in NOISE_LIKE])
    return pandas.DataFrame({
        "t": np.round(scene.rig.period * np.arange(scene.rows), 9),
        "u": motion.command[scene.lead : scene.lead + scene.rows],
        "y": seen,
        "clean": observe(motion, quiet, -scene.lead, scene.rows),
    })  # fmt: skip


def believed(rng: Generator, scene: Scene, laws: list[Law]) -> dict[str, Any]:
    """Return the simulation file of an engineer who knows the structure, and each coefficient within 40 %."""
    rig, camera = scene.rig, scene.camera
    wrong = [float(f"{value * rng.uniform(0.6, 1.4):.4g}") for value in (rig.gain, *rig.damping)]
    drive: dict[str, Any] = {"column": "u", "hold": "zoh"}
    if any(law.identifier == "input-bias" for law in laws):
        drive["bias"] = 0.0
    sensor: dict[str, Any] = {"column": "y", "kind": "instant"}
    if camera.exposure > 0.0:
        sensor = {"column": "y", "kind": "camera", "exposure": camera.exposure}
    if camera.latency > 0.0:
        sensor["latency"] = camera.latency
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": drive,
        "plant": {"transfer_function": {"numerator": wrong[:1], "denominator": [1.0, *wrong[1:], 0.0]}},
        "sensor": sensor,
        "initial_state": "estimate" if scene.lead > 0 else "zero",
        "effects": [],
    }


def staged(seed: int, index: int, count: int) -> tuple[Scene, list[Law], list[float], Generator]:
    """Return a recording's scene, its laws with their multiples, and the numbers that are drawn next."""
    rng = _generator(seed, count, index, 3)
    names = _names(seed, index, kinds(seed, count), rng)
    scene, laws, found = conceal(rng, names) if names else (stage(rng, ()), [], [])
    return with_offset(scene, laws, rng), laws, found, rng


def make(seed: int, index: int, count: int) -> Made:
    """Make recording number ``index`` of ``count``; the same numbers always give the same bytes."""
    scene, laws, found, rng = staged(seed, index, count)
    rounded = any(law.identifier in {"quantisation", "dropped-frames", "clipping"} for law in laws)
    noise = str(rng.choice(NOISES[:3] if rounded else NOISES))
    recording = _table(scene, laws, rng, noise)
    simulation = believed(rng, scene, laws)
    again = None
    if not any(law.identifier in PASSING for law in laws):
        again = _table(another(rng, scene), laws, rng, noise)
        again = again if np.all(np.isfinite(again.to_numpy())) else None
    decibels = 20.0 * np.log10(float(recording["clean"].std()) / scene.noise)
    kind, loop = kinds(seed, count)[index], scene.loop
    truth = {
        "kind": "single" if kind == "inexact" else kind,
        "excitation": scene.excitation,
        "rig": f"{scene.rig.name} ({scene.rig.command_unit} to {scene.rig.position_unit})",
        "noise": f"{noise}, {decibels:.0f} dB",
        "controller": f"{loop.kind}, {loop.bandwidth:.3g} rad/s, rows of {scene.rig.period:g} s",
        "effects": [
            {"id": law.identifier, "place": law.place, "law": law.law, "parameters": dict(law.parameters),
             "multiple": multiple}
            for law, multiple in zip(laws, found, strict=True)
        ],
    }  # fmt: skip
    return Made(recording.drop(columns="clean"), simulation, again, truth)
