"""What a benchmark hands back, and how numbers are written for people."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pandas as pd


@dataclass(frozen=True)
class Goal:
    """A number that camid aims at.

    Attributes
    ----------
    text : str
        The goal in words.
    measured, limit : float
    larger_is_better : bool
        Whether the measured number has to reach the limit from above.
    """

    text: str
    measured: float
    limit: float
    larger_is_better: bool = False

    @property
    def met(self) -> bool:
        """Whether the goal is reached."""
        return self.measured >= self.limit if self.larger_is_better else self.measured <= self.limit


@dataclass(frozen=True)
class Report:
    """Result of one benchmark.

    Attributes
    ----------
    name, title, explanation : str
        File name without suffix, heading, and a paragraph that says what was measured.
    table : DataFrame
        All numbers, for the CSV.
    shown : DataFrame of str
        The same for people.
    goals : list of Goal
    """

    name: str
    title: str
    explanation: str
    table: pd.DataFrame
    shown: pd.DataFrame
    goals: list[Goal] = field(default_factory=list)


def number(value: float, digits: int = 3) -> str:
    """A number with this many significant digits, without an exponent where people need none; a dash for none."""
    if not np.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    magnitude = int(np.floor(np.log10(abs(value))))
    if not -5 <= magnitude < 7:
        return f"{value:.{digits - 1}e}"
    rounded = round(value, digits - 1 - magnitude)
    return f"{rounded:,.{max(digits - 1 - magnitude, 0)}f}".replace(",", " ")
