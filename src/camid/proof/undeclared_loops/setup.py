"""What acts in a machine and its camera beside the plant; laws install themselves in it."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .rigs import Array

# force in u of time (s), position (y), speed (y/s) and what arrives at the plant (u); it acts against the motion
Force = Callable[[float, float, float, float], float]
# size of a dry friction (u) of position, size of the speed, what arrives, and the side (−1 or 1) it moves to
Level = Callable[[float, float, float, float], float]
# curve of the actuator; a new one for every run, as it may have a memory
Curve = Callable[[], Callable[[float], float]]
# what arrives within a row: of the value before (u), the command (u) and the time in the row (s)
Approach = Callable[[float, float, float], float]


@dataclass(frozen=True)
class Hidden:
    """A force with a state z of its own: ``force`` (u) of z, and ż of position, speed and z."""

    force: Callable[[float], float]
    rate: Callable[[float, float, float], float]


@dataclass(frozen=True)
class Camera:
    """What sees the position: averages over ``exposure`` (s), ends ``latency`` (s) before the stamp; its zero."""

    exposure: float = 0.0
    latency: float = 0.0
    offset: float = 0.0


@dataclass
class Setup:
    """All that is installed; what is empty, None or zero does nothing. Times are in s from the first row."""

    camera: Camera = field(default_factory=Camera)
    forces: dict[str, Force] = field(default_factory=dict)
    friction: Level | None = None
    hidden: Hidden | None = None
    guards: list[Callable[[float, float], float]] = field(default_factory=list)
    gain: Callable[[float], float] | None = None
    damping: Callable[[float], float] | None = None
    # time (s) within a row at which something sets in
    onset: float | None = None
    blow: tuple[float, float] | None = None
    curves: list[Curve] = field(default_factory=list)
    approach: Approach | None = None
    # time in the row (s) at which what arrives has a corner, of the value before and the command (u)
    corner: Callable[[float, float], float] | None = None
    # behind the plant: nodes of the position (y) and speed (y/s) to nodes, with the step between them (s)
    behind: Callable[[Array, Array, float], Array] | None = None
    # a motion beside that of the plant, driven by what arrives: its gain (y/u), frequency (rad/s) and damping ratio
    beside: tuple[float, float, float] | None = None
    # what the camera makes of a position, of a time, and of its readings
    image: Callable[[Array], Array] | None = None
    moments: Callable[[Array], Array] | None = None
    # time by which a reading is early, for a unit of it (s/y)
    shutter: float = 0.0
    readings: Callable[[Array, Array], Array] | None = None

    def copy(self) -> "Setup":
        """A copy that laws may be installed in."""
        return replace(self, forces=dict(self.forces), guards=list(self.guards), curves=list(self.curves))


@dataclass(frozen=True)
class Scales:
    """Sizes of a run without laws.

    ``command`` is the largest command (u), ``slope`` a large change of it (u/s), ``low`` and ``high`` the ends of the
    way (y), ``way`` half of it, ``speed`` the largest speed (y/s), ``bandwidth`` the loop's (rad/s), ``fast`` the
    velocity loop's (rad/s), ``noise`` the camera's standard deviation (y).
    """

    command: float
    slope: float
    low: float
    high: float
    speed: float
    bandwidth: float
    fast: float
    period: float
    duration: float
    noise: float
    gain: float
    turn: float

    @property
    def way(self) -> float:
        """Half of the way (y)."""
        return 0.5 * (self.high - self.low)

    @property
    def reach(self) -> float:
        """Largest distance from zero (y)."""
        return max(abs(self.low), abs(self.high))


@dataclass(frozen=True)
class Draft:
    """A law without its size: ``parameters`` of a size without unit, at most ``cap``, and how to install it."""

    identifier: str
    place: str
    law: str
    parameters: Callable[[float], dict[str, Any]]
    install: Callable[[Setup, dict[str, Any]], None]
    cap: float
    first: float


Drafter = Callable[[Scales, np.random.Generator], Draft]
