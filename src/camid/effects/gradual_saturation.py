"""Saturation of the actuator with a knee that is not sharp."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from camid.compiled import njit
from camid.effects.actuator import Saturation
from camid.effects.base import Array, Effect
from camid.effects.command import at_both_ends
from camid.effects.compiled_part import compiled
from camid.effects.parameter import Parameter
from camid.effects.plant_force import LEAST_FACTOR
from camid.effects.situation import Situation

# Limits of first guesses, as shares of the largest input, and their sharpness: a knee, and about a hyperbolic tangent.
SHARES = (4.0, 1.5, 0.6)
FIRST_SHARPNESS = (6.0, 2.4)
# A knee that is sharper than this cannot be told from a corner.
SHARPEST = 20.0
# Limits below this are this.
LEAST_LIMIT = 1e-300


@njit(error_model="numpy")
def gradually_limited(signal: float, limit: float, sharpness: float) -> float:
    """One command, bent before a limit, both in u; see :class:`GradualSaturation`."""
    ratio = abs(signal / limit)
    larger = max(ratio, 1.0)  # no power of a large ratio, which may be infinite
    return float(signal / (larger * (1.0 + (min(ratio, 1.0) / larger) ** sharpness) ** (1.0 / sharpness)))


class GradualSaturation(Saturation):
    """A limit that is approached gradually, as amplifiers, magnetic circuits and valves do."""

    title = "Gradual saturation of the actuator"
    equation = r"u' = u\,/\,(1 + |u/s|^n)^{1/n}"
    reference = "Rapp (1991), Proc. 2nd European Conf. Satellite Communications, 179-184"
    parameters = (
        Parameter("limit", "u", "largest force s in units of the command", LEAST_LIMIT),
        Parameter("sharpness", "", "sharpness n of the knee", 1.0, SHARPEST, scale="one"),
    )

    @compiled
    def actuated(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return gradually_limited(signal, values[0], values[1])

    def transform(self, start: Array, end: Array, step: float) -> tuple[Array, Array]:
        """Bend before the limit."""
        limit, sharpness = self.values["limit"], self.values["sharpness"]

        def bent(signal: Array) -> Array:
            ratio = np.abs(signal / limit)
            larger = np.maximum(ratio, 1.0)  # no power of a large ratio, which may be infinite
            return np.asarray(
                signal / (larger * (1.0 + (np.minimum(ratio, 1.0) / larger) ** sharpness) ** (1.0 / sharpness))
            )

        return at_both_ends(bent, start, end)

    def scaled(self, factor: float) -> GradualSaturation:
        """Another limit: while that is far off the effect falls with this power of it."""
        limit, sharpness = self.vector
        return self.with_vector(np.array([limit / max(factor, LEAST_FACTOR) ** (1.0 / sharpness), sharpness]))

    def simplified(self) -> Saturation:
        """The same limit with a sharp knee."""
        return Saturation(limit=self.values["limit"])

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From a knee that is nearly sharp, and from a round one."""
        for sharpness in FIRST_SHARPNESS:
            yield cls(**{"sharpness": sharpness, **values})

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Limits beyond the largest input, and within."""
        for share in SHARES:
            yield cls(limit=share * situation.largest("signal"), sharpness=FIRST_SHARPNESS[-1])
