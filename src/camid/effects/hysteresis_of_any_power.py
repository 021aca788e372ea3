"""Hysteresis that saturates more suddenly than the plain Bouc–Wen law: its exponent is free."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.hysteresis import Hysteresis
from camid.effects.parameter import Parameter
from camid.effects.situation import Situation

# First guesses of the exponent.
EXPONENTS = (2.0, 4.0)
# Longest step of the normalised way along which the loop is followed, and the way from which on it has saturated: what
# is left of it is exp(-way) at most.
STEP, SATURATED = 0.1, 40.0


class HysteresisOfAnyPower(Hysteresis):
    """Bouc–Wen hysteresis with its exponent: the larger it is, the longer the force is straight before it saturates."""

    title = "Hysteresis (Bouc-Wen) of any power"
    equation = (
        r"f = h\,z,\quad \dot z = \kappa\left(\dot y - \frac{1}{2}|\dot y|\,z\,|z|^{n-1} "
        r"- \frac{1}{2}\dot y\,|z|^n\right)"
    )
    reference = Hysteresis.reference
    parameters = (
        *Hysteresis.parameters,
        Parameter("exponent", "", "exponent n; 1 for the plain law", 1.0, 20.0, scale="one"),
    )

    @compiled
    def memory_after(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        # Exact against the present sign of z; dz/dx = κ (1 - |z|^n) along it has no closed form.
        way = values[1] * position
        side = 1.0 if way >= 0.0 else -1.0
        along, way = side * memory, side * way
        if along < 0.0:
            if way <= -along:
                return side * (along + way)
            way, along = way + along, 0.0
        if way >= SATURATED:
            return side * max(along, 1.0)
        power = values[2]
        count = int(way / STEP) + 1
        step = way / count
        for _ in range(count):
            first = 1.0 - along**power
            second = 1.0 - max(along + 0.5 * step * first, 0.0) ** power
            third = 1.0 - max(along + 0.5 * step * second, 0.0) ** power
            fourth = 1.0 - max(along + step * third, 0.0) ** power
            along = along + step * (first + 2.0 * second + 2.0 * third + fourth) / 6.0
        return side * along

    def simplified(self) -> Hysteresis:  # type: ignore[override] # with less detail, and not another name
        """The plain law."""
        return Hysteresis(strength=self.values["strength"], shape=self.values["shape"])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """None: friction has a loop that saturates."""
        return ()

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """As stiff at first, and more sudden."""
        for exponent in EXPONENTS:
            yield cls(**{"exponent": exponent, **values})

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a plain law that was found."""
        yield from ()
