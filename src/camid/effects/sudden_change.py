"""A coefficient of the plant that changes at once: a battery is switched, a spring breaks, a payload is picked up."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from camid.chain.companion_form import time_scale
from camid.chain.plant import TransferFunction
from camid.effects.base import Array, Effect
from camid.effects.compiled_part import compiled
from camid.effects.drift import ParameterDrift
from camid.effects.parameter import Parameter
from camid.effects.plant_force import force_along, mobility, static_damping, static_stiffness, without_force
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
# Times nearby that are looked at, and rows on either side that they reach over at least.
NEARBY, NEARBY_ROWS = 33, 8


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
        yield from cls.candidates(without_force(situation, ParameterDrift.with_keys(values)(**values)))

    def restarts(self, situation: Situation) -> tuple[Effect, ...]:
        """When the residual shows a change beside what this one does, and of what: a sum of squares has many minima.

        While the input rests, or the body, a change does not show, and about where the force turns round one before
        does what one behind does. Of another coefficient it looks much like this one, to first order, and no fit leads
        from one to the other.
        """
        before = without_force(situation, self)
        period = situation.acquisition.period
        others = [
            each
            for each in self.candidates(before)
            if each.values["coefficient"] != self.values["coefficient"]
            or abs(each.values["time"] - self.values["time"]) > period
        ]
        return (*others, *self._nearby(before))

    def _nearby(self, situation: Situation) -> list[SuddenChange]:
        """The same change at times nearby that explain more than those around them, the likeliest first."""
        from scipy.signal import find_peaks

        search = _Search(situation)
        if search.regression.fails:
            return []
        reach = max(time_scale(situation.plant.monic.denominator), NEARBY_ROWS * situation.acquisition.period)
        times = self.values["time"] + reach * np.linspace(-1.0, 1.0, NEARBY)
        gains, _ = search.at(self.values["coefficient"], times)
        peaks, _ = find_peaks(gains)
        others = sorted((int(i) for i in peaks if abs(i - NEARBY // 2) > 1), key=lambda i: -gains[i])
        return [type(self)(**(self.values | {"time": float(times[i])})) for i in others[:LIKELIEST]]

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Each coefficient, when a change of it explains most of the residual, to first order; the likeliest first.

        None of a free decay: there a time is an amplitude, and what the law of a force has inexactly changes with it.
        """
        if not np.any(situation.signal):
            return
        search = _Search(situation)
        if search.regression.fails:
            return
        kinds = COEFFICIENTS if mobility(situation.plant) > 0.0 else COEFFICIENTS[:-1]
        found: list[tuple[float, SuddenChange]] = []
        for kind in kinds:
            times = np.quantile(search.regression.situation.time, SHARES)
            for _ in range(REFINED):
                gains, changes = search.at(kind, times)
                best = int(np.argmax(gains))
                gain, change, time = gains[best], changes[best], float(times[best])
                times = time + (times[1] - times[0]) * FINER
            if gain > 0.0:
                bounded = float(np.clip(change, -LARGEST, LARGEST))
                found.append((gain, cls(coefficient=kind, change=bounded, time=time)))
        yield from (law for _, law in sorted(found, key=lambda each: -each[0])[:LIKELIEST])

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """None: it is sudden however long the clock has run."""
        return None


class _Search:
    """What changes of a coefficient at some times explain of a situation's residual, to first order."""

    def __init__(self, situation: Situation) -> None:
        answer, acquisition = situation.response_to_force, situation.acquisition
        self.plant = situation.plant
        self.regression = ResidualRegression(situation, lambda forces: sampled(answer, forces, acquisition))

    def at(self, coefficient: str, times: Array) -> tuple[Array, Array]:
        """Gains and relative changes at times, shape (c,)."""
        seen = self.regression.situation
        law = SuddenChange(coefficient=coefficient, change=FIRST, time=float(seen.time[0]))
        force = force_along(law, self.plant, (seen.time, seen.position, seen.velocity, seen.signal))
        left, shown = self.regression.left(force[:, None] * (seen.time[:, None] >= times))
        products = np.where(shown, self.regression.residual @ left, 0.0)
        powers = np.maximum(np.sum(left**2, axis=0), 1e-300)
        return products**2 / powers, FIRST * products / powers
