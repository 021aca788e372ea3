"""Backlash behind the plant: the load rests on one side of a gap, and a reversal has to cross it first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from camid.compiled import njit
from camid.effects.base import Array, Effect
from camid.effects.parameter import Parameter
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

if TYPE_CHECKING:
    from camid.chain.motion import Motion

# First guesses: half of the gap as a share of the largest displacement.
SHARES = (0.01, 0.05, 0.2)
# Where in the gap the drive begins.
STARTS = (-0.7, 0.7)
# Share of the gap from its edge within which they touch.
TOUCHING = 1e-6


@njit
def _pushes(ahead: float, velocity: float, half_width: float) -> bool:
    """Whether a drive that is so far ahead of the load is at the edge of the gap that it moves to."""
    touching = (1.0 - TOUCHING) * half_width
    return (velocity > 0.0 and ahead >= touching) or (velocity < 0.0 and -ahead >= touching)


@njit
def _dragged(
    position: Array, velocity: Array, velocity_end: Array, step: float, half_width: float, place: float
) -> tuple[Array, Array, Array, Array]:
    """Position, velocity, velocity at the end of each step and integral of a load that the gap lets lag."""
    count = len(position)
    load, speed, speed_end, integral = np.empty(count), np.zeros(count), np.zeros(count - 1), np.zeros(count)
    value = position[0] - place * half_width
    load[0] = value
    for k in range(count - 1):
        before, falls = value, velocity[k] - velocity_end[k]
        if velocity[k] * velocity_end[k] < 0.0:  # it turns round within the step
            turn = position[k] + 0.5 * velocity[k] * step * velocity[k] / falls
            value = min(max(value, turn - half_width), turn + half_width)
        value = min(max(value, position[k + 1] - half_width), position[k + 1] + half_width)
        load[k + 1] = value
        # It moves with the drive where that pushes it.
        if _pushes(position[k] - before, velocity[k], half_width):
            speed[k] = velocity[k]
        if _pushes(position[k + 1] - value, velocity_end[k], half_width):
            speed_end[k] = speed[k + 1] = velocity_end[k]
        mean = 0.5 * (before + value) + step / 12.0 * (speed[k] - speed_end[k])
        integral[k + 1] = integral[k] + step * mean
    return load, speed, speed_end, integral


class OutputBacklash(Effect):
    """Play between the plant and what the sensor sees: a load that friction holds while the drive crosses the gap.

    What the sensor sees is the load, and the plant's motion that of the drive.
    """

    identifier = "output-backlash"
    place = "plant"
    title = "Backlash (play) behind the plant"
    equation = r"w(t) = \min(\max(w(t^-),\ y(t) - b),\ y(t) + b)"
    reference = "Nordin & Gutman (2002), Automatica 38, 1633-1649 (friction-driven hysteresis model)"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("half_width", "y", "half b of the gap", 0.0),)
    separated_by = (SeparatingExperiment.MANY_LEVELS,)
    strength = "half_width"

    @property
    def place_in_the_gap(self) -> float:
        """Where the drive begins, from −1 to 1."""
        return 0.0

    def carry(self, motion: Motion) -> Motion:
        """The load's."""
        drive = (motion.position, motion.velocity, motion.velocity_end, motion.step)
        load, speed, speed_end, integral = _dragged(*drive, self.values["half_width"], self.place_in_the_gap)
        smooth = replace(motion, jump_times=np.zeros(0), jumps=np.zeros((0, 3)))
        return replace(smooth, position=load, velocity=speed, velocity_end=speed_end, integral=integral)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Several shares of the largest displacement."""
        for share in SHARES:
            yield cls(half_width=share * situation.largest("position"))


class OutputBacklashFromAnywhere(OutputBacklash):
    """The same from any place in the gap."""

    parameters = (
        *OutputBacklash.parameters,
        Parameter("start", "", "where the drive begins in the gap, from −1 to 1", -1.0, 1.0, scale="one"),
    )

    @property
    def place_in_the_gap(self) -> float:
        """As it says."""
        return float(self.values["start"])

    def simplified(self) -> OutputBacklash:
        """From the middle of the gap."""
        return OutputBacklash(half_width=self.values["half_width"])

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From either side."""
        for start in STARTS:
            yield cls(start=start, **values)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from the middle of the gap."""
        return iter(())
