"""What the columns of a recording look like: a clock, a held command, a smooth measurement; their steps and levels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FEWEST_ROWS = 3
# A clock's steps lie within this share of their median, but for this share of rows that may be missing.
CLOCK_SPREAD, CLOCK_EXCEPTIONS = 0.5, 0.05
# A held command has few levels, or keeps its value over most rows and then jumps by more than this share of its range.
FEW_LEVELS, HELD_SHARE, JUMP = 8, 0.5, 0.05
# Ratio of the changes from row to row to the values, both as standard deviations: √2 for white noise.
SMOOTH = 0.5
# Quantisation is told from rounding to decimals by the number of rows on each level.
ROWS_PER_LEVEL = 4.0
QUANTUM_TOLERANCE = 0.02


@dataclass(frozen=True)
class Nature:
    """What a column looks like.

    Attributes
    ----------
    kind : {"clock", "constant", "held", "smooth", "rough"}
    levels : int
        Number of different values.
    roughness : float
        Standard deviation of the changes from row to row over that of the values; √2 for white noise.
    step : float or None
        Of a quantiser (an encoder, a counter), in the units of the cells.
    period : float or None
        Median step of a clock.
    """

    kind: str
    levels: int
    roughness: float
    step: float | None = None
    period: float | None = None

    def words(self) -> str:
        """A few words for a message."""
        if self.kind == "clock":
            return f"a clock, steps of {self.period:.6g}"
        if self.kind == "held":
            return f"held, {self.levels} levels" if self.levels <= 1000 else "held"
        return {"constant": "constant", "smooth": "smooth", "rough": "changes at every row"}[self.kind]


def nature_of(values: Array) -> Nature | None:
    """Nature of a column of numbers, shape (N,), NaN left out; None of fewer than three numbers."""
    known = values[np.isfinite(values)]
    if len(known) < FEWEST_ROWS:
        return None
    levels = len(np.unique(known))
    if levels == 1:
        return Nature("constant", 1, 0.0)
    with np.errstate(over="ignore", invalid="ignore"):
        changes = np.diff(known)
        spread = float(np.std(known))
        roughness = float(np.std(changes)) / spread if spread > 0.0 else 0.0
    period = _clock_period(changes)
    if period is not None:
        return Nature("clock", levels, roughness, period=period)
    if _is_held(known, changes, levels):
        return Nature("held", levels, roughness)
    return Nature("smooth" if roughness < SMOOTH else "rough", levels, roughness, quantisation_step(known, levels))


def _clock_period(changes: Array) -> float | None:
    median = float(np.median(changes))
    if not 0.0 < median < np.inf or np.min(changes) < 0.0:
        return None
    regular = np.abs(changes - median) <= CLOCK_SPREAD * median
    return median if np.mean(regular) >= 1.0 - CLOCK_EXCEPTIONS else None


def _is_held(values: Array, changes: Array, levels: int) -> bool:
    if levels <= FEW_LEVELS and len(values) >= 2 * FEW_LEVELS:
        return True
    moved = np.abs(changes[changes != 0.0])
    still = 1.0 - len(moved) / len(changes)
    return bool(still >= HELD_SHARE and len(moved) and np.median(moved) > JUMP * np.ptp(values))


def quantisation_step(values: Array, levels: int | None = None) -> float | None:
    """Step of a quantiser whose multiples all differences of the values are; None where there is none.

    Values that only carry few decimals have a step, too, but hardly ever several rows on each level.
    """
    found = np.unique(values)
    if levels is None:
        levels = len(found)
    if levels < FEWEST_ROWS or len(values) < ROWS_PER_LEVEL * levels:
        return None
    gaps = np.diff(found)
    # Equal levels that were computed in two ways differ by rounding.
    gaps = gaps[gaps > 1e-9 * np.ptp(found)]
    step = float(np.median(gaps[gaps <= 1.5 * np.min(gaps)]))
    multiples = gaps / step
    off = np.abs(multiples - np.round(multiples))
    return step if np.all(off <= QUANTUM_TOLERANCE * np.maximum(multiples, 1.0)) else None


# Kinds that a column of each role has, likeliest first.
LIKELY = {
    "time": ("clock",),
    "input": ("held", "rough", "smooth"),
    "output": ("smooth", "rough", "held"),
    "label": ("held", "constant"),
}
MOST_SHOWN = 6


def would_do(columns: Mapping[str, Array], role: str | None) -> str:
    """The columns that may play a role, each with a few words on why, likeliest first; empty if there is none.

    Parameters
    ----------
    columns : mapping of str to ndarray
        NaN where a cell holds no number; they need not be of one length.
    role : {"time", "input", "output", "label"} or None
        None: any.
    """
    natures = {name: nature for name, values in columns.items() if (nature := nature_of(values)) is not None}
    if not natures:
        return ""
    # A recording's columns are of one length; what is shorter is a parameter.
    longest = max(len(columns[name]) for name in natures)
    likely = LIKELY.get(role or "", ("clock", "held", "rough", "smooth"))
    fitting = [
        name
        for kind in likely
        for name, nature in natures.items()
        if nature.kind == kind and len(columns[name]) >= 0.5 * longest
    ]
    if role is None:
        fitting.sort(key=list(columns).index)
    shown = [f"{name} ({natures[name].words()})" for name in fitting[:MOST_SHOWN]]
    if len(fitting) > MOST_SHOWN:
        shown.append(f"{len(fitting) - MOST_SHOWN} more")
    return ", ".join(shown)
