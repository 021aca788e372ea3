"""A motion between the nodes of the integrator's grid, and what exposures of any start and length see of it.

The integral of the motion is one of the integrator's states (the paper's Fig. 4), so a mean over an exposure is a
difference of integrals. Between nodes the integral is the quintic that has its value, the motion and its derivative at
both ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.compiled import kernel, njit

Array = NDArray[np.float64]

# Points at which an exposure is sampled where the mean of a function of the motion is needed, not of the motion itself.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)
# Ends of the parts of the path in an exposure, where they count by their length.
POINTS_OF_PATH = 33


class _Quintic(NamedTuple):
    """Quintic Hermite polynomial of the integral over a step, in the share s of it: d = step·motion, c from s³ on."""

    value: float
    d: float
    a: float
    c3: float
    c4: float
    c5: float


@kernel(inline="always")
def _quintic(value: float, rise: float, d0: float, d1: float, a0: float, a1: float) -> _Quintic:
    """The polynomial from a value on, by how much it rises, and from d and a = step²·velocity at both ends."""
    return _Quintic(
        value,
        d0,
        a0,
        10.0 * rise - 6.0 * d0 - 4.0 * d1 - 1.5 * a0 + 0.5 * a1,
        -15.0 * rise + 8.0 * d0 + 7.0 * d1 + 1.5 * a0 - a1,
        6.0 * rise - 3.0 * d0 - 3.0 * d1 - 0.5 * a0 + 0.5 * a1,
    )


@kernel(inline="always")
def _of_quintic(q: _Quintic, s: float, step: float, derivative: int) -> float:
    """Its value, or its derivative by the time."""
    if derivative == 0:
        return q.value + s * (q.d + s * (0.5 * q.a + s * (q.c3 + s * (q.c4 + s * q.c5))))
    return (q.d + s * (q.a + s * (3.0 * q.c3 + s * (4.0 * q.c4 + s * 5.0 * q.c5)))) / step


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
    # The polynomial of one step serves all times in it that follow each other, unless the motion jumps there.
    known, polynomial = -1, _Quintic(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
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
        jumped = 0.0
        if i != known:
            known = i
            rise = integral[i + 1] - integral[i]
            d1, a1 = step * position[i + 1], step * step * velocity_end[i]
            # Jumps within the step are subtracted at its end, and added again after them.
            for j in range(len(jump_times)):
                since = start + (i + 1) * step - jump_times[j]
                if 0.0 < since < step:
                    known = -1
                    p, v, a = jumps[j, 0], jumps[j, 1], jumps[j, 2]
                    rise -= since * (p + since * (v / 2.0 + since * a / 6.0))
                    d1 -= step * (p + since * (v + since * a / 2.0))
                    a1 -= step * step * (v + since * a)
                    since = times[k] - jump_times[j]
                    if since > 0.0 and derivative == 0:
                        jumped += since * (p + since * (v / 2.0 + since * a / 6.0))
                    elif since > 0.0:
                        jumped += p + since * (v + since * a / 2.0)
            polynomial = _quintic(integral[i], rise, step * position[i], d1, step * step * velocity[i], a1)
        result[k] = jumped + _of_quintic(polynomial, s, step, derivative)
    return result


@njit(nogil=True, error_model="numpy")
def _means_over_path(points: Array, exponent: float) -> Array:
    """Mean of each row of points that counts each part between them for a power of its length, shape (N,)."""
    rows, count = points.shape
    result = np.empty(rows)
    largest = 0.0
    for k in range(rows):
        for i in range(count):
            largest = max(largest, abs(points[k, i]))
    least = 1e-12 * max(largest, 1e-300)
    for k in range(rows):
        path, total, weighted = 0.0, 0.0, 0.0
        for i in range(count - 1):
            length = abs(points[k, i + 1] - points[k, i])
            path += length
            weight = length if exponent == 1.0 else length**exponent
            total += weight
            weighted += 0.5 * (points[k, i] + points[k, i + 1]) * weight
        result[k] = points[k, 0] if path <= least else weighted / total
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

    def mean_over_path(self, start: Array, end: Array, exponent: float = 1.0) -> Array:
        """Mean over exposures that counts each part of the path for a power of its length, shape (N,).

        Where nothing moves it is the value; a motion that runs away has none.
        """
        share = np.linspace(0.0, 1.0, POINTS_OF_PATH)
        return _means_over_path(self.at(start[:, None] + (end - start)[:, None] * share), exponent)

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
