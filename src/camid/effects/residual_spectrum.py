"""Lines in the spectrum of a residual, for the first guesses of what oscillates."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi

import numpy as np

from camid.effects.base import Array
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


def phasor_at(situation: Situation, angular: float, time: Array) -> complex:
    """Phasor P of the sinusoid |P| sin(ω t + arg P) that the residual shows at ω in rad/s, in its units.

    Parameters
    ----------
    situation : Situation
    angular : float
    time : ndarray, shape (N,)
        Of the rows in s, by the clock that the phase is counted by.
    """
    window = np.hanning(len(situation.residual))
    return complex(2j * (situation.residual @ (np.exp(-1j * angular * time) * window)) / np.sum(window))
