"""Recordings of synthetic rigs, with what their users believe of them and what is concealed in them."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas

from .belief import believed
from .chain import observe, run
from .concealment import Scene, conceal, draw_company, draw_drive, stage, turns_over
from .excitations import EXCITATIONS, Generator
from .laws import CATALOGUE, NOISE_LAWS, OUTSIDE, Law
from .noise import WHITE, draw_noise, draw_spectrum, spoil
from .proposals import suits
from .rigs import Rig
from .unusual import INEXACT

Array = np.ndarray[Any, np.dtype[np.float64]]

SHARES = {"none": 0.40, "single": 0.25, "several": 0.15, "outside": 0.10, "inexact": 0.10}
# laws that act by the clock, or that begin at a time: another recording does not have them
PASSING = frozenset({"impulse-disturbance", "periodic-disturbance", "step-disturbance", "parameter-drift",
                     "sensor-drift", "clock-skew", "bumped-camera", "breathing-scale", "pumped-stiffness"})  # fmt: skip


@dataclass(frozen=True)
class Made:
    """A recording, what its user believes, another recording of the same rig, and the truth.

    ``recording`` has the columns t (s), u and y; a closed loop also r, the reference; a free decay has no u. Cells are
    in the unit that the simulation declares. ``again`` has one more column, ``clean``: what a fit compares without its
    noise, the output, or in a closed loop the control. In ``truth`` the parameters of effects are in the plant's units
    of u and y (SI where the simulation declares a unit) and in seconds.
    """

    recording: pandas.DataFrame
    simulation: dict[str, Any]
    again: pandas.DataFrame | None
    truth: dict[str, Any]


def kinds(seed: int, count: int) -> list[str]:
    """Return the kind of each of ``count`` recordings; the shares are kept as closely as whole numbers can."""
    exact = {kind: share * count for kind, share in SHARES.items()}
    whole = {kind: int(value) for kind, value in exact.items()}
    by_rest = sorted(SHARES, key=lambda kind: (whole[kind] - exact[kind], kind))
    for kind in by_rest[: count - sum(whole.values())]:
        whole[kind] += 1
    listed = [kind for kind in SHARES for _ in range(whole[kind])]
    order = np.random.default_rng(np.random.SeedSequence([seed, count, 1])).permutation(count)
    return [listed[int(k)] for k in order]


def _identifiers(seed: int, index: int, listed: list[str], rng: Generator) -> tuple[str, ...]:
    """Return the ids of what is concealed; each kind goes through all of its ids before one comes again."""
    kind = listed[index]
    if kind == "none":
        return ()
    if kind == "several":
        return draw_company(rng)
    names = sorted({"single": tuple(CATALOGUE), "outside": OUTSIDE, "inexact": tuple(INEXACT)}[kind])
    turn = sum(other == kind for other in listed[:index])
    order = np.random.default_rng(np.random.SeedSequence([seed, len(names), 2])).permutation(len(names))
    return (names[int(order[turn % len(names)])],)


def _measured(
    scene: Scene, drive: Array, laws: list[Law], rng: Generator, noise: str, spectrum: tuple[float, ...]
) -> pandas.DataFrame:
    """Return what is recorded of one run, in units of the cells; ``clean`` is what is compared without noise."""
    rig = scene.rig
    made = run(rig, [law for law in laws if law.identifier not in NOISE_LAWS], drive)
    clean = made.compared(rig)
    seen = made.output
    for law in laws:
        if law.identifier == "timestamp-jitter":
            jitter = rng.normal(0.0, float(law.parameters["std"]), seen.size)
            seen = observe(made.trajectory, made.time, made.sensing, jitter)
    # the period has few digits, and so have the times
    table = {"t": np.round(made.time, 9)}
    if rig.controller is not None:
        relative = scene.deviation / float(clean.std())
        table["r"] = drive
        table["u"] = clean + draw_noise(rng, noise, clean.size, scene.deviation, spectrum)
        table["y"] = seen + draw_noise(rng, noise, seen.size, relative * float(seen.std()) * 0.1)
        return pandas.DataFrame({**table, "clean": clean})
    if rig.driven:
        table["u"] = drive
    noisy = seen + draw_noise(rng, noise, seen.size, scene.deviation, spectrum)
    table["y"] = spoil(noisy, laws, rng, scene.deviation) * rig.cells
    return pandas.DataFrame({**table, "clean": clean * rig.cells})


def _another(rng: Generator, scene: Scene, laws: list[Law]) -> tuple[Scene, Array] | None:
    """Return the same rig with another excitation, or another start of a free decay; None where there is none."""
    if any(law.identifier in PASSING for law in laws):
        return None
    rig: Rig = scene.rig
    names = [name for name in EXCITATIONS if name != scene.excitation
             and all(suits(law.identifier, rig, name) for law in laws)]  # fmt: skip
    excitation = str(rng.choice(names)) if rig.driven else scene.excitation
    if rig.initial is not None:
        factor, turn = float(rng.uniform(0.6, 0.9)), float(rng.normal(0.0, 0.3))
        position, velocity = rig.initial
        rig = replace(rig, initial=(factor * position, factor * velocity + turn * position / rig.pace))
    drive = draw_drive(rng, rig, excitation)
    made = run(rig, [law for law in laws if law.identifier not in NOISE_LAWS], drive)
    if not np.all(np.isfinite(made.output)) or turns_over(rig, made.output):
        return None
    return replace(scene, rig=rig, excitation=excitation), drive


def _scene(rng: Generator, identifiers: tuple[str, ...], way: str) -> tuple[Scene, list[Law], list[float | None]]:
    """Return a scene, and the laws that are concealed in it with their multiples."""
    if identifiers and identifiers != ("coloured-noise",):
        return conceal(rng, identifiers, way)
    while True:
        scene = stage(rng, identifiers)
        if scene is not None:
            return scene, [], []


def make(seed: int, index: int, count: int) -> Made:
    """Make recording number ``index`` of ``count``; the same numbers always give the same bytes."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, count, index, 3]))
    listed = kinds(seed, count)
    kind = listed[index]
    identifiers = _identifiers(seed, index, listed, rng)
    scene, laws, found = _scene(rng, identifiers, kind if kind in {"inexact", "outside"} else "catalogue")
    noise = str(rng.choice(WHITE))
    spectrum: tuple[float, ...] = ()
    declared = kind == "none" and scene.rig.controller is None and rng.random() < 0.1
    if declared or identifiers == ("coloured-noise",):
        spectrum, noise = draw_spectrum(rng), "white Gaussian"
    if identifiers == ("coloured-noise",):
        parameters: dict[str, Any] = {"spectrum": list(spectrum)}
        laws, found = [Law("coloured-noise", "noise", "catalogue", parameters)], [None]
    recording = _measured(scene, scene.drive, laws, rng, noise, spectrum).drop(columns="clean")
    simulation = believed(rng, scene.rig, scene.bias_known, spectrum if declared else ())
    other = _another(rng, scene, laws)
    again = None if other is None else _measured(other[0], other[1], laws, rng, noise, spectrum)
    colour = f", autoregression of order {len(spectrum)}{' (declared)' if declared else ''}" if spectrum else ""
    decibels = 20.0 * np.log10(float(run(scene.rig, [], scene.drive).compared(scene.rig).std()) / scene.deviation)
    truth = {
        "kind": "single" if kind == "inexact" else kind,
        "excitation": scene.excitation,
        "rig": scene.rig.name,
        "noise": f"{noise}{colour}, {decibels:.0f} dB",
        "effects": [
            {
                "id": law.identifier,
                "place": law.place,
                "law": law.law,
                "parameters": dict(law.parameters),
                "multiple": size,
            }
            for law, size in zip(laws, found, strict=True)
        ],
    }
    return Made(recording, simulation, again, truth)
