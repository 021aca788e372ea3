"""Frequencies at which a residual has its highest lines, for the first guesses of what oscillates."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

import numpy as np

from camid.effects.situation import Situation

# Points of the transform for a row, and how many around a line belong to it.
OVERSAMPLING = 4
WIDTH = 10


def highest_lines(situation: Situation, count: int) -> Iterator[float]:
    """Angular frequencies in rad/s of at most this many lines, the highest first."""
    rows, period = len(situation.residual), situation.acquisition.period
    power = np.abs(np.fft.rfft(situation.residual * np.hanning(rows), OVERSAMPLING * rows))
    frequencies = 2.0 * pi * np.fft.rfftfreq(OVERSAMPLING * rows, period)
    power[frequencies < 2.0 * pi / (rows * period)] = 0.0
    for _ in range(count):
        i = int(np.argmax(power))
        if power[i] == 0.0:
            return
        yield float(frequencies[i])
        power[max(i - WIDTH, 0) : i + WIDTH + 1] = 0.0
