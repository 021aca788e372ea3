"""A curve through points that keeps their shape, for effects whose law is known at points alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.compiled import njit

Array = NDArray[np.float64]

FEWEST_POINTS = 2


class Curve:
    """A curve through points, monotone wherever they are, and beyond them as at the last ones.

    Piecewise cubic Hermite interpolation (Fritsch & Butland 1984, SIAM J. Sci. Stat. Comput. 5, 300–304).

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
        from scipy.interpolate import PchipInterpolator

        if len(knots) < FEWEST_POINTS or np.any(np.diff(knots) <= 0.0):
            raise ValueError(f"the knots of a curve must be at least {FEWEST_POINTS} increasing numbers")
        if len(knots) != len(heights):
            raise ValueError(f"a curve has {len(knots)} knots, but {len(heights)} heights")
        self.knots = np.asarray(knots, dtype=float)
        self._cubic = PchipInterpolator(self.knots, np.asarray(heights, dtype=float))
        slopes = self._cubic.derivative()(self.knots)
        self.numbers: list[float] = [float(len(self.knots)), *self.knots.tolist(), *map(float, heights), *slopes]

    def __call__(self, at: Array) -> Array:
        """Its values, in the shape of ``at``."""
        return np.asarray(self._cubic(np.clip(at, self.knots[0], self.knots[-1])))


@njit(error_model="numpy")
def on_curve(at: float, values: Any, first: int) -> float:
    """Value of a curve whose numbers stand in ``values`` from the index ``first`` on, for compiled functions."""
    count = int(values[first])
    start = first + 1
    if at <= values[start]:
        return float(values[start + count])
    if at >= values[start + count - 1]:
        return float(values[start + 2 * count - 1])
    low, high = 0, count - 1
    while high - low > 1:
        middle = (low + high) // 2
        if values[start + middle] <= at:
            low = middle
        else:
            high = middle
    width = values[start + high] - values[start + low]
    share = (at - values[start + low]) / width
    left, right = values[start + count + low], values[start + count + high]
    rise_left, rise_right = width * values[start + 2 * count + low], width * values[start + 2 * count + high]
    # Of the polynomial in share, which has the heights and slopes of both ends.
    third = rise_left + rise_right - 2.0 * (right - left)
    second = (right - left) - rise_left - third
    return float(left + share * (rise_left + share * (second + share * third)))
