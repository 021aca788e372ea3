"""Inputs and references that a machine may be driven with; all start at the time zero and lie between -1 and 1.

Times are counted in samples; ``pace`` is the number of samples in which the rig reacts (its time constant, or the time
in which its oscillation advances by one radian).
"""

from collections.abc import Callable
from typing import Any, Literal

import numpy as np
from scipy import signal

Array = np.ndarray[Any, np.dtype[np.float64]]
Generator = np.random.Generator


def _held(rng: Generator, levels: Array, samples: int, shortest: float, longest: float) -> Array:
    """Return random choices of levels, each held for a random number of samples between two numbers."""
    values = np.empty(samples)
    k = 0
    while k < samples:
        length = max(1, round(float(rng.uniform(shortest, longest))))
        values[k : k + length] = rng.choice(levels)
        k += length
    return values


def _prbs(rng: Generator, samples: int, clock: int) -> Array:
    """Return a binary sequence of maximum length, of order 9, each bit held for ``clock`` samples."""
    bits, _ = signal.max_len_seq(9, state=rng.integers(1, 2, 9), length=samples // clock + 1)
    shift = int(rng.integers(0, 511))
    return np.asarray(np.repeat(np.roll(2.0 * bits - 1.0, shift), clock)[:samples], dtype=float)


def _multisine(rng: Generator, samples: int, pace: float, lines: int) -> Array:
    """Return sines of random phases below twice the rig's natural frequency."""
    top = samples / (np.pi * pace)
    chosen = np.unique(np.round(np.linspace(2.0, max(top, lines + 3.0), lines)))
    phases = rng.uniform(0.0, 2.0 * np.pi, chosen.size)
    time = np.arange(samples) / samples
    wave = np.sum(np.sin(2.0 * np.pi * chosen[:, None] * time + phases[:, None]), axis=0)
    return np.asarray(wave / np.abs(wave).max())


def _chirp(samples: int, pace: float, method: Literal["linear", "logarithmic"]) -> Array:
    """Return a sweep from a tenth of the rig's natural frequency to three times it."""
    k: Array = np.arange(samples, dtype=np.float64)
    low, high = 0.1 / (2.0 * np.pi * pace), min(3.0 / (2.0 * np.pi * pace), 0.2)
    return np.asarray(signal.chirp(k, low, float(samples), high, method=method, phi=-90.0))


def _filtered_noise(rng: Generator, samples: int, pace: float) -> Array:
    """Return Gaussian noise through a low-pass filter, clipped at two standard deviations."""
    corner = min(0.9, 2.0 / (np.pi * pace) * float(rng.uniform(0.7, 2.0)))
    numerator, denominator = signal.butter(2, corner)
    noise = signal.lfilter(numerator, denominator, rng.standard_normal(samples))
    return np.asarray(np.clip(noise / (2.0 * noise.std()), -1.0, 1.0))


def _periodic(samples: int, length: float, wave: Callable[[Array], Array]) -> Array:
    """Return a wave, a function of the phase in turns, with a period of that many samples."""
    return np.asarray(wave(np.arange(samples) / length))


def _ramps(rng: Generator, samples: int, pace: float) -> Array:
    """Return straight lines between random levels, with rests in between."""
    knots, values, k = [0.0], [0.0], 0.0
    while k < samples:
        k += float(rng.uniform(2.0, 8.0)) * pace
        level = float(rng.uniform(-1.0, 1.0))
        knots.append(k)
        values.append(level)
        k += float(rng.uniform(0.0, 5.0)) * pace
        knots.append(k + 0.01)
        values.append(level)
    return np.asarray(np.interp(np.arange(samples), knots, values))


def _cycle(rng: Generator, samples: int, pace: float) -> Array:
    """Return a machine's cycle that repeats: fast there, a rest, slow back, a rest; each move has smooth ends."""
    lengths = pace * rng.uniform([3.0, 2.0, 6.0, 2.0], [6.0, 6.0, 14.0, 6.0])
    ends = np.cumsum(lengths)
    phase = np.mod(np.arange(samples), ends[-1])
    out = np.clip(phase / lengths[0], 0.0, 1.0)
    back = np.clip((phase - ends[1]) / lengths[2], 0.0, 1.0)
    return np.asarray((out**2 * (3.0 - 2.0 * out) - back**2 * (3.0 - 2.0 * back)) * 1.8 - 0.8)


def _bursts(rng: Generator, samples: int, pace: float) -> Array:
    """Return sine bursts of random sizes with rests between them."""
    k = np.arange(samples)
    length = float(rng.uniform(25.0, 50.0)) * pace
    sizes = rng.uniform(0.3, 1.0, int(samples / length) + 1)
    inside = np.mod(k, length) < 0.7 * length
    return np.asarray(sizes[(k / length).astype(np.int64)] * np.sin(k * float(rng.uniform(0.5, 1.3)) / pace) * inside)


def _stairs(rng: Generator, samples: int, pace: float) -> Array:
    """Return stairs up and down in equal steps."""
    treads = int(rng.integers(4, 8))
    shape = np.concatenate([np.arange(-treads, treads), np.arange(treads, -treads, -1)]) / treads
    steps = (np.arange(samples) / (pace * float(rng.uniform(3.0, 6.0)))).astype(np.int64)
    return np.asarray(shape[(steps + treads) % shape.size])


def _pulses(rng: Generator, samples: int, pace: float) -> Array:
    """Return pulses of random sizes and signs with rests between them."""
    levels = np.concatenate([np.zeros(3), rng.uniform(-1.0, 1.0, 6)])
    return _held(rng, levels, samples, 1.0 * pace, 5.0 * pace)


def _steps(rng: Generator, samples: int, pace: float) -> Array:
    """Return steps to random levels."""
    return _held(rng, rng.uniform(-1.0, 1.0, 24), samples, 2.0 * pace, 12.0 * pace)


def _beat(rng: Generator, samples: int, pace: float) -> Array:
    """Return two sines whose sum swells and fades."""
    k = np.arange(samples) / pace
    first = float(rng.uniform(0.6, 1.1))
    return np.asarray(0.5 * (np.sin(first * k) + np.sin(first * float(rng.uniform(1.1, 1.3)) * k)))


def _swelling(rng: Generator, samples: int, pace: float) -> Array:
    """Return a square wave whose size grows from a fifth to one."""
    k = np.arange(samples)
    period = float(rng.uniform(9.0, 16.0)) * pace
    return np.asarray((0.2 + 0.8 * k / samples) * np.where(np.mod(k / period, 1.0) < 0.5, 1.0, -1.0))


EXCITATIONS: dict[str, Callable[[Generator, int, float], Array]] = {
    "prbs, fast": lambda rng, n, pace: _prbs(rng, n, max(1, round(0.5 * pace))),
    "prbs": lambda rng, n, pace: _prbs(rng, n, max(1, round(1.5 * pace))),
    "prbs, slow": lambda rng, n, pace: _prbs(rng, n, max(2, round(4.0 * pace))),
    "three levels": lambda rng, n, pace: _held(rng, np.array([-1.0, 0.0, 1.0]), n, pace, 5.0 * pace),
    "random telegraph": lambda rng, n, pace: _held(rng, np.array([-1.0, 1.0]), n, 0.7 * pace, 9.0 * pace),
    "steps of random levels": _steps,
    "pulses": _pulses,
    "white levels": lambda rng, n, pace: _held(rng, rng.uniform(-1.0, 1.0, 400), n, 1.0, max(1.0, pace)),
    "multisine, sparse": lambda rng, n, pace: _multisine(rng, n, pace, 8),
    "multisine, dense": lambda rng, n, pace: _multisine(rng, n, pace, 40),
    "linear chirp": lambda _, n, pace: _chirp(n, pace, "linear"),
    "logarithmic chirp": lambda _, n, pace: _chirp(n, pace, "logarithmic"),
    "filtered noise": _filtered_noise,
    "square wave": lambda rng, n, pace: _periodic(
        n, pace * float(rng.uniform(8.0, 20.0)), lambda turn: np.where(np.mod(turn, 1.0) < 0.5, 1.0, -1.0)
    ),
    "swelling square wave": _swelling,
    "triangle": lambda rng, n, pace: _periodic(
        n, pace * float(rng.uniform(8.0, 20.0)), lambda turn: 4.0 * np.abs(np.mod(turn - 0.25, 1.0) - 0.5) - 1.0
    ),
    "sawtooth": lambda rng, n, pace: _periodic(
        n, pace * float(rng.uniform(10.0, 25.0)), lambda turn: 2.0 * np.mod(turn + 0.5, 1.0) - 1.0
    ),
    "ramps and rests": _ramps,
    "machine cycle": _cycle,
    "sine bursts": _bursts,
    "stairs": _stairs,
    "beat": _beat,
}
TWO_LEVELS = frozenset({"prbs, fast", "prbs", "prbs, slow", "random telegraph", "square wave"})
