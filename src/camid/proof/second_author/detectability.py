"""How large an effect is beside what noise would hide and re-estimated coefficients would imitate."""

from dataclasses import replace
from typing import Any

import numpy as np

from .chain import run
from .laws import Law
from .rigs import Rig

Array = np.ndarray[Any, np.dtype[np.float64]]
DETECTABLE = 5.7  # norm of what coefficients cannot imitate, in standard deviations of white noise
STEP = 1e-4  # relative change of a coefficient


def sensitivities(rig: Rig, laws: list[Law], drive: Array, bias_known: bool) -> Array:
    """Return how the compared signal changes with each quantity that a fit re-estimates, a column each."""
    base = run(rig, laws, drive).compared(rig)
    columns = []

    def add(other: Rig, forcing: Array, step: float) -> None:
        """Add the change that a small change of the rig or of its drive makes."""
        columns.append((run(other, laws, forcing).compared(rig) - base) / step)

    for group, index, value in rig.coefficients():
        step = STEP * (abs(value) if abs(value) > 1e-6 else 1.0)
        add(rig.changed(group, index, value + step), drive, step)
    if rig.initial is not None:
        position, velocity = rig.initial
        step = STEP * (abs(position) + abs(velocity) * rig.pace)
        add(replace(rig, initial=(position + step, velocity)), drive, step)
        if rig.order > 1:
            step /= rig.pace
            add(replace(rig, initial=(position, velocity + step)), drive, step)
    if rig.controller is None:
        if not rig.offset_known and rig.pendulum is None:
            columns.append(np.ones(base.size))
        if rig.integrates and not bias_known:
            step = STEP * rig.largest_input
            add(rig, drive + step, step)
    return np.stack(columns, axis=1)


def remainder(difference: Array, columns: Array) -> float:
    """Return the norm of what is left of a difference of two signals by what the columns can imitate."""
    scaled = columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    left = difference - scaled @ np.linalg.lstsq(scaled, difference, rcond=1e-10)[0]
    return float(np.linalg.norm(left))


def multiple(difference: Array, columns: Array, deviation: float) -> float:
    """Return the size of a difference as a multiple of what is detectable in white noise of that deviation."""
    return remainder(difference, columns) / (DETECTABLE * deviation)
