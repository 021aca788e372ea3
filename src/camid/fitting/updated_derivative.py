"""Derivatives along a fit: differences where they are needed, rank-one updates in between, of outputs that are kept."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# A rank-one update that misses this share of the change it should explain is not an update.
LARGEST_MISSED_SHARE = 0.4


class UpdatedDerivative:
    """Derivatives of a simulated output by a vector, along a fit.

    Differences cost one simulation per parameter; an update costs none (Broyden 1965, Math. Comp. 19, 577–593).

    Parameters
    ----------
    differences : callable
        Derivatives by differences, shape (M, p), at a vector, shape (p,), with the output simulated there, shape (M,).
    refreshes : int
        How often they may be computed anew.
    first : callable, optional
        The same for the first point; ``differences`` where it is not given.
    """

    def __init__(
        self,
        differences: Callable[[Array, Array], Array],
        refreshes: int,
        first: Callable[[Array, Array], Array] | None = None,
    ) -> None:
        self.differences, self.refreshes, self.first = differences, refreshes, first or differences
        self.vector: Array | None = None
        self.simulated: Array
        self.table: Array

    def forget(self) -> None:
        """Begin anew."""
        self.vector, self.first = None, self.differences

    def at(self, vector: Array, simulated: Array) -> Array:
        """Derivatives at a point whose simulated output is known, shape (M, p)."""
        if self.vector is None:
            self.table = self.first(vector, simulated)
        else:
            step = vector - self.vector
            length = float(step @ step)
            if length > 0.0:
                change = simulated - self.simulated
                missed = change - self.table @ step
                wrong = float(np.linalg.norm(missed)) > LARGEST_MISSED_SHARE * float(np.linalg.norm(change))
                if wrong and self.refreshes > 0:
                    self.refreshes -= 1
                    self.table = self.differences(vector, simulated)
                else:
                    self.table = self.table + np.outer(missed, step / length)
        self.vector, self.simulated = vector.copy(), simulated
        return self.table


class LatestOutputs:
    """A simulated output by a vector, the last two of which are kept.

    An optimiser asks for the derivative at the point that it evaluated last, or the one before.

    Parameters
    ----------
    simulate : callable
        From a vector, shape (p,), to the output, shape (M,).
    """

    def __init__(self, simulate: Callable[[Array], Array]) -> None:
        self._simulate = simulate
        self._latest: list[tuple[Array, Array]] = []

    def __call__(self, vector: Array) -> Array:
        """Shape (M,)."""
        for point, rows in reversed(self._latest):
            if np.array_equal(point, vector):
                return rows
        rows = self._simulate(vector)
        self._latest = [*self._latest[-1:], (vector.copy(), rows)]
        return rows
