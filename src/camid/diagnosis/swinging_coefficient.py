"""Whether a coefficient of the plant swings in time, as the stiffness of teeth in mesh does.

To first order the residual is then what the coefficient does, its sensitivity, times a sine. It has no value on the
average, so that no test of a force over the motion sees it, and a colour, so that it passes for coloured noise.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from camid.fitting.fit import Fitted
from camid.fitting.plants.named_constants import PREFIX
from camid.fitting.problem import Problem

Array = NDArray[np.float64]

# Periods that the longest recording holds at least: what has swung less is a drift.
FEWEST_PERIODS = 3
# Lines between two of the spectrum at which the highest one is looked for.
FINER = 16
# Standard deviations at which a residual is cut off: a single one that is far out has every frequency.
FARTHEST = 4.0


@dataclass(frozen=True)
class Swing:
    """A coefficient that swings.

    Attributes
    ----------
    name : str
        Of the coefficient of the transfer function (b0, a1, …), or of the constant.
    angular, deviation : float
        Angular frequency and its standard deviation in rad/s.
    p_value : float
        Probability of as much by chance, with regard to all coefficients and frequencies that were looked at.
    """

    name: str
    angular: float
    deviation: float
    p_value: float


def swinging_coefficient(problem: Problem, fitted: Fitted) -> Swing | None:
    """The coefficient that swings most clearly; None where none is fitted, or a residual has no spectrum.

    The whitened residual times the whitened sensitivity has a spectrum that is exponentially distributed where the
    residual is noise (Brillinger 1981, Time Series, section 5.2). The deviation is that of a line in noise (Rife &
    Boorstyn 1974, IEEE Transactions on Information Theory 20, 591-598).

    Parameters
    ----------
    problem : Problem
    fitted : Fitted
        Its longest recording is looked at.

    Returns
    -------
    Swing or None
    """
    columns = {i: name for i, name in enumerate(fitted.packing.names) if _is_of_plant(name)}
    if not columns:
        return None
    counts = [int(np.sum(e.used)) for e in problem.experiments]
    run = int(np.argmax(counts))
    rows = slice(sum(counts[:run]), sum(counts[: run + 1]))
    used = np.flatnonzero(problem.experiments[run].used)
    residual = problem.whitened(fitted.residual, fitted.noise.whitening)[rows]
    residual = np.clip(residual / (float(np.std(residual)) or 1.0), -FARTHEST, FARTHEST)
    table = problem.whitened(fitted.sensitivities[:, list(columns)], fitted.noise.whitening)[rows]
    product = np.zeros((used[-1] - used[0] + 1, len(columns)))
    product[used - used[0]] = residual[:, None] * table
    # Of the products themselves: noise may be louder where the sensitivity is large (White 1980, Econometrica 48, 817).
    power = np.maximum(np.sum(product**2, axis=0), 1e-300)
    spectrum = np.fft.rfft(product, axis=0)[FEWEST_PERIODS:]
    height = np.abs(spectrum) ** 2 / power
    highest = float(np.max(height, initial=0.0))
    if not 0.0 < highest < np.inf:  # too few rows, no noise at all, or a simulation that has run away
        return None
    column = int(np.argmax(np.max(height, axis=0)))
    duration = len(product) * problem.acquisition.period
    fine = np.abs(np.fft.rfft(product[:, column], FINER * len(product)))[FINER * FEWEST_PERIODS - FINER // 2 :]
    line = int(np.argmax(fine)) + FINER * FEWEST_PERIODS - FINER // 2
    return Swing(
        _label(problem, list(columns.values())[column]),
        2.0 * pi * line / (FINER * duration),
        sqrt(6.0 / highest) / duration,
        min(height.size * exp(-min(highest, 700.0)), 1.0),
    )


def sits_at(swing: Swing) -> str:
    """The place of a swing: a gain's is the actuator."""
    return "actuator" if swing.name.startswith("b") and swing.name[1:].isdigit() else "plant"


def _is_of_plant(name: str) -> bool:
    return name.startswith(("coefficient ", PREFIX))


def _label(problem: Problem, name: str) -> str:
    """Of a coefficient of the transfer function, or of a constant that the simulation file names."""
    return name.removeprefix(PREFIX) if name.startswith(PREFIX) else problem.structure.names[int(name.split()[1])]
