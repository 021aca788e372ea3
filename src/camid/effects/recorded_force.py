"""What a recording shows of a force that repeats along the way, by the plant's equation at the recorded positions.

A simulation that lacks a force beside strong friction sticks at other places than the rig, and what it leaves repeats
along no way. The plant's equation, with the recorded positions and their derivatives in it, needs no simulation. It
yields first guesses alone: noise in the derivatives bends it (an equation error; Ljung 1999, section 7.3), and what a
recording says is judged by simulations.
"""

from __future__ import annotations

from functools import lru_cache
from math import ceil, pi

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
# Rows that are looked at, and how finely their positions count, as a share of the way; rows at which many periods are,
# and how many of these at once.
MOST_ROWS = 5_000
RESOLUTION = 1e-9
ROWS_OF_A_LOOK, AT_ONCE = 2_500, 64
# Rows that a period takes at the root mean square of the speed: what changes faster is averaged away by the filters.
ROWS_OF_A_PERIOD = 4.0


def waves_of_force(situation: Situation, periods: Array, most: int) -> list[dict[str, float]]:
    """Waves of the position that explain much of the command which moves the plant as recorded, the best first.

    Parameters
    ----------
    situation : Situation
    periods : ndarray, shape (P,)
        Periods to try, in units of the output, one after the other.
    most : int
        How many.

    Returns
    -------
    list of dict
        ``amplitude`` in units of the input, ``period`` and ``phase``; empty where none explains a fifth of the rest.
    """
    situation = situation.until(MOST_ROWS)
    recorded, poles = situation.recorded, len(situation.plant.denominator) - 1
    way = float(np.ptp(recorded))
    if poles not in range(1, MOST_POLES + 1) or len(recorded) < 10 * FILTER_ORDER or way == 0.0:
        return []
    # The equation is that of the recording, whatever the model and its zero are: it is looked at once.
    shape = np.round((recorded - recorded[0]) / way / RESOLUTION) * RESOLUTION
    signals = (shape.tobytes(), situation.signal.tobytes(), np.round(periods / way, 9).tobytes())
    shares, amplitudes, phases = _waves(*signals, situation.acquisition.period, poles)
    at_zero = (phases - 2.0 * pi * recorded[0] / periods + pi) % (2.0 * pi) - pi
    return best_waves(1.0 - shares, 1.0 - MOST_LEFT, most, amplitudes, periods, at_zero)


def best_waves(
    gains: Array, least: float, most: int, amplitudes: Array, periods: Array, phases: Array
) -> list[dict[str, float]]:
    """The waves of the largest gains, none beside another one, the best first.

    Parameters
    ----------
    gains, amplitudes, periods, phases : ndarray, shape (P,)
        Of waves, one after the other.
    least : float
        Gain that each of them exceeds.
    most : int
        How many.

    Returns
    -------
    list of dict
        ``amplitude``, ``period`` and ``phase``.
    """
    gains = gains.copy()
    found: list[dict[str, float]] = []
    while np.max(gains) > least and len(found) < most:
        i = int(np.argmax(gains))
        found.append({"amplitude": float(amplitudes[i]), "period": float(periods[i]), "phase": float(phases[i])})
        gains[max(i - 2, 0) : i + 3] = least
    return found


@lru_cache(maxsize=8)
def _waves(position: bytes, command: bytes, periods: bytes, period: float, poles: int) -> tuple[Array, Array, Array]:
    """Share of the rest that a wave of each period leaves, its amplitude and phase, with the best of the filters."""
    way, force, lengths = (np.frombuffer(values) for values in (position, command, periods))
    found = [_filtered_waves(way, force, lengths, period, poles, cut_off) for cut_off in CUT_OFFS]
    return min(found, key=lambda waves: float(np.min(waves[0])))


def _filtered_waves(
    position: Array, command: Array, periods: Array, period: float, poles: int, cut_off: float
) -> tuple[Array, Array, Array]:
    """The same with one filter, of all signals of the plant's equation."""
    angles = 2.0 * pi * position[:, None] / periods
    forces = np.column_stack([command, np.sin(angles), np.cos(angles)])
    left = _left_by_plant(position, forces, period, poles, cut_off)
    return best_pairs(left[:, 0], left[:, 1 : len(periods) + 1], left[:, len(periods) + 1 :])


def _left_by_plant(position: Array, forces: Array, period: float, poles: int, cut_off: float) -> Array:
    """What the plant's equation leaves of each force, shape (N, F), after a filter of all signals."""
    from scipy.signal import butter, sosfiltfilt

    sections = butter(FILTER_ORDER, cut_off, output="sos")
    smooth = sosfiltfilt(sections, np.column_stack([position, forces]), axis=0)
    derivatives = [smooth[:, 0]]
    for _ in range(poles):
        derivatives.append(np.gradient(derivatives[-1], period))
    slow = TURNED_ROUND * float(np.sqrt(np.mean(derivatives[1] ** 2))) or 1.0
    friction = sosfiltfilt(sections, np.tanh(derivatives[1] / slow))
    table = np.column_stack([np.ones(len(position)), friction, *derivatives])
    basis = np.linalg.qr(table / np.maximum(np.linalg.norm(table, axis=0), 1e-300))[0]
    return np.asarray(smooth[:, 1:] - basis @ (basis.T @ smooth[:, 1:]))


def short_periods(situation: Situation, periods: Array, most: int) -> Array:
    """Of many short periods those of waves that explain most of the command which moves the plant as recorded.

    The filters are not asked what they leave of each wave, so that many cost little; :func:`waves_of_force` says what
    a wave of one of them is worth.

    Parameters
    ----------
    situation : Situation
    periods : ndarray, shape (P,)
        Periods to try, in units of the output, one after the other.
    most : int
        How many.

    Returns
    -------
    ndarray, shape (at most ``most``,)
    """
    situation = situation.until(MOST_ROWS)
    recorded, poles = situation.recorded, len(situation.plant.denominator) - 1
    if poles not in range(1, MOST_POLES + 1) or len(recorded) < 10 * FILTER_ORDER:
        return np.empty(0)
    speed = float(np.sqrt(np.mean(np.diff(recorded) ** 2)))
    periods = periods[periods >= ROWS_OF_A_PERIOD * speed]
    if speed == 0.0 or len(periods) == 0:
        return np.empty(0)
    signals = (recorded.tobytes(), situation.signal.tobytes(), periods.tobytes())
    return _best_short_periods(*signals, situation.acquisition.period, poles, most)


@lru_cache(maxsize=8)
def _best_short_periods(position: bytes, command: bytes, periods: bytes, period: float, poles: int, most: int) -> Array:
    way, force, lengths = (np.frombuffer(values) for values in (position, command, periods))
    rows = slice(None, None, ceil(len(way) / ROWS_OF_A_LOOK))
    left = [_left_by_plant(way, force[:, None], period, poles, cut_off)[rows, 0] for cut_off in CUT_OFFS[1:]]
    shares = np.empty(len(lengths))
    for first in range(0, len(lengths), AT_ONCE):
        turns = way[rows, None] / lengths[first : first + AT_ONCE]
        angles = 2.0 * pi * (turns - np.rint(turns))  # sines of small angles take a third of the time
        waves = np.sin(angles), np.cos(angles)
        shares[first : first + AT_ONCE] = np.min([best_pairs(each, *waves)[0] for each in left], axis=0)
    found = best_waves(1.0 - shares, 0.0, most, shares, lengths, shares)
    return np.array([wave["period"] for wave in found])


def best_pairs(residual: Array, sines: Array, cosines: Array) -> tuple[Array, Array, Array]:
    """Least squares of a residual by each pair of columns.

    Parameters
    ----------
    residual : ndarray, shape (N,)
    sines, cosines : ndarray, shape (N, P)

    Returns
    -------
    tuple of ndarray, each of shape (P,)
        Share of the sum of squares that is left, amplitude and phase; one, zero and zero where a pair is none.
    """
    along, across, mixed = (np.sum(a * b, axis=0) for a, b in ((sines, sines), (cosines, cosines), (sines, cosines)))
    with_sine, with_cosine = residual @ sines, residual @ cosines
    determinant = along * across - mixed**2
    singular = determinant <= 1e-12 * along * across
    determinant = np.where(singular, 1.0, determinant)
    first = np.where(singular, 0.0, (across * with_sine - mixed * with_cosine) / determinant)
    second = np.where(singular, 0.0, (along * with_cosine - mixed * with_sine) / determinant)
    gain = first * with_sine + second * with_cosine
    left = 1.0 - gain / max(float(residual @ residual), 1e-300)
    return left, np.hypot(first, second), np.arctan2(second, first)
