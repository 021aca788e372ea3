"""Dead zone of the actuator: small commands do nothing."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from camid.effects.base import Array, Effect
from camid.effects.command import SMALL_SHARES, at_both_ends, one_level
from camid.effects.compiled_part import compiled
from camid.effects.input_quantisation import InputQuantisation
from camid.effects.parameter import Parameter
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

# Steps of a command, up to the largest one, that are few, and such steps as shares of a dead zone's half width.
FEW_STEPS, STEPS_OF_WIDTH = 4.0, (2.0, 2.1, 2.2, 2.3)


class DeadZone(Effect):
    """No force for a command that is smaller than the half width."""

    identifier = "dead-zone"
    place = "actuator"
    title = "Dead zone of the actuator"
    equation = r"u' = \mathrm{sgn}(u)\,\max(|u| - d,\ 0)"
    reference = "Tao & Kokotovic (1996), Adaptive Control of Systems with Actuator and Sensor Nonlinearities"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("half_width", "u", "command d that has no effect", 0.0),)
    separated_by = (SeparatingExperiment.MANY_LEVELS,)
    strength = "half_width"
    keeps_hold = True

    @compiled
    def actuated(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return signal - min(max(signal, -values[0]), values[0])

    def transform(self, start: Array, end: Array, step: float) -> tuple[Array, Array]:
        """Subtract the half width."""
        width = self.values["half_width"]
        return at_both_ends(lambda u: np.sign(u) * np.maximum(np.abs(u) - width, 0.0), start, end)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Several shares of the largest input."""
        for share in SMALL_SHARES:
            yield cls(half_width=share * situation.largest("signal"))

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """A command that is rounded to few steps, as that of a three-position valve: below half a step it does nothing.

        A dead zone that is fitted to it is narrower, as the command does more than its rest from there on.
        """
        steps = [share * self.values["half_width"] for share in STEPS_OF_WIDTH]
        few = situation.largest("signal") < FEW_STEPS * steps[0]
        return tuple(InputQuantisation(step=step) for step in steps) if few else ()

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """A two-level input shows nothing of it."""
        return one_level(situation, "a dead zone")
