"""A force that remembers the motion."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from math import exp, sqrt
from typing import ClassVar

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.friction import CoulombFriction
from camid.effects.parameter import Parameter
from camid.effects.plant_force import GUESS, AgainstMotion, mobility
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation


class Hysteresis(AgainstMotion):
    """Bouc–Wen hysteresis: a force that follows the motion and saturates, whichever way it goes."""

    identifier = "hysteresis"
    place = "plant"
    title = "Hysteresis (Bouc-Wen)"
    equation = r"f = h\,z,\quad \dot z = \kappa\left(\dot y - \frac{1}{2}|\dot y|\,z - \frac{1}{2}\dot y\,|z|\right)"
    reference = "Wen (1976), J. Eng. Mech. Div. ASCE 102, 249-263"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("strength", "u", "largest hysteretic force h", 0.0),
        Parameter("shape", "1/y", "inverse κ of the displacement that saturates it", 1e-300),
    )
    separated_by = (SeparatingExperiment.FREE_DECAY,)
    strength = "strength"
    largest_memory = 1.0

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * memory

    @compiled
    def memory_after(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        # Exact: dz/dx = κ against the present sign of z, and κ (1 - |z|) along it.
        way = values[1] * position
        side = 1.0 if way >= 0.0 else -1.0
        along, way = side * memory, side * way
        if along < 0.0:
            if way <= -along:
                return side * (along + way)
            way, along = way + along, 0.0
        return side * (1.0 - (1.0 - along) * exp(-way))

    @compiled
    def switch(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return velocity

    def simplified(self) -> CoulombFriction:
        """Coulomb friction of the saturated force."""
        return CoulombFriction(force=self.values["strength"])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """A loop that saturates more suddenly; and Coulomb friction of nearly the same loop.

        That with pre-sliding displacement, and that which turns round gradually.
        """
        values = {"force": self.values["strength"], "presliding": 1.0 / self.values["shape"]}
        starts: list[Effect] = []
        if np.any(situation.signal):  # a free decay runs through each loop once, and says little of its corners
            starts += self.with_keys(["exponent"]).starts(situation, **self.values)
        for law in CoulombFriction.finer_laws:
            names = {p.name for p in law.parameters}
            if "bristle_exponent" in names:  # begun from bristles without one, where these explain as much
                continue
            starts += law.starts(situation, **{name: value for name, value in values.items() if name in names})
        return tuple(starts)

    def frequency(self, plant: TransferFunction) -> float:
        """Of the body on the unsaturated hysteretic spring."""
        return sqrt(mobility(plant) * self.values["strength"] * self.values["shape"])

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Saturation from a small share of the motion to more than all of it."""
        force = GUESS * situation.largest("signal")
        for share in (0.04, 0.15, 0.5, 1.5):
            for level in (1.0, 8.0):
                yield cls(strength=level * force, shape=1.0 / (share * situation.largest("position")))
        for law in cls.finer_laws:
            yield from law.candidates(situation)
