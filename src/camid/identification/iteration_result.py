"""Where an iterative estimate ended, and the limits that decide whether it may be believed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import STABILITY_TOLERANCE

Array = NDArray[np.float64]

# Singular values below this share of the largest belong to directions that the data do not determine, and such a
# direction concerns a coefficient if its part there exceeds the second number.
LARGEST_CONDITION = 1e11
UNDETERMINED_SHARE = 1e-2


@dataclass(frozen=True)
class IterationResult:
    """Where an iteration ended.

    Attributes
    ----------
    parameters : ndarray
        In the predictor's scaled units.
    cost : float
        Sum of squared differences between recorded and simulated output.
    converged : bool
    iterations : int
    """

    parameters: Array
    cost: float
    converged: bool
    iterations: int


def has_stable(poles: NDArray[np.complex128]) -> bool:
    """Whether no pole lies clearly in the right half plane; integrators and undamped modes are stable here."""
    return bool(np.all(np.isfinite(poles)) and np.all(poles.real <= STABILITY_TOLERANCE * np.abs(poles)))


def sum_of_squares(residual: Array) -> float:
    """Infinite rather than a warning where an unstable trial overflows."""
    with np.errstate(over="ignore", invalid="ignore"):
        total = float(residual @ residual)
    return total if np.isfinite(total) else np.inf
