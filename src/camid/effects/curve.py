"""A curve through points, for effects whose law is known at points alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.compiled import njit
from camid.effects.learned import FEWEST_KNOTS, interpolated

Array = NDArray[np.float64]


class Curve:
    """A curve with straight lines between points, and beyond them as at the last ones.

    A learned law is one: a smooth curve through its values would be another law, whose extremes are larger.

    Parameters
    ----------
    knots, heights : sequence of float
        Where it is given, increasing, and its values there.

    Attributes
    ----------
    numbers : list of float
        What :func:`on_curve` reads, for ``force_values``.

    Raises
    ------
    ValueError
        If the knots do not increase, there are fewer than two, or not as many heights.
    """

    def __init__(self, knots: Sequence[float], heights: Sequence[float]) -> None:
        if len(knots) < FEWEST_KNOTS or np.any(np.diff(knots) <= 0.0):
            raise ValueError(f"the knots of a curve must be at least {FEWEST_KNOTS} increasing numbers")
        if len(knots) != len(heights):
            raise ValueError(f"a curve has {len(knots)} knots, but {len(heights)} heights")
        self.knots, self.heights = np.asarray(knots, dtype=float), np.asarray(heights, dtype=float)
        self.numbers: list[float] = [float(len(self.knots)), *self.knots.tolist(), *self.heights.tolist()]

    def __call__(self, at: Array) -> Array:
        """Its values, in the shape of ``at``."""
        return np.asarray(np.interp(at, self.knots, self.heights))


@njit(error_model="numpy")
def on_curve(at: float, values: Any, first: int) -> float:
    """Value of a curve whose numbers stand in ``values`` from the index ``first`` on, for compiled functions."""
    return float(interpolated(at, values, first + 1, int(values[first])))
