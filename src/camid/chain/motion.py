"""A motion between the nodes of the integrator's grid, and what exposures of any start and length see of it.

The integral of the motion is one of the integrator's states (the paper's Fig. 4), so a mean over an exposure is a
difference of integrals. Between nodes the integral is the quintic that has its value, the motion and its derivative at
both ends.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.compiled import njit

Array = NDArray[np.float64]

# Points at which an exposure is sampled where the mean of a function of the motion is needed, not of the motion itself.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)


@njit(nogil=True)
def _interpolate(
    start: float,
    step: float,
    integral: Array,
    position: Array,
    velocity: Array,
    velocity_end: Array,
    jump_times: Array,
    jumps: Array,
    times: Array,
    derivative: int,
) -> Array:
    """Integral (derivative 0) or motion (derivative 1) at any times; constant motion outside the grid."""
    result = np.empty(len(times))
    last = len(position) - 1
    for k in range(len(times)):
        place = (times[k] - start) / step
        if place <= 0.0 or place >= last:
            node = 0 if place <= 0.0 else last
            distance = (place - node) * step
            result[k] = integral[node] + position[node] * distance if derivative == 0 else position[node]
            continue
        i = min(int(place), last - 1)
        s = place - i
        if s < 1e-9 or s > 1.0 - 1e-9:
            node = i if s < 0.5 else i + 1
            result[k] = integral[node] if derivative == 0 else position[node]
            continue
        # Quintic Hermite basis in s with p = values, d = step·motion, a = step²·velocity.
        rise = integral[i + 1] - integral[i]
        d0, d1 = step * position[i], step * position[i + 1]
        a0, a1 = step * step * velocity[i], step * step * velocity_end[i]
        # Jumps within the step are subtracted at its end, and added again after them.
        jumped = 0.0
        for j in range(len(jump_times)):
            since = start + (i + 1) * step - jump_times[j]
            if 0.0 < since < step:
                p, v, a = jumps[j, 0], jumps[j, 1], jumps[j, 2]
                rise -= since * (p + since * (v / 2.0 + since * a / 6.0))
                d1 -= step * (p + since * (v + since * a / 2.0))
                a1 -= step * step * (v + since * a)
                since = times[k] - jump_times[j]
                if since > 0.0 and derivative == 0:
                    jumped += since * (p + since * (v / 2.0 + since * a / 6.0))
                elif since > 0.0:
                    jumped += p + since * (v + since * a / 2.0)
        c3 = 10.0 * rise - 6.0 * d0 - 4.0 * d1 - 1.5 * a0 + 0.5 * a1
        c4 = -15.0 * rise + 8.0 * d0 + 7.0 * d1 + 1.5 * a0 - a1
        c5 = 6.0 * rise - 3.0 * d0 - 3.0 * d1 - 0.5 * a0 + 0.5 * a1
        if derivative == 0:
            result[k] = jumped + integral[i] + s * (d0 + s * (0.5 * a0 + s * (c3 + s * (c4 + s * c5))))
        else:
            result[k] = jumped + (d0 + s * (a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))) / step
    return result


@dataclass(frozen=True)
class Motion:
    """A motion on a grid.

    Attributes
    ----------
    start, step : float
        Seconds.
    position, velocity, integral : ndarray, shape (M + 1,)
        Motion, its derivative and its integral over time in seconds.
    velocity_end : ndarray, shape (M,)
        Derivative at the end of each step, where it jumps to that at the start of the next.
    jump_times : ndarray, shape (j,)
        Times in seconds at which the motion jumps within a step.
    jumps : ndarray, shape (j, 3)
        By how much it, its first and its second derivative jump then.
    control : ndarray, shape (N,), optional
        What the controller of a closed loop put out at the samples.
    """

    start: float
    step: float
    position: Array
    velocity: Array
    integral: Array
    velocity_end: Array
    jump_times: Array
    jumps: Array
    control: Array | None = None

    def at(self, times: Array) -> Array:
        """Motion at times in seconds, in their shape."""
        return self._read(times, 1)

    def mean(self, start: Array, end: Array) -> Array:
        """Mean over exposures that begin and end at given times in seconds, shape (N,); the value if start = end."""
        length = end - start
        instant = length <= 1e-9 * self.step
        if np.all(instant):
            return self.at(start)
        means = (self._read(end, 0) - self._read(start, 0)) / np.where(instant, 1.0, length)
        return np.where(instant, self.at(start), means) if np.any(instant) else means

    def points(self, start: Array, end: Array) -> Array:
        """Motion at the Gauss–Legendre nodes of each exposure, shape (N, 12); their weights are :data:`WEIGHTS` / 2."""
        times = 0.5 * (start + end)[:, None] + 0.5 * (end - start)[:, None] * NODES
        return self.at(times)

    def _read(self, times: Array, derivative: int) -> Array:
        times = np.asarray(times, dtype=float)
        flat = np.ascontiguousarray(times.ravel())
        found = _interpolate(
            self.start,
            self.step,
            self.integral,
            self.position,
            self.velocity,
            self.velocity_end,
            self.jump_times,
            self.jumps,
            flat,
            derivative,
        )
        return found.reshape(times.shape)
