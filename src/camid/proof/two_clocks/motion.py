"""Motion of a rig of second order after a held input, and its mean over any exposure.

The integral of the position is a state of its own, so that the mean over an exposure needs two values of it.
"""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Longest step of the integrator, in seconds and as a share of the rig's period. The classic method of the fourth order
# is then off by less than 1e-5 of the motion.
LONGEST_STEP = 1.5e-3
LARGEST_SHARE = 1.0 / 200.0


class Motion:
    """Position of y'' = gain u - 2 damping w y' - w^2 y on a regular grid of times.

    Attributes
    ----------
    start, step : float
        First time and step of the grid, s.
    integral, position, velocity : ndarray, shape (K,)
        In unit s, unit and unit/s; the rig is at rest at first.
    """

    def __init__(
        self, frequency: float, damping: float, gain: float, levels: Array, period: float, start: float
    ) -> None:
        """Integrate from rest.

        Parameters
        ----------
        frequency : float
            Natural frequency, Hz.
        damping, gain : float
            Damping ratio; acceleration per unit of input, unit/s^2.
        levels : ndarray, shape (M,)
            Input; level k acts from ``start + k period`` for one period.
        period, start : float
            Seconds.
        """
        parts = ceil(period / min(LONGEST_STEP, LARGEST_SHARE / frequency))
        self.start, self.step = start, period / parts
        speed = 2.0 * np.pi * frequency
        states = _integrated(speed**2, 2.0 * damping * speed, gain, levels.tolist(), parts, self.step)
        self.integral, self.position, self.velocity = states

    def _places(self, times: Array) -> tuple[NDArray[np.int64], Array]:
        """Rows of the grid before the times, and what is left, in steps."""
        places = (times - self.start) / self.step
        rows = np.clip(np.floor(places).astype(np.int64), 0, len(self.integral) - 2)
        return rows, places - rows

    def integral_at(self, times: Array) -> Array:
        """Integral of the position up to ``times`` (s), shape of ``times``: by Hermite's quintic."""
        k, s = self._places(times)
        h = self.step
        low, high = self.integral[k], self.integral[k + 1]
        # The velocity jumps nowhere, so the second derivative of the integral is known at both ends of a step.
        slopes = h * self.position[k], h * self.position[k + 1]
        bends = h**2 * self.velocity[k], h**2 * self.velocity[k + 1]
        rise = 10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5
        first = s - 6.0 * s**3 + 8.0 * s**4 - 3.0 * s**5, -4.0 * s**3 + 7.0 * s**4 - 3.0 * s**5
        second = 0.5 * (s**2 - 3.0 * s**3 + 3.0 * s**4 - s**5), 0.5 * (s**3 - 2.0 * s**4 + s**5)
        value = low + (high - low) * rise + slopes[0] * first[0] + slopes[1] * first[1]
        return np.asarray(value + bends[0] * second[0] + bends[1] * second[1])

    def mean(self, ends: Array, exposure: float) -> Array:
        """Mean position over exposures of ``exposure`` seconds that end at ``ends`` (s), shape of ``ends``."""
        return (self.integral_at(ends) - self.integral_at(ends - exposure)) / exposure

    def position_at(self, times: Array) -> Array:
        """Position at ``times`` (s), shape of ``times``: by Hermite's cubic."""
        k, s = self._places(times)
        low, high = self.position[k], self.position[k + 1]
        slopes = self.step * self.velocity[k], self.step * self.velocity[k + 1]
        rise = 3.0 * s**2 - 2.0 * s**3
        return low + (high - low) * rise + slopes[0] * (s - 2.0 * s**2 + s**3) + slopes[1] * (s**3 - s**2)


def _integrated(
    stiffness: float, drag: float, gain: float, levels: list[float], parts: int, h: float
) -> tuple[Array, Array, Array]:
    """Integral, position and velocity by the classic method of Runge and Kutta, each of shape (M parts + 1,)."""
    total = y = v = 0.0
    rows = [(total, y, v)]
    for level in levels:
        force = gain * level
        for _ in range(parts):
            a1 = force - drag * v - stiffness * y
            v2, y2 = v + 0.5 * h * a1, y + 0.5 * h * v
            a2 = force - drag * v2 - stiffness * y2
            v3, y3 = v + 0.5 * h * a2, y + 0.5 * h * v2
            a3 = force - drag * v3 - stiffness * y3
            v4, y4 = v + h * a3, y + h * v3
            a4 = force - drag * v4 - stiffness * y4
            total += h / 6.0 * (y + 2.0 * (y2 + y3) + y4)
            y += h / 6.0 * (v + 2.0 * (v2 + v3) + v4)
            v += h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
            rows.append((total, y, v))
    table = np.array(rows)
    return table[:, 0], table[:, 1], table[:, 2]
