"""How much of what a law does shows beside everything else that the recording leaves open.

The recording is split into windows of three reaction times. In each one the plant without the law, driven by the
recorded command, begins at a position and a speed of its own. As the plant is linear, what that prediction lacks is
the plant's response, from rest, to what the law adds to its drive: this is computed from the equation of motion, row
by row, held over the rows. Laws behind the plant change the readings by what their own absence changes. What the
coefficients, the initial states and a constant at the input can imitate is projected out; the norm of the rest over
5.7 standard deviations of the noise is the multiple. Exposure and latency are left out of the projection. Of several
laws each one's own part is taken along the motion that all of them made, to first order: the plant's response to its
own force.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm
from scipy.signal import fftconvolve

from .motion import Motion
from .rigs import Array, Rig

THRESHOLD = 5.7


@dataclass(frozen=True)
class Rows:
    """Rows: ``moved``, ``hastened`` are mean rates (y/s, y/s²), ``lacking`` what the drive is short of (u)."""

    command: Array
    arrived: Array
    moved: Array
    hastened: Array
    lacking: Array


def rows_of(rig: Rig, motion: Motion, first: int, count: int) -> Rows:
    """Return ``count`` rows of a motion from row ``first``; what the drive lacks follows from the equation."""
    at = slice(first * motion.substeps, (first + count) * motion.substeps + 1, motion.substeps)
    moved = np.diff(motion.position[at]) / rig.period
    hastened = np.diff(motion.velocity[at]) / rig.period
    if rig.order == 2:
        used = (hastened + rig.damping[0] * moved) / rig.gain
    else:
        jerk = np.diff(motion.third[at]) / rig.period
        used = (jerk + rig.damping[0] * hastened + rig.damping[1] * moved) / rig.gain
    inner = slice(first, first + count)
    return Rows(motion.command[inner], motion.arrived[inner], moved, hastened, motion.command[inner] - used)


class Windows:
    """Projection of the rows of a recording; ``constant`` says whether a constant of the input is left open."""

    def __init__(self, rig: Rig, rows: Rows, constant: bool) -> None:
        total = rows.command.size
        self.length = int(np.clip(3.0 * rig.reaction / rig.period, 60, total // 6))
        self.count = total // self.length
        self.response = self._impulse(rig)
        self.base = self._free(rig)
        columns = [rows.command - rows.lacking, rows.moved]
        columns += [rows.hastened] if rig.order == 3 else []
        columns += [np.ones(total)] if constant else []
        made = [self._without_start(self.driven(column)).ravel() for column in columns]
        unit = np.stack([column / max(float(np.linalg.norm(column)), 1e-300) for column in made], axis=1)
        left, sizes, _ = np.linalg.svd(unit, full_matrices=False)
        self.common = left[:, sizes > 1e-9 * sizes[0]]

    def _impulse(self, rig: Rig) -> Array:
        """Response (y/u) of the plant's rows to a command that is held over the first row."""
        order = rig.order
        a = np.zeros((order, order))
        a[:-1, 1:] = np.eye(order - 1)
        a[-1] = -np.array((*rig.damping, 0.0))[::-1]
        b = np.zeros((order, 1))
        b[-1, 0] = rig.gain
        both = expm(np.block([[a, b], [np.zeros((1, order + 1))]]) * rig.period)
        step, state = both[:order, :order], both[:order, order]
        response = np.zeros(self.length)
        for row in range(1, self.length):
            response[row] = state[0]
            state = step @ state
        return response

    def _free(self, rig: Rig) -> Array:
        """Orthonormal motions of the plant without a command (rows, order)."""
        time = rig.period * np.arange(self.length)
        poles = np.roots([1.0, *rig.damping]).real
        modes = np.stack([np.ones(self.length), *(np.exp(pole * time) for pole in poles)], axis=1)
        return np.asarray(np.linalg.qr(modes)[0])

    def split(self, series: Array) -> Array:
        """Rows as (windows, rows of a window); what is left over at the end is dropped."""
        return series[: self.count * self.length].reshape(self.count, self.length)

    def driven(self, series: Array) -> Array:
        """Response (y) of the plant, from rest in each window, to what is held over the rows (u)."""
        return np.asarray(fftconvolve(self.split(series), self.response[None, :], axes=1)[:, : self.length])

    def _without_start(self, windows: Array) -> Array:
        return np.asarray(windows - (windows @ self.base) @ self.base.T)

    def multiple(self, windows: Array, noise: float) -> float:
        """Norm of what is left of changes of the readings (y), as a multiple of the size that shows."""
        left = self._without_start(windows).ravel()
        left = left - self.common @ (self.common.T @ left)
        return float(np.linalg.norm(left) / (THRESHOLD * noise))
