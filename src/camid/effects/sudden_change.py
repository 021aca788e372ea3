"""A coefficient of the plant that changes at once: a battery is switched, a spring breaks, a payload is picked up."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.drift import ParameterDrift
from camid.effects.parameter import Parameter
from camid.effects.plant_force import force_along, mobility, static_damping, static_stiffness
from camid.effects.residual_regression import ResidualRegression, sampled
from camid.effects.situation import Situation

COEFFICIENTS = ("stiffness", "damping", "gain", "inertia")
# When the change may have been, as shares of a recording; then around the best time, in steps of these.
SHARES = np.linspace(0.02, 0.98, 49)
FINER = np.linspace(-1.0, 1.0, 17)
REFINED = 2
# Relative change that a guess is worked out with, the largest one that it begins with, and the least there is.
FIRST, LARGEST, LEAST = 0.01, 0.5, -0.99
# Coefficients whose changes are begun with.
LIKELIEST = 2


class SuddenChange(ParameterDrift):
    """A coefficient of the plant that changes once, at once."""

    title = "Sudden change of a coefficient"
    equation = r"c(t) = c\,(1 + s)\ \ (t \geq t_0),\quad c(t) = c\ \ (t < t_0)"
    reference = "Basseville & Nikiforov (1993), Detection of Abrupt Changes, chapter 8"
    parameters = (
        Parameter("coefficient", "", "what changes", choices=COEFFICIENTS),
        Parameter("change", "", "relative change s", LEAST),
        Parameter("time", "s", "time t_0", scale="period"),
    )
    strength = "change"
    trials = "frames"

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        if time < values[4]:
            return 0.0
        return values[0] * (values[1] * position + values[2] * velocity - values[3] * signal)

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Change, the coefficients of position, velocity and input that change, and when.

        Of an inertia that grows all forces do less.
        """
        change = self.values["change"]
        if self.values["coefficient"] == "inertia":
            forces = static_stiffness(plant), static_damping(plant), 1.0
            return [1.0 / (1.0 + change) - 1.0, *forces, self.values["time"]]
        return [change, *self.changing(plant), self.values["time"]]

    def breaks(self) -> tuple[float, ...]:
        """When it changes."""
        return (self.values["time"],)

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """Where the drift that was found may have been a change at once."""
        drift = ParameterDrift.with_keys(values)(**values)
        motion = situation.time, situation.position, situation.velocity, situation.signal
        force = force_along(drift, situation.plant, motion)
        drifted = sampled(situation.response_to_force, force, situation.acquisition)
        yield from cls.candidates(replace(situation, residual=situation.residual + situation.used * drifted))

    def restarts(self, situation: Situation) -> tuple[Effect, ...]:
        """When the residual shows a change of this coefficient beside what it does: a sum of squares has many minima.

        While the input rests, or the body, a change does not show.
        """
        others = self.starts(situation, **self.values)
        period = situation.acquisition.period
        return tuple(
            each
            for each in others
            if each.values["coefficient"] == self.values["coefficient"]
            and abs(each.values["time"] - self.values["time"]) > period
        )

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Each coefficient, when a change of it explains most of the residual, to first order; the likeliest first.

        None of a free decay: there a time is an amplitude, and what the law of a force has inexactly changes with it.
        """
        if not np.any(situation.signal):
            return
        answer = situation.response_to_force
        regression = ResidualRegression(situation, lambda forces: sampled(answer, forces, situation.acquisition))
        if regression.fails:
            return
        seen = regression.situation
        kinds = COEFFICIENTS if mobility(situation.plant) > 0.0 else COEFFICIENTS[:-1]
        found: list[tuple[float, SuddenChange]] = []
        for kind in kinds:
            law = cls(coefficient=kind, change=FIRST, time=float(seen.time[0]))
            force = force_along(law, situation.plant, (seen.time, seen.position, seen.velocity, seen.signal))
            times = np.quantile(seen.time, SHARES)
            for _ in range(REFINED):
                left, shown = regression.left(force[:, None] * (seen.time[:, None] >= times))
                products = np.where(shown, regression.residual @ left, 0.0)
                powers = np.maximum(np.sum(left**2, axis=0), 1e-300)
                best = int(np.argmax(products**2 / powers))
                gain, change = products[best] ** 2 / powers[best], FIRST * products[best] / powers[best]
                time = float(times[best])
                times = time + (times[1] - times[0]) * FINER
            if gain > 0.0:
                bounded = float(np.clip(change, -LARGEST, LARGEST))
                found.append((gain, cls(coefficient=kind, change=bounded, time=time)))
        yield from (law for _, law in sorted(found, key=lambda each: -each[0])[:LIKELIEST])

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """None: it is sudden however long the clock has run."""
        return None
