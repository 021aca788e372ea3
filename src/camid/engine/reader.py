"""What exposures see of many motions at once: means are linear in what a motion is at the nodes of its grid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from camid.chain.motion import Motion
from camid.engine.tangent import Changes

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Reader:
    """Means over exposures as sums over nodes.

    Attributes
    ----------
    rows : ndarray of int, shape (M + 1,)
        Number of a node among those that any exposure sees, -1 where none does.
    weights : sparse array, shape (N, 3 w)
        Of motion, rate and integral at the w nodes that are seen.
    """

    rows: NDArray[np.int64]
    weights: csr_array

    @classmethod
    def of(cls, start_time: float, step: float, nodes: int, start: Array, end: Array) -> Reader:
        """For exposures from ``start`` to ``end``, shape (N,), all in seconds, on a grid of so many nodes."""
        from scipy.sparse import csr_array

        length = end - start
        instant = length <= 1e-9 * step
        frames, seen, kinds, shares = [], [], [], []
        for times, integrated, chosen in ((start, False, instant), (start, True, ~instant), (end, True, ~instant)):
            where = np.flatnonzero(chosen)
            place = (times[where] - start_time) / step
            node = np.clip(place.astype(int), 0, nodes - 2)
            factor = 1.0 if not integrated else (1.0 if times is end else -1.0) / length[where]
            for number, share in enumerate(_shares((place - node) * step, step, integrated)):
                frames.append(where)
                seen.append(node + number % 2)
                kinds.append(np.full(len(where), number // 2))
                shares.append(factor * share)
        frame, node, kind, share = (np.concatenate(each) for each in (frames, seen, kinds, shares))
        frame, node, kind, share = (each[share != 0.0] for each in (frame, node, kind, share))
        wanted = np.unique(node)
        rows = np.full(nodes, -1)
        rows[wanted] = np.arange(len(wanted))
        shape = (len(start), 3 * len(wanted))
        return cls(rows, csr_array((share, (frame, kind * len(wanted) + rows[node])), shape=shape))

    def mean(self, changes: Changes) -> Array:
        """Means over the exposures, shape (N, c), of c motions that are given at the nodes that are seen."""
        return np.asarray(self.weights @ np.concatenate(changes))


def _shares(times: Array, step: float, integrated: bool) -> list[Array]:
    """What motion, rate and integral at the start and at the end of one step contribute to the motion in it.

    The same to its integral, if ``integrated``; six arrays of the shape of ``times``, which count from the step's
    start.
    """
    found = []
    for p0, p1, v0, v1, i0, i1 in np.eye(6):
        position, velocity, integral = np.array([p0, p1]), np.array([v0, v1]), np.array([i0, i1])
        one = Motion(0.0, step, position, velocity, integral, velocity[1:], np.zeros(0), np.zeros((0, 3)))
        found.append(one._read(times, 0) if integrated else one.at(times))
    return found
