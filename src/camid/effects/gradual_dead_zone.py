"""Dead zone of the actuator whose edges are not sharp."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from camid.effects.base import Array, Effect
from camid.effects.compiled_part import compiled
from camid.effects.dead_zone import DeadZone
from camid.effects.extent import Extent
from camid.effects.gradual_saturation import (
    FIRST_SHARPNESS,
    LEAST_LIMIT,
    SHARPEST,
    GradualSaturation,
    gradually_limited,
)
from camid.effects.parameter import Parameter
from camid.effects.situation import Situation

# Sharpness from which there are edges: at one, where it ends, the curve is a square and then a straight line.
LEAST_SHARPNESS = 1.02


class GradualDeadZone(DeadZone):
    """A zone in which little of the command arrives, as with valves whose edges overlap and leak.

    What does not arrive is a gradual saturation of the command.
    """

    title = "Gradual dead zone of the actuator"
    equation = r"u' = u - u\,/\,(1 + |u/d|^n)^{1/n}"
    reference = "Merritt (1967), Hydraulic Control Systems, section 5.5 (overlap and leakage of a spool valve)"
    parameters = (
        Parameter("half_width", "u", "command d that does not arrive", LEAST_LIMIT),
        Parameter("sharpness", "", "sharpness n of the edges", 1.0, SHARPEST, scale="one"),
    )

    @compiled
    def actuated(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return signal - gradually_limited(signal, values[0], values[1])

    def transform(self, start: Array, end: Array, step: float) -> tuple[Array, Array]:
        """Subtract what does not arrive."""
        width, sharpness = self.vector
        lost = GradualSaturation(limit=width, sharpness=sharpness).transform(start, end, step)
        return start - lost[0], end - lost[1]

    def is_plausible(self, extent: Extent) -> bool:
        """Whether a command leaves it and it has edges: else it is a curve that starts flat, as a power does."""
        has_edges = self.values["half_width"] <= extent.signal and self.values["sharpness"] > LEAST_SHARPNESS
        return bool(has_edges) and super().is_plausible(extent)

    def simplified(self) -> DeadZone:
        """The same width with sharp edges."""
        return DeadZone(half_width=self.values["half_width"])

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From edges that are nearly sharp, and from round ones."""
        for sharpness in FIRST_SHARPNESS:
            yield cls(**{"sharpness": sharpness, **values})

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a dead zone that was found."""
        yield from ()
