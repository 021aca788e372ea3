"""A picture of every effect in the catalogue: the output with and without it, and what is missing without it."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction, second_order
from camid.effects import Effect, Situation, known_effects
from camid.engine.mechanics import Chain
from camid.engine.run import run

PERIOD, FRAMES, SHOWN, FINE = 0.02, 400, 150, 10
PLANT = second_order(1.0, 10.0, 0.1)
# For effects that the resonance cannot have.
STORAGE = TransferFunction((2.0,), (1.0, 2.0))
# Change of the output, as a share of its spread, that can be seen in a picture and leaves the motion what it is.
VISIBLE = 0.5
WITHOUT, WITH, MISSING = "#8a8a8a", "#1f6fb4", "#c2410c"


def situation(plant: TransferFunction = PLANT) -> Situation:
    """A driven resonance, or storage, seen by a camera at 50 frames per second: four levels of input."""
    generator = np.random.default_rng(5)
    signal = np.repeat(generator.choice([-1.0, -0.5, 0.4, 1.0], FRAMES // 10), 10)
    acquisition = Acquisition(PERIOD)
    position = sample(plant, signal, acquisition)
    return Situation(
        np.asarray(PERIOD * np.arange(FRAMES), dtype=np.float64),
        signal,
        position,
        position,
        np.gradient(position, PERIOD),
        0.3 * np.sin(11.0 * PERIOD * np.arange(FRAMES)),  # for first guesses that look for a period
        plant,
        acquisition,
        np.ones(FRAMES, bool),
    )


def shown_effect(kind: type[Effect], given: Situation) -> tuple[Effect, np.ndarray] | None:
    """The first guess, at one of several sizes, whose change of the output is nearest to `VISIBLE`; and that output."""
    best: tuple[float, Effect, np.ndarray] | None = None
    # Among the first guesses are laws with more detail, which have no picture of their own.
    for guess in (each for each in kind.candidates(given) if type(each) is kind):
        for factor in (1.0, 4.0, 16.0):
            try:
                effect = guess if factor == 1.0 else guess.scaled(factor)
                output = run(Chain(given.plant, given.acquisition, (effect,)), given.signal, given.time)
            except (ValueError, ArithmeticError):
                continue
            change = float(np.sqrt(np.mean((output - given.position) ** 2)) / np.std(given.position))
            if not np.isfinite(change) or change < 1e-6:
                continue
            distance = abs(np.log(change / VISIBLE))
            if best is None or distance < best[0]:
                best = distance, effect, output
    return None if best is None else (best[1], best[2])


def missing_force(effect: Effect, given: Situation) -> tuple[np.ndarray, np.ndarray]:
    """Time in s and the input that the plant alone would lack, from the motion at a tenth of the period.

    b0 (u + missing) = ÿ + a1 ẏ + a0 y, or ẏ + a0 y of a storage, with the derivatives from central differences.
    """
    step = PERIOD / FINE
    signal = np.repeat(given.signal, FINE)
    time = np.asarray(step * np.arange(len(signal)), dtype=np.float64)
    motion = run(Chain(given.plant, Acquisition(step, sensor="instant"), (effect,)), signal, time)
    velocity = (motion[2:] - motion[:-2]) / (2.0 * step)
    acceleration = (motion[2:] - 2.0 * motion[1:-1] + motion[:-2]) / step**2
    derivatives = [motion[1:-1], velocity, acceleration]
    # An average over a frame smooths what rounding and the corners of the input leave in second differences.
    driven = sum(a * d for a, d in zip(given.plant.denominator[::-1], derivatives, strict=False))
    force = driven / given.plant.numerator[0] - 0.5 * (signal[1:-1] + signal[:-2])
    kernel = np.ones(FINE) / FINE
    return time[1:-1], np.convolve(force, kernel, "same")


def draw(kind: type[Effect], given: Situation) -> Figure | None:
    """Output with and without the effect, and below what a simulation without it lacks; None for noise."""
    if kind.noise_like:
        return None
    if kind.invisible(given) is not None:
        given = situation(STORAGE)
    found = shown_effect(kind, given)
    if found is None:
        return None
    effect, output = found
    at_sensor = kind.place == "sensor"
    figure = Figure(figsize=(6.4, 2.9), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[1.5, 1.0])
    upper.plot(given.time[:SHOWN], given.position[:SHOWN], color=WITHOUT, label="without")
    upper.plot(given.time[:SHOWN], output[:SHOWN], color=WITH, label="with")
    upper.set_ylabel("output y")
    upper.legend(loc="upper right", ncols=2, fontsize=8, frameon=False)
    if at_sensor or kind.declare is not Effect.declare:
        lower.plot(given.time[:SHOWN], (output - given.position)[:SHOWN], color=MISSING)
        lower.set_ylabel("difference")
    else:
        time, force = missing_force(effect, given)
        inside = time < given.time[SHOWN]
        lower.plot(time[inside], force[inside], color=MISSING, linewidth=1.0)
        lower.set_ylabel("missing\nforce (u)")
    lower.axhline(0.0, color="#cccccc", linewidth=0.8, zorder=0)
    lower.set_xlabel("time (s)")
    values = ", ".join(
        f"{p.name.replace('_', ' ')} {v if isinstance(v, str) else format(v, '.3g')} {p.unit}".rstrip()
        for p, v in zip(kind.parameters, effect.values.values(), strict=True)
    )
    upper.set_title(values, fontsize=9, loc="left")
    for axes in (upper, lower):
        axes.spines[["top", "right"]].set_visible(False)
    return figure


def save_all(folder: Path) -> list[str]:
    """Draw every effect into ``folder`` as ``<identifier>.png``; the identifiers that have a picture."""
    folder.mkdir(parents=True, exist_ok=True)
    given, drawn = situation(), []
    settings: dict[Any, Any] = {"font.size": 9.0, "font.family": "DejaVu Sans", "svg.hashsalt": "camid"}
    with mpl.rc_context(settings), warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        for identifier, kind in sorted(known_effects().items()):
            figure = draw(kind, given) if kind.__module__.startswith("camid.") else None
            if figure is not None:
                figure.savefig(folder / f"{identifier}.png", dpi=100, metadata={"Software": None})
                drawn.append(identifier)
    return drawn


if __name__ == "__main__":
    save_all(Path(sys.argv[1]))
