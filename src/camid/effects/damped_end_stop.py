"""End stop that takes energy where it is met, as rubber, felt and a clamped joint do."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.parameter import Parameter
from camid.effects.situation import Situation
from camid.effects.stiffness import EndStop

# Damping of first guesses at the usual speed, as a share of the force of the spring.
SHARES = (0.3, 2.0)


class DampedEndStop(EndStop):
    """A stop that pushes harder against what comes than against what goes, and never pulls."""

    title = "End stop that takes energy"
    equation = r"f = k_s\,\max(y - y_s,\ 0)\,\max(1 + a\,\dot y,\ 0)\ \ (y_s > 0);\quad \mathrm{mirrored\ for}\ y_s < 0"
    reference = "Hunt & Crossley (1975), J. Appl. Mech. 42, 440-445"
    parameters = (
        *EndStop.parameters,
        Parameter("loss", "s/y", "damping a of the contact, for its force and a unit of the speed", 0.0),
    )
    uses_velocity = True

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        side = 1.0 if values[0] >= 0.0 else -1.0
        depth = side * (position - values[0])
        if depth <= 0.0:
            return 0.0
        return values[1] * side * depth * max(1.0 + values[2] * side * velocity, 0.0)

    def simplified(self) -> EndStop:
        """The same without a loss."""
        return EndStop(position=self.values["position"], stiffness=self.values["stiffness"])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """A force that grows with a power of the depth."""
        laws = (law for law in EndStop.finer_laws if {"loss", "power"} <= {p.name for p in law.parameters})
        return tuple(start for law in laws for start in law.starts(situation, **self.values))

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From a small loss and from a large one."""
        usual = float(np.std(situation.velocity)) or 1.0
        yield from (cls(**{"loss": share / usual, **values}) for share in SHARES)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a stop that was found."""
        yield from ()
