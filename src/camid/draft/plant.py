"""A plant to start from: a resonance read off the output, before anything is fitted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction

Array = NDArray[np.float64]

# Where nothing can be read off.
DEFAULT_DAMPING = 0.1
LARGEST_DAMPING = 0.7
# Part of a free decay, by its envelope over the largest, that is small enough for a linear plant and above the noise.
DECAY = (0.05, 0.5)
FEWEST_SWINGS = 4


@dataclass(frozen=True)
class Resonance:
    """Natural frequency in rad/s, damping ratio, static gain and position of rest, all read off a recording."""

    natural_frequency: float
    damping: float
    gain: float
    rest: float

    def plant(self) -> TransferFunction:
        """Gain ω² / (s² + 2ξωs + ω²)."""
        square = self.natural_frequency**2
        return TransferFunction((self.gain * square,), (1.0, 2.0 * self.damping * self.natural_frequency, square))


def resonance_of(output: Array, signal: Array | None, period: float) -> Resonance:
    """What the output alone tells, and the ratio of spreads as the gain.

    Parameters
    ----------
    output : ndarray, shape (N,)
    signal : ndarray, shape (N,), or None
        Input; None for a free decay.
    period : float
        Seconds.
    """
    if signal is None:
        found = _decay(output, period)
        if found is not None:
            return found
    rest = float(np.mean(output))
    spread = 0.0 if signal is None else float(np.std(signal))
    gain = 1.0 if spread == 0.0 else float(np.std(output)) / spread
    return Resonance(_dominant_frequency(output - rest, period), DEFAULT_DAMPING, gain, rest)


def _dominant_frequency(values: Array, period: float) -> float:
    """Frequency in rad/s with the largest part of a signal, one period of the record at least."""
    size = np.abs(np.fft.rfft(values * np.hanning(len(values))))
    size[0] = 0.0
    peak = max(int(np.argmax(size)), 1)
    return 2.0 * np.pi * peak / (len(values) * period)


def _decay(output: Array, period: float) -> Resonance | None:
    """Resonance of a free decay from the turning points of its small swings; None if there are too few."""
    rest = float(np.median(output[len(output) // 2 :]))
    for _ in range(3):  # the position of rest is between the turning points, which it separates
        rows, heights = _turning_points(output - rest)
        if len(rows) < FEWEST_SWINGS:
            return None
        rest += float(np.mean(0.5 * (heights[1:] + heights[:-1])[len(heights) // 2 - 1 :]))
    rows, heights = _turning_points(output - rest)
    if len(rows) < FEWEST_SWINGS:
        return None
    envelope = np.abs(heights) / np.max(np.abs(heights))
    small = (envelope > DECAY[0]) & (envelope < DECAY[1])
    if small.sum() < FEWEST_SWINGS:
        small = envelope > DECAY[0]
    rows, envelope = rows[small], envelope[small]
    if len(rows) < FEWEST_SWINGS:
        return None
    half = float(np.median(np.diff(rows))) * period
    slope = float(np.polyfit(rows * period, np.log(envelope), 1)[0])
    damped = np.pi / half
    rate = max(-slope, 0.0)
    natural = float(np.hypot(damped, rate))
    return Resonance(natural, min(rate / natural, LARGEST_DAMPING), 1.0, rest)


def _turning_points(values: Array) -> tuple[NDArray[np.intp], Array]:
    """Rows and values of the farthest point between each two crossings of zero that are real swings."""
    floor = 0.02 * float(np.max(np.abs(values)))
    signs = np.sign(np.where(np.abs(values) > floor, values, 0.0))
    known = np.flatnonzero(signs)
    if known.size == 0:
        return np.zeros(0, np.intp), np.zeros(0)
    parts = np.split(known, np.flatnonzero(np.diff(signs[known])) + 1)
    rows = np.array([part[np.argmax(np.abs(values[part]))] for part in parts[1:-1]], dtype=np.intp)
    return rows, values[rows]
