"""Laws without a name: a force, or a curve of actuator or sensor, as values at knots with straight lines between them.

A diagnosis learns one where no law of the catalogue carries what is left (:mod:`camid.fitting.learned_law`). It is no
member of the catalogue, since a name says what a thing is and a curve only what it does.
"""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from math import isnan, sqrt
from typing import Any, Self

import numpy as np

from camid.chain.plant import TransferFunction
from camid.compiled import njit
from camid.effects.base import Array, Effect
from camid.effects.compiled_part import compiled
from camid.effects.parameter import Parameter
from camid.effects.plant_force import mobility, motion_sign

FEWEST_KNOTS = 2
# What a diagnosis says of a law; the values at the knots are what a simulation runs.
WORDS = (
    Parameter("formula", "", "a short formula that says as much, where one is known", is_name=True, default=""),
    Parameter("description", "", "the law in words", is_name=True, default=""),
)


@njit(error_model="numpy")
def interpolated(at: float, values: Any, first: int, count: int) -> float:
    """Value at a point of a curve that is constant beyond its ends.

    ``values`` holds ``count`` knots from the index ``first`` on, and the heights behind them.
    """
    last = first + count - 1
    if isnan(at):  # a motion that ran away has no place between knots
        return at
    if at <= values[first]:
        return float(values[first + count])
    if at >= values[last]:
        return float(values[last + count])
    # Most knots are about equally far apart, so that the search begins where such knots would lie, and widens.
    guess = first + int((at - values[first]) / (values[last] - values[first]) * (count - 1))
    guess, width = min(guess, last - 1), 1
    low = guess
    while values[low] > at:
        low = max(low - width, first)
        width *= 2
    high, width = max(guess, low) + 1, 1
    while values[high] <= at:
        low, high = high, min(high + width, last)
        width *= 2
    while high - low > 1:
        middle = (low + high) // 2
        if values[middle] <= at:
            low = middle
        else:
            high = middle
    share = (at - values[low]) / (values[high] - values[low])
    return float(values[low + count] + share * (values[high + count] - values[low + count]))


class LearnedEffect(Effect, ABC):
    """An effect whose law is values at knots.

    Raises
    ------
    ValueError
        If the knots do not increase, or there are not as many values.
    """

    listed = False

    def __init__(self, **values: Any) -> None:
        super().__init__(**values)
        knots, heights = self.values["knots"], self.values["values"]
        if len(knots) < FEWEST_KNOTS or np.any(np.diff(knots) <= 0.0):
            raise ValueError(f"{self.identifier}: knots must be at least {FEWEST_KNOTS} increasing numbers")
        if len(knots) != len(heights):
            raise ValueError(f"{self.identifier}: {len(knots)} knots, but {len(heights)} values")

    @property
    def knots(self) -> Array:
        """Where the law is given, shape (k,)."""
        return np.asarray(self.values["knots"], dtype=float)

    @property
    @abstractmethod
    def knot_unit(self) -> str:
        """Unit of the knots, in u, y and s."""

    @property
    def unit(self) -> str:
        """Unit of the values, in u, y and s."""
        return "u"

    @property
    def heights(self) -> Array:
        """Its values there, shape (k,)."""
        return np.asarray(self.values["values"], dtype=float)

    @abstractmethod
    def blank(self) -> Self:
        """The law on the same knots that does nothing."""

    def refined(self) -> Self:
        """The law that does nothing on twice as many knots."""
        middle = 0.5 * (self.knots[1:] + self.knots[:-1])
        knots = np.sort(np.concatenate([self.knots, middle])).tolist()
        return type(self)(**{**self.values, "knots": knots, "values": [0.0] * len(knots)}).blank()

    def with_heights(self, heights: Sequence[float] | Array) -> Self:
        """The same law with other values at its knots."""
        return type(self)(**{**self.values, "values": [float(h) for h in heights]})


# What a learned force depends on, and what its values at the knots are multiplied with: nothing, velocity or input.
FORCES = {
    "position": ("position", None),
    "velocity": ("velocity", None),
    "damping over position": ("position", "velocity"),
    "gain over position": ("position", "input"),
    "gain over velocity": ("velocity", "input"),
}


class LearnedForce(LearnedEffect):
    """A force over position or velocity, or a damping or a loss of gain over one; beyond the knots as at the last."""

    identifier = "learned-force"
    place = "plant"
    title = "Learned force"
    equation = r"f = f(y),\ f(\dot y),\ d(y)\,\dot y,\ g(y)\,u\ \mathrm{or}\ g(\dot y)\,u"
    reference = "Wahba (1990), Spline Models for Observational Data, SIAM"
    parameters = (
        Parameter("variables", "", "what the force depends on", choices=tuple(FORCES)),
        Parameter("knots", "", "where it is given, in y or y/s", sequence=True),
        Parameter(
            "values", "", "force there, against the motion, in u, or what is multiplied with u or ẏ", sequence=True
        ),
        *WORDS,
    )

    def __init__(self, **values: Any) -> None:
        super().__init__(**values)
        self.over, self.times = FORCES[self.values["variables"]]
        self.uses_velocity = "velocity" in (self.over, self.times)

    @property
    def knot_unit(self) -> str:
        """That of position or velocity."""
        return "y/s" if self.over == "velocity" else "y"

    @property
    def unit(self) -> str:
        """That of a force, a damping or a pure number."""
        return {None: "u", "velocity": "u s/y", "input": ""}[self.times]

    def blank(self) -> Self:
        """No force."""
        return self.with_heights(np.zeros(len(self.knots)))

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        at = velocity if values[0] > 0.0 else position
        height = interpolated(at, values, 3, int(values[2]))
        return height * velocity if values[1] == 1.0 else height * signal if values[1] == 2.0 else height

    def force_values(self, plant: TransferFunction) -> list[float]:
        """What it is over, what it is multiplied with, how many knots there are, the knots, and values along u."""
        times = {None: 0.0, "velocity": 1.0, "input": 2.0}[self.times]
        # A loss of gain has the sign of the input already.
        heights = self.heights if self.times == "input" else motion_sign(plant) * self.heights
        return [float(self.over == "velocity"), times, float(len(self.knots)), *self.knots, *heights]

    def frequency(self, plant: TransferFunction) -> float:
        """Of the body on the steepest part of the law."""
        if self.times == "input":
            return 0.0
        if self.times == "velocity":
            return mobility(plant) * float(np.max(np.abs(self.heights)))
        slope = float(np.max(np.abs(np.diff(self.heights) / np.diff(self.knots)), initial=0.0))
        return mobility(plant) * slope if self.over == "velocity" else sqrt(mobility(plant) * slope)


class LearnedCurve(LearnedEffect):
    """A static curve of the actuator or the sensor; beyond the knots it goes on with the slope one."""

    identifier = "learned-curve"
    place = "actuator"
    title = "Learned curve"
    equation = r"u' = c(u)\quad\mathrm{or}\quad w = c(y),\quad \mathrm{linear\ between\ the\ knots}"
    reference = "Wahba (1990), Spline Models for Observational Data, SIAM"
    parameters = (
        Parameter("variables", "", "what the curve bends", choices=("input", "reading")),
        Parameter("knots", "", "where it is given, in u or y", sequence=True),
        Parameter("values", "", "what becomes of those, in u or y", sequence=True),
        *WORDS,
    )
    keeps_hold = True

    def __init__(self, **values: Any) -> None:
        super().__init__(**values)
        self.of_input = self.values["variables"] == "input"
        if not self.of_input:
            # The one class stands for curves at both ends of the chain.
            vars(self)["place"] = "sensor"

    @property
    def knot_unit(self) -> str:
        """That of what is bent."""
        return "u" if self.of_input else "y"

    @property
    def unit(self) -> str:
        """The same."""
        return self.knot_unit

    def blank(self) -> Self:
        """The straight line of slope one."""
        return self.with_heights(self.knots)

    def bent(self, signal: Array) -> Array:
        """What becomes of a signal, shape (N,)."""
        return np.asarray(signal + np.interp(signal, self.knots, self.heights - self.knots))

    @compiled
    def actuated(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        count = int(values[0])
        return signal if count == 0 else signal + interpolated(signal, values, 1, count)

    def force_values(self, plant: TransferFunction) -> list[float]:
        """How many knots the actuator's curve has, the knots, and by how much it bends there."""
        return [float(len(self.knots)), *self.knots, *(self.heights - self.knots)] if self.of_input else [0.0]

    def transform(self, start: Array, end: Array, step: float) -> tuple[Array, Array]:
        """Bend the input."""
        if not self.of_input:
            return start, end
        bent = self.bent(start)
        return bent, bent if end is start else self.bent(end)

    def observe(self, output: Array, time: Array) -> Array:
        """Bend what is read."""
        return output if self.of_input else self.bent(output)
