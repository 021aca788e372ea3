"""Rate limit of an actuator that slows down as it arrives: a servo of first order whose speed is limited."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from math import exp
from typing import Any

import numpy as np

from camid.compiled import njit
from camid.effects.actuator import RateLimit
from camid.effects.base import Array, Effect
from camid.effects.compiled_part import compiled
from camid.effects.parameter import Parameter
from camid.effects.plant_force import LEAST_FACTOR
from camid.effects.situation import Situation

# Parts of a step of the input in which speed and command are constant.
PARTS = 4
# An actuator that arrives faster arrives at once.
LEAST_TIME_CONSTANT = 1e-9
# Distance from the command at which it slows down in first guesses, as a share of the largest change.
DISTANCES = (0.05, 0.25)


@njit
def _approach(start: Array, end: Array, step: float, rate: float, constant: float) -> tuple[Array, Array]:
    after, after_end = np.empty_like(start), np.empty_like(end)
    length = step / PARTS
    share, longest = 1.0 - np.exp(-length / constant), rate * length
    value = 0.0
    for k in range(len(start)):
        first, mean = value, 0.0
        for part in range(PARTS):
            command = start[k] + (end[k] - start[k]) * (part + 0.5) / PARTS
            left = command - value
            if abs(left) * share <= longest:
                mean += (command - left * share * constant / length) / PARTS
                value += left * share
            else:
                way = longest if left > 0.0 else -longest
                mean += (value + 0.5 * way) / PARTS
                value += way
        # A straight piece of the same mean and the same slope on average.
        middle = 0.5 * (value - first)
        after[k], after_end[k] = mean - middle, mean + middle
    return after, after_end


class RateLimitedLag(RateLimit):
    """The actuator approaches its command with a lag, and no faster than a rate."""

    title = "Rate limit of an actuator with a lag"
    equation = r"\dot u' = \max(-r,\ \min((u - u')/\tau,\ r))"
    reference = "Duda (2016), in Nonlinear Analysis and Synthesis Techniques for Aircraft Control, 329-353 (actuators)"
    parameters = (
        *RateLimit.parameters,
        Parameter("time_constant", "s", "time constant τ of the approach", LEAST_TIME_CONSTANT),
    )

    @compiled
    def actuated(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        way = (signal - memory) * (1.0 - exp(time / -values[1]))
        return memory + min(max(way, -values[0] * time), values[0] * time)

    def transform(self, start: Array, end: Array, step: float) -> tuple[Array, Array]:
        """Approach at a limited rate, from zero."""
        rate, constant = self.vector
        return _approach(np.ascontiguousarray(start), np.ascontiguousarray(end), step, rate, constant)

    def scaled(self, factor: float) -> RateLimitedLag:
        """Another time for the same change, by the same way."""
        return self.with_vector(self.vector * np.array([1.0 / max(factor, LEAST_FACTOR), factor]))

    def simplified(self) -> RateLimit:
        """The same rate until it arrives."""
        return RateLimit(rate=self.values["rate"])

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """Slowing down within a small and a middling part of the largest change."""
        change = float(np.max(np.abs(np.diff(situation.signal)), initial=0.0)) or 1.0
        for share in DISTANCES:
            constant = max(share * change / max(values["rate"], LEAST_FACTOR), LEAST_TIME_CONSTANT)
            yield cls(**({"time_constant": constant} | values))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a rate limit that was found."""
        yield from ()
