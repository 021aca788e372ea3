"""Inputs of the concealed recordings, drawn afresh for every recording of a rig."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.chain.excitation import multilevel, multisine, pseudo_random_binary_sequence

Array = NDArray[np.float64]

TWO_LEVEL = "prbs"
KINDS = (
    TWO_LEVEL,
    "two-amplitude-prbs",
    "multilevel",
    "multisine",
    "periodic-multisine",
    "chirp",
    "filtered-noise",
    "staircase",
    "periodic-staircase",
)
MANY_LEVELS = KINDS[2:]


@dataclass(frozen=True)
class Excitation:
    """A way to draw inputs.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    amplitude, mean : float
        V.
    clock : int
        Frames between possible changes of a piecewise constant input.
    band : float
        Highest frequency of the others, in cycles per frame.
    """

    kind: str
    amplitude: float
    mean: float
    clock: int
    band: float

    def draw(self, generator: np.random.Generator, length: int) -> Array:
        """Input samples in V, shape (length,)."""
        return self.mean + self.amplitude * self._unit(generator, length)

    def _unit(self, generator: np.random.Generator, length: int) -> Array:
        """Of an amplitude of about one."""
        if self.kind in {"prbs", "two-amplitude-prbs"}:
            sequence = self._held(pseudo_random_binary_sequence(11), generator, length)
            low = 1.0 if self.kind == "prbs" else 0.35
            return sequence * np.where(np.arange(length) < length // 2, low, 1.0)
        if self.kind == "multilevel":
            return self._held(multilevel(11, int(generator.integers(5, 25)), generator), generator, length)
        if self.kind in {"staircase", "periodic-staircase"}:
            steps = length // (6 * self.clock) + 1
            levels = generator.uniform(-1.0, 1.0, steps if self.kind == "staircase" else max(steps // 4, 8))
            return np.resize(np.repeat(levels, 6 * self.clock), length)
        if self.kind == "chirp":
            cycles = np.linspace(0.02 * self.band, self.band, length)
            return np.sin(2.0 * np.pi * (np.cumsum(cycles) + generator.uniform()))
        if self.kind == "filtered-noise":
            from scipy.signal import butter, sosfilt

            filtered = sosfilt(butter(2, 2.0 * self.band, output="sos"), generator.standard_normal(length + 500))[500:]
            return filtered / np.std(filtered) * 0.5
        period = length if self.kind == "multisine" else length // int(generator.integers(3, 6))
        last = max(int(self.band * period), 8)
        lines = np.arange(1, min(last, (period - 1) // 2) + 1)
        signal = multisine(period, lines.tolist(), phases="random", generator=generator)
        return np.resize(0.5 * signal, length)

    def _held(self, levels: Array, generator: np.random.Generator, length: int) -> Array:
        """Levels held for the clock's frames, from a random place of the sequence on."""
        shifted = np.roll(levels, int(generator.integers(len(levels))))
        return np.resize(np.repeat(shifted, self.clock), length)


def draw_excitation(
    generator: np.random.Generator, kinds: tuple[str, ...], size: float, rate: float, period: float, zero_mean: bool
) -> Excitation:
    """An input that moves a machine.

    Parameters
    ----------
    generator : numpy.random.Generator
    kinds : tuple of str
        To choose from.
    size : float
        Amplitude in V.
    rate, period : float
        Natural frequency of the machine in rad/s and the camera's period in s: the input's band reaches beyond it.
    zero_mean : bool
        Whether the input must not have a mean.
    """
    kind = kinds[int(generator.integers(len(kinds)))]
    mean = (
        0.0 if zero_mean or generator.random() < 0.65 else generator.choice([-1.0, 1.0]) * generator.uniform(0.1, 0.5)
    )
    clock = max(1, round(generator.uniform(0.2, 0.6) / (rate * period)))
    band = float(np.clip(generator.uniform(1.5, 4.0) * rate * period / (2.0 * np.pi), 0.01, 0.4))
    return Excitation(kind, size, float(mean * size), clock, band)
