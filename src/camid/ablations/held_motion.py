"""Motion of the paper's plant (15) between the samples of a held input, in closed form.

Independent of :mod:`camid.chain.exact`: neither matrix exponentials nor its sensor, so that one checks the other.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class HeldMotion:
    """y(t) of an underdamped second-order plant, at rest before a held input begins at time 0.

    Parameters
    ----------
    plant : mapping
        ``static_gain``, ``natural_frequency`` (rad/s) and ``damping`` (between 0 and 1).
    signal : ndarray, shape (N,)
        Held input samples; the last one stays.
    period : float
        Seconds.
    """

    def __init__(self, plant: Mapping[str, float], signal: Array, period: float) -> None:
        self.period, self.rest = period, plant["static_gain"] * np.asarray(signal, dtype=float)
        self.decay = plant["damping"] * plant["natural_frequency"]
        self.stiffness = plant["natural_frequency"] ** 2
        self.frequency = np.sqrt(self.stiffness - self.decay**2)
        count = self.rest.size
        self.start, self.speed, self.sum = np.zeros(count), np.zeros(count), np.zeros(count)
        deviation, speed, total = -self.rest[0], 0.0, 0.0
        for k in range(count):
            self.start[k], self.speed[k], self.sum[k] = deviation, speed, total
            end, end_speed = self._free(deviation, speed, period)
            total += self.rest[k] * period + self._free_integral(deviation, speed, end, end_speed)
            following = self.rest[k + 1] if k + 1 < count else self.rest[k]
            deviation, speed = end + self.rest[k] - following, end_speed

    def _free(self, deviation: Any, speed: Any, time: Any) -> tuple[Any, Any]:
        """Free motion about the position of rest, deviation and speed after a time; numbers or arrays."""
        shrink, cosine, sine = np.exp(-self.decay * time), np.cos(self.frequency * time), np.sin(self.frequency * time)
        later = shrink * (deviation * cosine + (speed + self.decay * deviation) / self.frequency * sine)
        later_speed = shrink * (
            speed * cosine - (self.decay * speed + self.stiffness * deviation) / self.frequency * sine
        )
        return later, later_speed

    def _free_integral(self, deviation: Any, speed: Any, later: Any, later_speed: Any) -> Any:
        """Integral of the free motion between two states, from its differential equation."""
        return -(later_speed - speed + 2.0 * self.decay * (later - deviation)) / self.stiffness

    def _interval(self, time: Array) -> tuple[NDArray[np.int64], Array]:
        k = np.clip(np.floor(time / self.period), 0, self.rest.size - 1).astype(np.int64)
        return k, np.maximum(time - k * self.period, 0.0)

    def position(self, time: Array) -> Array:
        """Position y at times in s, any shape."""
        k, since = self._interval(time)
        return np.where(time > 0.0, self.rest[k] + self._free(self.start[k], self.speed[k], since)[0], 0.0)

    def integral(self, time: Array) -> Array:
        """Integral of y from 0 to times in s, any shape."""
        k, since = self._interval(time)
        later = self._free(self.start[k], self.speed[k], since)
        total = self.sum[k] + self.rest[k] * since + self._free_integral(self.start[k], self.speed[k], *later)
        return np.where(time > 0.0, total, 0.0)

    def mean(self, start: Array, end: Array) -> Array:
        """Mean of y between two times in s, any shape."""
        return (self.integral(end) - self.integral(start)) / (end - start)
