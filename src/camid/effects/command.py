"""What effects on the command share: how many levels it has, and a static curve of it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from camid.effects.base import Array
from camid.effects.situation import Situation

# Shares of the largest input at which half widths are looked for.
SMALL_SHARES = (0.02, 0.08, 0.2, 0.4, 0.7)


def levels(signal: Array) -> int:
    """Number of different absolute values of an input, at most three counted."""
    sizes = np.abs(signal)
    largest = float(np.max(sizes, initial=0.0)) or 1.0
    return min(len(np.unique(np.round(sizes / largest, 6))), 3)


def one_level(situation: Situation, effect: str) -> str | None:
    """Why held inputs of one absolute value do not show a static curve of it; None if it may."""
    if situation.acquisition.hold == "zoh" and levels(situation.all_signals) == 1:
        return f"the input has one absolute value only, for which {effect} is a change of the gain"
    return None


def at_both_ends(function: Callable[[Array], Array], start: Array, end: Array) -> tuple[Array, Array]:
    """A static function of both ends of each step; a held input stays one array."""
    first = function(start)
    return first, (first if end is start else function(end))
