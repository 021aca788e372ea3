"""What recordings span and what else a model holds, which the values of an effect have to suit."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf


@dataclass(frozen=True)
class Extent:
    """The largest of what a problem's recordings reach; infinite where nothing is known.

    Attributes
    ----------
    span : float
        Way, in units of the output.
    duration : float
        Seconds.
    speed : float
        Root mean square, in units of the output per second.
    signal : float
        Absolute value of the input, in its units.
    beside : frozenset of str
        Identifiers of the other effects.
    """

    span: float
    duration: float
    speed: float = inf
    signal: float = inf
    beside: frozenset[str] = frozenset()
