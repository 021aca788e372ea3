"""Where the machines are sent: references of unit size, one value a row, that begin at zero."""

from collections.abc import Callable

import numpy as np
from scipy.signal import butter, lfilter

from .rigs import Array, Generator

NAMES = (
    "S-curve moves",
    "random set points",
    "filtered two-level noise",
    "multisine",
    "trapezoids with dwell",
    "sweeps forward and back",
)


def _moves(rng: Generator, rows: int, pace: float, shape: Callable[[Array], Array], dwell: float) -> Array:
    """Moves between random places; ``pace`` is the loop's time constant in rows, ``dwell`` the rests' in paces."""
    made, place, row = np.zeros(rows), 0.0, int(2 * pace)
    while row < rows:
        aim = float(rng.uniform(-1.0, 1.0))
        if abs(aim - place) < 0.3:
            continue
        length = int(pace * rng.uniform(4.0, 10.0) * (0.6 + 0.4 * abs(aim - place))) + 4
        part = shape(np.linspace(0.0, 1.0, length))[: max(rows - row, 0)]
        made[row : row + part.size] = place + (aim - place) * part
        row += length
        made[row:] = place = aim
        row += int(pace * dwell * rng.uniform(0.3, 1.7))
    return made


def _smooth(x: Array) -> Array:
    return np.asarray(x**4 * (35.0 - 84.0 * x + 70.0 * x**2 - 20.0 * x**3))


def _trapezoid(x: Array) -> Array:
    ramp = 0.25
    speed = np.minimum(np.minimum(x / ramp, 1.0), (1.0 - x) / ramp)
    way = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))))
    return np.asarray(way / way[-1])


def _set_points(rng: Generator, rows: int, pace: float) -> Array:
    made, row = np.zeros(rows), int(2 * pace)
    while row < rows:
        made[row:] = rng.uniform(-1.0, 1.0)
        row += int(pace * rng.uniform(4.0, 14.0)) + 1
    return made


def _two_levels(rng: Generator, rows: int, pace: float) -> Array:
    made, row, level = np.zeros(rows), int(pace), 1.0
    while row < rows:
        made[row:] = level
        level = -level
        row += int(pace * rng.choice([2.0, 3.0, 5.0, 8.0])) + 1
    numerator, denominator = butter(2, min(0.9, 1.2 / (np.pi * pace)))
    return np.asarray(lfilter(numerator, denominator, made))


def _multisine(rng: Generator, rows: int, pace: float) -> Array:
    count = int(rng.integers(6, 13))
    rates = np.exp(rng.uniform(np.log(0.12), np.log(1.1), count)) / pace
    phases, sizes = rng.uniform(0.0, 2.0 * np.pi, count), (rates * pace) ** -0.7
    time = np.arange(rows)
    made = np.sum(sizes[:, None] * np.sin(rates[:, None] * time + phases[:, None]), axis=0)
    rise = np.clip(time / (6.0 * pace), 0.0, 1.0)
    return np.asarray(made * _smooth(rise) / np.abs(made).max())


def _sweeps(rng: Generator, rows: int, pace: float) -> Array:
    made, row, place, side = np.zeros(rows), int(2 * pace), 0.0, 1.0
    while row < rows:
        aim = side * float(rng.uniform(0.6, 1.0))
        length = int(pace * rng.uniform(4.0, 22.0) * abs(aim - place)) + 2
        part = np.linspace(place, aim, length)[: rows - row]
        made[row : row + part.size] = part
        row, place, side = row + length, aim, -side
    kernel = np.hanning(max(int(1.2 * pace), 3) + 2)
    return np.asarray(lfilter(kernel / kernel.sum(), [1.0], made))


def draw_reference(rng: Generator, name: str, rows: int, bandwidth: float, period: float) -> Array:
    """Draw a reference of ``rows`` values for a loop of a bandwidth (rad/s), at rows of a period (s)."""
    pace = 1.0 / (bandwidth * period)
    if name == "S-curve moves":
        return _moves(rng, rows, pace, _smooth, 2.0)
    if name == "trapezoids with dwell":
        return _moves(rng, rows, pace, _trapezoid, 4.0)
    makers = {
        "random set points": _set_points,
        "filtered two-level noise": _two_levels,
        "multisine": _multisine,
        "sweeps forward and back": _sweeps,
    }
    return makers[name](rng, rows, pace)
