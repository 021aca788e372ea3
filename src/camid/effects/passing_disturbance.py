"""A force that sets in and is over after a while: somebody leans on the rig, a load is set down and taken away."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.disturbance import StepDisturbance, explained_from_each_row
from camid.effects.parameter import Parameter
from camid.effects.plant_force import without_force
from camid.effects.situation import Situation

# Rows, and share of a recording, that durations of first guesses lie between, how many, and how many are begun with.
SHORTEST, LONGEST = 4, 0.5
DURATIONS = 10
LIKELIEST = 2


class PassingDisturbance(StepDisturbance):
    """A force that sets in, stays for a while, and is over."""

    title = "Disturbance that passes"
    equation = r"d = s\ \ (t_0 \leq t < t_0 + \tau),\quad d = 0\ \ \mathrm{else}"
    reference = "Basseville & Nikiforov (1993), Detection of Abrupt Changes, section 7.2"
    parameters = (*StepDisturbance.parameters, Parameter("duration", "s", "duration τ", 0.0, scale="period"))

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return -values[0] if values[1] <= time < values[1] + values[2] else 0.0

    def breaks(self) -> tuple[float, ...]:
        """Its onset and its end."""
        return self.values["time"], self.values["time"] + self.values["duration"]

    def simplified(self) -> StepDisturbance:
        """One that stays."""
        return StepDisturbance(size=self.values["size"], time=self.values["time"])

    def restarts(self, situation: Situation) -> tuple[StepDisturbance, ...]:
        """When, and how long, the residual shows it beside what it does."""
        return tuple(type(self).candidates(without_force(situation, self)))

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """None: nothing that happens once does as much and as little."""
        return ()

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """Where the force that was found to stay may have passed."""
        yield from cls.candidates(without_force(situation, StepDisturbance(**values)))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[StepDisturbance]:
        """Where the response to a force of some duration fits the residual best."""
        response = cls._response(situation)
        longest = int(LONGEST * len(response))
        if longest <= SHORTEST:
            return
        found: list[tuple[float, StepDisturbance]] = []
        for rows in np.unique(np.geomspace(SHORTEST, longest, DURATIONS).astype(int)):
            passing = response.copy()
            passing[rows:] -= response[:-rows]
            explained, factors = explained_from_each_row(situation.residual, passing)
            best = int(np.argmax(explained))
            when, duration = float(situation.time[best]), float(rows * situation.acquisition.period)
            found.append((explained[best], cls(size=float(factors[best]), time=when, duration=duration)))
        yield from (law for _, law in sorted(found, key=lambda each: -each[0])[:LIKELIEST])
