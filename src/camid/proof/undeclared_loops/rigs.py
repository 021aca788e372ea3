"""Machines that move on and on under a constant command, each with its units, its rate of rows and its drive."""

from dataclasses import dataclass
from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]
Generator = np.random.Generator


@dataclass(frozen=True)
class Rig:
    """A machine y⁽ⁿ⁾ + … = gain (u − f), of order two or three, with one integrator.

    ``damping`` holds the coefficients of the denominator between the leading one and the last, which is zero, in
    descending powers (1/s for order two; 1/s, 1/s² for order three); ``gain`` is the numerator (y/(u sⁿ)), ``period``
    the rows' (s), ``limit`` what the drive can do (u), and ``turn`` a radian in units of y, zero for a way.
    """

    name: str
    command_unit: str
    position_unit: str
    gain: float
    damping: tuple[float, ...]
    period: float
    limit: float
    turn: float = 0.0

    @property
    def order(self) -> int:
        """Number of poles."""
        return len(self.damping) + 1

    @property
    def reaction(self) -> float:
        """Sum of the time constants (s)."""
        slow = self.damping[-1]
        return 1.0 / slow if self.order == 2 else self.damping[0] / slow

    @property
    def slow_gain(self) -> float:
        """Gain of the plant of order two that is left where the fastest lag is forgotten (y/(u s²))."""
        return self.gain if self.order == 2 else self.gain / self.damping[0]

    @property
    def slow_damping(self) -> float:
        """Damping of the plant of order two that is left where the fastest lag is forgotten (1/s)."""
        return self.damping[0] if self.order == 2 else self.damping[1] / self.damping[0]


DEGREES = 57.29577951308232
# name, units of the command and of the position, gain, poles (1/s), periods (s), limit, a radian
_LIST: tuple[tuple[str, str, str, float, tuple[float, ...], tuple[float, ...], float, float], ...] = (
    ("linear-motor axis", "A", "mm", 2500.0, (6.0,), (0.001, 0.002), 8.0, 0.0),
    ("ball screw", "V", "mm", 800.0, (20.0,), (0.002, 0.0025), 10.0, 0.0),
    ("rotary table", "N m", "deg", 5200.0, (4.0,), (0.0025, 0.005), 6.0, DEGREES),
    ("gimbal", "V", "deg", 4300.0, (14.0,), (0.001, 0.002), 12.0, DEGREES),
    ("pneumatic slide", "bar", "mm", 1500.0, (8.0,), (0.004, 0.005), 5.0, 0.0),
    ("hydraulic cylinder", "V", "mm", 1300.0, (25.0,), (0.002, 0.004), 10.0, 0.0),
    ("crane trolley", "V", "m", 0.9, (1.6,), (0.01,), 10.0, 0.0),
    ("reaction wheel", "mN m", "rad", 0.05, (1.2,), (0.01,), 20.0, 1.0),
    ("conveyor", "Hz", "m", 0.09, (4.0,), (0.01, 0.008), 50.0, 0.0),
    ("arm joint", "V", "rad", 60.0, (9.0,), (0.002, 0.004), 10.0, 1.0),
    ("servo press", "V", "mm", 1.6e5, (18.0, 160.0), (0.002,), 10.0, 0.0),
    ("voice-coil stage", "V", "um", 3.2e8, (12.0, 420.0), (0.001,), 5.0, 0.0),
)
NAMES = tuple(entry[0] for entry in _LIST)


def draw_rig(rng: Generator, plain: bool = False) -> Rig:
    """Draw a rig whose numbers differ from its kind's by up to a half; ``plain`` asks for one of order two."""
    listed = [entry for entry in _LIST if not plain or len(entry[4]) == 1]
    name, command, position, gain, poles, periods, limit, turn = listed[int(rng.integers(len(listed)))]
    shaken = [pole * float(np.exp(rng.uniform(-0.4, 0.4))) for pole in poles]
    damping = (shaken[0],) if len(shaken) == 1 else (shaken[0] + shaken[1], shaken[0] * shaken[1])
    period = float(periods[int(rng.integers(len(periods)))])
    return Rig(name, command, position, gain * float(np.exp(rng.uniform(-0.4, 0.4))), damping, period, limit, turn)
