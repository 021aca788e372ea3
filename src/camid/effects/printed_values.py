"""How finely values are written, and the lattice of a sensor on which they lie."""

from __future__ import annotations

import numpy as np

from camid.effects.base import Array

# Values that differ by less than this share of their range are the same.
SAME_VALUE = 1e-10
# Significant digits from which a number is written with all that it has.
MOST_SIGNIFICANT = 15
# Digits smaller than this share of a lattice's step do not hide it.
FINE_PRINT = 0.02
# Values in which a lattice is looked for, smallest differences that may be its step, and levels at most: of more, what
# a step errs by adds up.
MOST_VALUES, MOST_STEPS, MOST_LEVELS = 5000, 12, 1e7
# Values lie on a lattice if this share of them does, give or take this share of a step.
ON_LATTICE, BESIDE_LATTICE = 0.9, 0.01


def lattice_step(values: Array) -> float | None:
    """Step of the lattice on which all values lie, None where there is none or it is finer than what they show."""
    distinct = np.unique(values)
    # Values that differ by the rounding of the arithmetic that made them are the same.
    distinct = distinct[np.append(True, np.diff(distinct) > SAME_VALUE * max(float(np.ptp(values)), 1e-300))]
    if len(distinct) < 3 or len(distinct) > 0.9 * len(values):
        return None
    gaps = np.diff(distinct)
    step = float(np.min(gaps))
    # Values printed with a few digits lie beside their lattice by less than a digit.
    printed = resolution(values)
    slack = 1e-3 * step + (2.0 * printed if printed < FINE_PRINT * step else 0.0)
    step = float(np.median(gaps[gaps <= step + 2.0 * slack]))
    multiples = np.round(gaps / step)
    step = float(np.ptp(distinct) / np.sum(multiples))
    if np.max(np.abs(gaps - multiples * step)) > slack * max(1.0, float(np.max(multiples)) * 1e-3):
        return None
    return step


def resolution(values: Array) -> float:
    """Digit to which values are written: a power of ten, in any unit, or the rounding of floating point."""
    largest = float(np.max(np.abs(values)))
    rounding = 4.0 * float(np.spacing(largest))
    for decimals in range(16):
        digit = 10.0**-decimals
        if digit <= 8.0 * rounding:  # of which any value lies within the rounding of a multiple
            break
        if np.max(np.abs(np.round(values, decimals) - values)) <= rounding:
            return digit
    return _step_in_another_unit(values, rounding) or rounding


def _step_in_another_unit(values: Array, rounding: float) -> float | None:
    """Step of the lattice on which values lie that were written with a few digits and then converted, if there is one.

    Rows that are missing were interpolated, and lie beside it.
    """
    some = values[:MOST_VALUES]
    distinct = np.unique(some)
    gaps = np.diff(distinct)
    wide = np.flatnonzero(gaps > max(rounding, SAME_VALUE * float(np.ptp(some))))
    for index in wide[np.argsort(gaps[wide], kind="stable")][:MOST_STEPS]:
        steps = (some - distinct[index]) / gaps[index]
        if np.max(np.abs(steps)) > MOST_LEVELS:
            continue
        if np.mean(np.abs(steps - np.round(steps)) < BESIDE_LATTICE) >= ON_LATTICE:
            return float(gaps[index])
    return None


def digits(values: Array) -> Array:
    """Digit to which each value is written, shape (N,): that of all of them, or of as many significant digits."""
    finest = resolution(values)
    sizes = np.abs(values)
    decades = np.floor(np.log10(np.where(sizes > 0.0, sizes, 1.0)))
    for significant in range(1, MOST_SIGNIFICANT):
        digit = 10.0 ** (decades - significant + 1)
        if np.all(np.abs(np.round(values / digit) * digit - values) <= 4.0 * np.spacing(sizes)):
            return np.where(sizes > 0.0, np.maximum(digit, finest), finest)
    return np.full(len(values), finest)
