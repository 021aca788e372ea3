"""What a recording shows of a force that repeats along the way, by the plant's equation at the recorded positions.

A simulation that lacks a force beside strong friction sticks at other places than the rig, and what it leaves repeats
along no way. The plant's equation, with the recorded positions and their derivatives in it, needs no simulation. It
yields first guesses alone: noise in the derivatives bends it (an equation error; Ljung 1999, section 7.3), and what a
recording says is judged by simulations.
"""

from __future__ import annotations

from math import atan2, hypot, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.effects.situation import Situation

Array = NDArray[np.float64]

# Edges of the low-pass filter that all signals go through, as a share of half the frame rate, and its order.
CUT_OFFS, FILTER_ORDER = (0.05, 0.15, 0.4), 3
# Poles of a plant up to which its equation is looked at: each one is a derivative.
MOST_POLES = 3
# Speed, as a share of its root mean square, at which dry friction has turned round.
TURNED_ROUND = 0.05
# A wave that is worth a guess leaves less than this share of what is left without it.
MOST_LEFT = 0.8
# Rows that are looked at.
MOST_ROWS = 20_000


class EquationAtRecordedPositions:
    """The plant's equation with the recorded positions in it, filtered, and a wave of the position beside.

    Parameters
    ----------
    situation : Situation
    cut_off : float
        Edge of the low-pass filter as a share of half the frame rate.
    """

    def __init__(self, situation: Situation, cut_off: float) -> None:
        from scipy.signal import butter

        situation = situation.until(MOST_ROWS)
        self._sections = butter(FILTER_ORDER, cut_off, output="sos")
        self._position = situation.recorded
        period = situation.acquisition.period
        derivatives = [self._filtered(self._position)]
        for _ in range(len(situation.plant.denominator) - 1):
            derivatives.append(np.gradient(derivatives[-1], period))
        speed = derivatives[1]
        slow = TURNED_ROUND * float(np.sqrt(np.mean(speed**2))) or 1.0
        friction = self._filtered(np.tanh(speed / slow))
        table = np.column_stack([np.ones(len(speed)), friction, *derivatives])
        self._basis = np.linalg.qr(table / np.maximum(np.linalg.norm(table, axis=0), 1e-300))[0]
        command = self._filtered(situation.signal if situation.command is None else situation.command)
        self._left = command - self._basis @ (self._basis.T @ command)

    def _filtered(self, values: Array) -> Array:
        from scipy.signal import sosfiltfilt

        filtered: Array = sosfiltfilt(self._sections, values)
        return filtered

    def wave(self, period: float) -> tuple[float, float, float]:
        """Share of the rest that a wave of a period leaves, its amplitude, and its phase at zero."""
        angle = 2.0 * pi * self._position / period
        pair = np.column_stack([self._filtered(np.sin(angle)), self._filtered(np.cos(angle))])
        pair -= self._basis @ (self._basis.T @ pair)
        (along, across), *_ = np.linalg.lstsq(pair, self._left, rcond=None)
        left = self._left - pair @ [along, across]
        share = float(left @ left) / max(float(self._left @ self._left), 1e-300)
        return share, hypot(along, across), atan2(across, along)


def waves_of_force(situation: Situation, periods: Array, most: int) -> list[dict[str, Any]]:
    """Waves of the position that explain much of the command which moves the plant as recorded, the best first.

    Parameters
    ----------
    situation : Situation
    periods : ndarray, shape (P,)
        Periods to try, in units of the output.
    most : int
        How many.

    Returns
    -------
    list of dict
        ``amplitude`` in units of the input, ``period`` and ``phase``; empty where none explains a fifth of the rest.
    """
    plant = situation.plant
    if len(plant.denominator) - 1 not in range(1, MOST_POLES + 1) or len(situation.recorded) < 10 * FILTER_ORDER:
        return []
    equations = [EquationAtRecordedPositions(situation, cut_off) for cut_off in CUT_OFFS]
    waves = min(([e.wave(float(period)) for period in periods] for e in equations), key=min)
    shares = np.array([share for share, _, _ in waves])
    found: list[dict[str, Any]] = []
    while np.min(shares) < MOST_LEFT and len(found) < most:
        i = int(np.argmin(shares))
        _, amplitude, phase = waves[i]
        found.append({"amplitude": amplitude, "period": float(periods[i]), "phase": phase})
        shares[max(i - 2, 0) : i + 3] = 1.0
    return found
