"""Recordings of a rig: equations of motion over held inputs, and the mean over each exposure, to nine digits.

The integral of the output is one state more, so that a camera's mean is exact; steps end where an exposure begins.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from math import ceil

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.integrate import DOP853

from .rigs import Rig

Array = NDArray[np.float64]

# Steps of the eighth order within a period of the frames.
STEPS = 6
# Runge-Kutta method by Dormand and Prince: stages and weights.
STAGES = np.asarray(DOP853.A)
WEIGHTS = np.asarray(DOP853.B)


def frames(rig: Rig, levels: Sequence[float], steps: int = STEPS) -> Array:
    """What the camera delivers without noise and offset.

    Parameters
    ----------
    rig : Rig
    levels : sequence of float
        Input that is held before the first frame, and from each frame to the next, shape (N,).
    steps : int
        Of the integration within a period.

    Returns
    -------
    ndarray, shape (N,)
        Mean of the output over the exposure that ends with each frame.
    """
    state = np.array([*rig.start, 0.0])
    parts = [(rig.period - rig.exposure, 0), (rig.exposure, 1)]
    means = np.empty(len(levels))
    for k, level in enumerate(levels):
        for duration, exposed in parts:
            state[-1] = 0.0
            # Both parts of a period have steps of about one length.
            count = ceil(steps * duration / rig.period) if duration > 0.0 else 0
            for _ in range(count):
                state = _step(rig, state, level, duration / count)
            if exposed:
                means[k] = state[-1] / rig.exposure
    return means


def _step(rig: Rig, state: Array, level: float, duration: float) -> Array:
    """State after a step of ``duration`` seconds, shape (n + 1,); the last one is the integral of the output."""
    slopes = np.empty((len(WEIGHTS), len(state)))
    for i in range(len(WEIGHTS)):
        here = (state + duration * (STAGES[i, :i] @ slopes[:i])).tolist() if i else state.tolist()
        slopes[i] = (*rig.rates(here, level, rig.truth), rig.output(here))
    return np.asarray(state + duration * (WEIGHTS @ slopes))


def excitation(rig: Rig, rng: np.random.Generator) -> Array:
    """Levels of the input, shape (frames,), each held for a random number of frames; zero for a free decay."""
    levels: list[float] = []
    while len(levels) < rig.frames:
        held = int(rng.integers(1, rig.longest_hold + 1))
        level = rig.amplitude * float(rng.uniform(0.4, 1.0)) * float(rng.choice([-1.0, 1.0]))
        levels += [rig.middle + level] * held
        if rig.mirrored:
            levels += [rig.middle - level] * held
    return np.array(levels[: rig.frames])


def generator(rig: Rig, seed: int) -> np.random.Generator:
    """Random numbers of one recording: another rig has others with the same seed."""
    return np.random.default_rng([seed, zlib.crc32(rig.name.encode())])


def believed_constants(rig: Rig, rng: np.random.Generator) -> dict[str, float]:
    """What the user believes: constants that he does not know are off by up to a factor of two, to both sides."""
    return {
        name: value if name in rig.fixed else float(f"{value * 2.0 ** rng.uniform(-1.0, 1.0):.4g}")
        for name, value in rig.truth.items()
    }


def record(rig: Rig, rng: np.random.Generator, noise: float | None = None) -> pd.DataFrame:
    """A recording with columns ``t`` (s), ``u`` unless the rig decays freely, and ``y``.

    Parameters
    ----------
    rig : Rig
    rng : Generator
        Of input and noise.
    noise : float, optional
        In place of the rig's own share of the output's standard deviation.
    """
    levels = excitation(rig, rng)
    # What the actuator did before the recording: nothing, or what kept the rig where it was.
    seen = frames(rig, [rig.middle if not rig.at_rest else 0.0, *levels[:-1]])
    share = rig.noise if noise is None else noise
    measured = seen + rig.offset + share * float(np.std(seen)) * rng.standard_normal(rig.frames)
    table = {"t": rig.period * np.arange(rig.frames), "u": levels, "y": measured}
    if rig.decays_freely:
        del table["u"]
    return pd.DataFrame(table)
