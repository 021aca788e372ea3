"""Hysteresis whose loops are of any shape: a Bouc–Wen law that need not saturate, and one that hardens."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from math import exp, log
from typing import Any

from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.extent import Extent
from camid.effects.hysteresis import Hysteresis
from camid.effects.parameter import Parameter
from camid.effects.plant_force import GUESS
from camid.effects.situation import Situation

# First guesses of how the force bends on its way back, and of the way on which it bends as a share of the largest one.
RETURNS = (0.5, 1.2)
SHARES = (0.3, 1.5)
# Largest curvature on the way back; of materials it lies between 0 and 1 (Erlicher & Point 2004, Int. J. Solids Struct.
# 41, 4175-4200). The force may reach a multiple of h then, which is no larger either.
LARGEST_BACK = 10.0
# Curvature along a way below which there is none.
STRAIGHT = 1e-9


class HysteresisOfAnyLoop(Hysteresis):
    """Bouc–Wen hysteresis with both of its curvatures: along the force, and on the way back.

    Without a curvature on the way back it is the law that saturates; with as much as along it the loop is a lens, and
    with more it hardens as it is pushed on.
    """

    title = "Hysteresis (Bouc-Wen) of any loop"
    equation = (
        r"f = h\,z,\quad \dot z = \kappa\left(\dot y - \frac{1}{2}|\dot y|\,z "
        r"- \left(\frac{1}{2} - \rho\right)\dot y\,|z|\right)"
    )
    reference = "Ismail, Ikhouane & Rodellar (2009), Arch. Comput. Methods Eng. 16, 161-188"
    parameters = (
        *Hysteresis.parameters,
        Parameter("curvature_back", "", "curvature ρ on the way back; that along the force is 1 − ρ", scale="one"),
    )
    largest_memory = LARGEST_BACK

    @compiled
    def memory_after(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        # Exact: dz/dx = κ (1 - (1 - ρ) |z|) along the present sign of z, and κ (1 + ρ |z|) against it.
        way = values[1] * position
        side = 1.0 if way >= 0.0 else -1.0
        along, way = side * memory, side * way
        back = values[2]
        if along < 0.0:
            depth = -along
            growth = 1.0 + back * depth
            if growth <= 0.0:
                return memory
            to_zero = depth if abs(back) < STRAIGHT else log(growth) / back
            if way <= to_zero:
                if abs(back) < STRAIGHT:
                    return side * (along + way)
                return side * (1.0 / back - (depth + 1.0 / back) * exp(-back * way))
            way, along = way - to_zero, 0.0
        forth = 1.0 - back
        if abs(forth) < STRAIGHT:
            return side * (along + way)
        left = exp(-forth * way)
        return side * (along * left + (1.0 - left) / forth)

    def is_plausible(self, extent: Extent) -> bool:
        """Whether it is a loop: one that grows like a power of e on its way is another force."""
        return bool(abs(self.values["curvature_back"]) <= LARGEST_BACK) and super().is_plausible(extent)

    def simplified(self) -> Hysteresis:  # type: ignore[override] # with less detail, and not another name
        """The law that saturates."""
        return Hysteresis(strength=self.values["strength"], shape=self.values["shape"])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """None: friction has a loop that saturates."""
        return ()

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """As stiff, with other curvatures."""
        for back in RETURNS:
            yield cls(**{"curvature_back": back, **values})

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small loops over a part of the motion and over more than all of it."""
        force = GUESS * situation.largest("signal")
        for share in SHARES:
            for back in RETURNS:
                yield cls(strength=force, shape=1.0 / (share * situation.largest("position")), curvature_back=back)
