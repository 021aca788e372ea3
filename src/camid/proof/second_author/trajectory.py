"""A motion between the substeps of the integration, and what a sensor makes of it."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True)
class Trajectory:
    """Motion on equal steps: cubic Hermite polynomials through positions (y) and velocities (y/s) at the ends of each.

    ``motion`` has the rows position and velocity at the start, position and velocity at the end, so that a velocity may
    jump from one step to the next. ``start`` and ``step`` are in seconds.
    """

    start: float
    step: float
    motion: Array
    total: Array = field(init=False)

    def __post_init__(self) -> None:
        """Add up the integral of the position (y s) at the start of each step."""
        first, rate, last, end_rate = self.motion
        areas = self.step * (0.5 * (first + last) + self.step / 12.0 * (rate - end_rate))
        object.__setattr__(self, "total", np.concatenate([[0.0], np.cumsum(areas)]))

    def _locate(self, time: Array) -> tuple[Any, Array]:
        """Return the step that holds each time (s), and the fraction of the step at it."""
        place = (time - self.start) / self.step
        index = np.clip(np.floor(place).astype(np.int64), 0, self.motion.shape[1] - 1)
        return index, np.clip(place - index, 0.0, 1.0)

    def position(self, time: Array) -> Array:
        """Return the position (y) at times (s)."""
        index, s = self._locate(time)
        first, rate, last, end_rate = self.motion[:, index]
        bend = 2.0 * (first - last) + self.step * (rate + end_rate)
        curve = 3.0 * (last - first) - self.step * (2.0 * rate + end_rate)
        return np.asarray(first + s * (self.step * rate + s * (curve + s * bend)))

    def velocity(self, time: Array) -> Array:
        """Return the velocity (y/s) at times (s)."""
        index, s = self._locate(time)
        first, rate, last, end_rate = self.motion[:, index]
        bend = 2.0 * (first - last) + self.step * (rate + end_rate)
        curve = 3.0 * (last - first) - self.step * (2.0 * rate + end_rate)
        return np.asarray(rate + s * (2.0 * curve + 3.0 * s * bend) / self.step)

    def integral(self, time: Array) -> Array:
        """Return the integral of the position (y s) from the start to times (s)."""
        index, s = self._locate(time)
        first, rate, last, end_rate = self.motion[:, index]
        bend = 2.0 * (first - last) + self.step * (rate + end_rate)
        curve = 3.0 * (last - first) - self.step * (2.0 * rate + end_rate)
        part = s * (first + s * (0.5 * self.step * rate + s * (curve / 3.0 + 0.25 * s * bend)))
        return np.asarray(self.total[index] + self.step * part)

    def mean(self, end: Array, exposure: float) -> Array:
        """Return the mean position (y) over exposures (s) that end at times (s); the position itself for none."""
        if exposure <= 0.0:
            return self.position(end)
        return np.asarray((self.integral(end) - self.integral(end - exposure)) / exposure)

    def within(self, end: Array, exposure: float, points: int) -> Array:
        """Return times (s), shape (frames, points): the middles of equal parts of exposures that end at ``end``."""
        if exposure <= 0.0:
            return np.asarray(end)[:, None]
        return np.asarray(end[:, None] - exposure * (np.arange(points)[::-1] + 0.5) / points)
