"""Dry friction whose asperities bend like bristles before they slide: pre-sliding displacement (Dahl, LuGre).

A body under such friction is never quite held: below the level it moves as if on a spring, by about the pre-sliding
displacement. The laws bear the names of the friction that they become where that displacement is small, and are those
of Canudas de Wit et al. (1995) without damping of the bristles. Their deflection ζ is counted in pre-sliding
displacements, so that it is one where the body breaks away, and its step is exact for a level that does not change.
"""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from math import exp, sqrt
from typing import Any, Self

import numpy as np

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.base import Array, Effect
from camid.effects.compiled_part import compiled
from camid.effects.extent import Extent
from camid.effects.friction import CoulombFriction, StribeckFriction
from camid.effects.parameter import Parameter
from camid.effects.plant_force import mobility, motion_sign
from camid.effects.situation import Situation

# Largest pre-sliding displacement as a share of the way that a recording spans. A stroke over all of it then bends the
# bristles to 96 % of what they reach, tanh(1/(2·share)); a force that never saturates is hysteresis, not friction.
LARGEST_SHARE = 0.25
# Least pre-sliding displacement that a fit tries, in standard deviations of the position.
LEAST_SHARE = 3e-3
# Multiple of that up to which a fitted one is none.
AT_BOUND = 1.01
# First guesses of levels that fall with the speed, at the speed and at rest, in those of Coulomb friction, and of the
# displacement in its; and of the speed, in standard deviations of the velocity.
LEVELS = ((0.7, 1.3, 2.0), (0.5, 1.5, 1.5))
VELOCITIES = (1.0, 0.3)
# First guesses of a pre-sliding displacement, in standard deviations of the position.
BENDS = (0.05, 0.25)

# How much finer the integrator's steps are where the level changes with the speed: over a step it is that of the mean.
FINER = 1.4

PRESLIDING = Parameter("presliding", "y", "pre-sliding displacement δ: the bristles' bend at break-away", 1e-300)


class _Bristles(Effect):
    """What laws with pre-sliding displacement have in common."""

    uses_velocity = False
    friction_level = None
    largest_memory = 1.0
    _least: float = PRESLIDING.lower

    @compiled
    def switch(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return velocity

    def along(self, situation: Situation) -> Self:
        """The same law, to be fitted to a motion: a bend of less than a small part of that is none."""
        self._least = max(LEAST_SHARE * float(np.std(situation.position)), PRESLIDING.lower)
        return self

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a friction that was found."""
        yield from ()

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """Displacements that are small and middling parts of the motion, unless one is given."""
        spread = float(np.std(situation.position)) or 1.0
        for bend in [values.pop("presliding")] if "presliding" in values else [share * spread for share in BENDS]:
            yield cls(**values, presliding=bend).along(situation)

    def with_vector(self, vector: Array) -> Self:
        """The same effect with other numbers."""
        moved = super().with_vector(vector)
        moved._least = self._least
        return moved

    def bounds(self, acquisition: Acquisition) -> list[tuple[float, float]]:
        """Those of the parameters, and the least displacement that the motion can show."""
        return [(self._least if p == PRESLIDING else p.lower, p.upper) for p in self.numeric()]

    def is_plausible(self, extent: Extent) -> bool:
        """Whether the body slides on a way of such a length."""
        return bool(self.values["presliding"] <= LARGEST_SHARE * extent.span) and super().is_plausible(extent)


class CoulombBristleFriction(_Bristles, CoulombFriction):  # type: ignore[misc] # no level holds the body
    """Coulomb friction with pre-sliding displacement (Dahl's law)."""

    title = "Coulomb friction with pre-sliding displacement"
    equation = r"f = f_c\,\zeta,\quad \delta\,\dot \zeta = \dot y - |\dot y|\,\zeta"
    reference = "Dahl (1976), Solid friction damping of mechanical vibrations, AIAA J. 14, 1675-1682"
    parameters = (*CoulombFriction.parameters, PRESLIDING)

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * memory

    @compiled
    def memory_after(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        side = 1.0 if position >= 0.0 else -1.0
        return side + (memory - side) * exp(-side * position / values[1])

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Level with the sign of the plant's gain, and displacement."""
        return [motion_sign(plant) * self.values["force"], self.values["presliding"]]

    def simplified(self) -> CoulombFriction:
        """Coulomb friction of the same level."""
        return CoulombFriction(force=self.values["force"])

    def frequency(self, plant: TransferFunction) -> float:
        """Of the body on the bristles."""
        return sqrt(mobility(plant) * self.values["force"] / self.values["presliding"])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """Levels that fall with the speed and, of bristles alone, other exponents, if anything bends."""
        level, bend = self.values["force"], self.values["presliding"]
        if bend <= AT_BOUND * self._least:
            return ()
        exponents = CoulombFriction.with_keys(["presliding", "bristle_exponent"]).starts(situation, **self.values)
        spread = float(np.std(situation.velocity)) or 1.0
        guesses = [
            {"coulomb": low * level, "breakaway": high * level, "velocity": share * spread, "presliding": more * bend}
            for share in VELOCITIES
            for low, high, more in LEVELS
        ]
        falling = (start for values in guesses for start in StribeckBristleFriction.starts(situation, **values))
        # What falls comes first: where that leaves noise alone, no exponent is tried.
        return (*falling, *exponents)


class StribeckBristleFriction(_Bristles, StribeckFriction):  # type: ignore[misc] # no level holds the body
    """Stribeck friction with pre-sliding displacement (the LuGre law)."""

    title = "Stribeck friction with pre-sliding displacement"
    equation = (
        r"f = f_s\,\zeta,\quad \delta\,\dot \zeta = \dot y - \frac{f_s}{g(\dot y)}|\dot y|\,\zeta,\quad "
        r"g = f_c + (f_s - f_c)\,e^{-(\dot y/v_s)^2}"
    )
    reference = "Canudas de Wit, Olsson, Astrom & Lischinsky (1995), IEEE Trans. Autom. Control 40, 419-425"
    parameters = (*StribeckFriction.parameters, PRESLIDING)

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[4] * values[1] * memory

    @compiled
    def memory_after(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        if values[1] <= 0.0:
            return 0.0
        share = velocity / values[2]
        reached = (values[0] + (values[1] - values[0]) * exp(-share * share)) / values[1]
        side = 1.0 if position >= 0.0 else -1.0
        way = side * position
        if reached <= 1e-12:
            return memory if way == 0.0 else 0.0
        return side * reached + (memory - side * reached) * exp(-way / (values[3] * reached))

    def force_values(self, plant: TransferFunction) -> list[float]:
        """The parameters, and the sign of the plant's gain."""
        return [*self.vector, motion_sign(plant)]

    def simplified(self) -> CoulombFriction:
        """Coulomb friction of the larger of both levels, with the same displacement."""
        level = max(self.values["coulomb"], self.values["breakaway"])
        return CoulombBristleFriction(force=level, presliding=self.values["presliding"])

    def scaled(self, factor: float) -> StribeckBristleFriction:
        """Both levels, scaled."""
        return self.with_vector(self.vector * np.array([max(factor, 0.0), max(factor, 0.0), 1.0, 1.0]))

    def frequency(self, plant: TransferFunction) -> float:
        """Of the body on the bristles, and of the fall of friction with speed."""
        bristles = sqrt(mobility(plant) * self.values["breakaway"] / self.values["presliding"])
        return FINER * (bristles + super().frequency(plant))

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """None."""
        return ()
