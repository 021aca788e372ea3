"""An actuator whose force fades, or grows, along the way: a coil that leaves its magnet, a solenoid, a cam."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.extent import Extent
from camid.effects.parameter import Parameter
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

# Change of the gain at the largest displacement of a first guess, and over a recording's way up to which it is one.
SMALL, LARGEST = 0.05, 3.0


class PositionDependentGain(Effect):
    """A gain that grows along the way."""

    identifier = "position-dependent-gain"
    place = "actuator"
    title = "Gain that depends on the position"
    drawn_against = "position"
    equation = r"u' = u\,(1 + g\,y)"
    reference = "Klippel (2006), J. Audio Eng. Soc. 54, 907-939"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("slope", "1/y", "relative growth g of the gain"),)
    separated_by = (SeparatingExperiment.MANY_LEVELS, SeparatingExperiment.FREE_DECAY)
    strength = "slope"

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return -values[0] * position * signal

    def is_plausible(self, extent: Extent) -> bool:
        """Whether the gain is one over the way that a recording spans, and no input that the position makes."""
        return bool(abs(self.values["slope"]) * extent.span <= LARGEST)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small, as the effect is proportional to it; and of a coil that leaves its magnet on either side alike."""
        yield PositionDependentGain(slope=SMALL / situation.largest("position"))
        yield from CurvedPositionDependentGain.starts(situation, slope=0.0)

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """What no input drives shows no gain."""
        return None if np.any(situation.all_signals) else "there is no input, of which it is a gain"


class CurvedPositionDependentGain(PositionDependentGain):
    """A gain with a largest or a least value along the way."""

    title = "Gain that depends on the position, with a curvature"
    equation = r"u' = u\,(1 + g\,y + h\,y^2)"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        *PositionDependentGain.parameters,
        Parameter("curvature", "1/y^2", "curvature h of the gain"),
    )

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return -(values[0] + values[1] * position) * position * signal

    def is_plausible(self, extent: Extent) -> bool:
        """Whether both terms are those of a gain."""
        return super().is_plausible(extent) and bool(abs(self.values["curvature"]) * extent.span**2 <= LARGEST)

    def scaled(self, factor: float) -> CurvedPositionDependentGain:
        """Both terms in proportion."""
        return self.with_vector(factor * self.vector)

    def simplified(self) -> PositionDependentGain:
        """A straight line of the same slope."""
        return PositionDependentGain(slope=self.values["slope"])

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """A line that is bent a little: the effect is proportional to it."""
        yield cls(**values, curvature=-SMALL / situation.largest("position") ** 2)
