"""Coulomb friction with bristles that break away more or less suddenly: Dahl's law with its exponent."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from math import exp
from typing import Any

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.bristle_friction import CoulombBristleFriction
from camid.effects.compiled_part import compiled
from camid.effects.parameter import Parameter
from camid.effects.plant_force import motion_sign
from camid.effects.situation import Situation

# Exponents of brittle contacts are below one, those of ductile ones above (Dahl 1976).
LEAST, LARGEST = 0.2, 4.0
FIRST = (0.6, 1.7)
# Difference from one below which the law is the plain one to within rounding, and share of the level that is all of it.
PLAIN, ALL = 1e-6, 1e-12


class CoulombBristlesOfAnyExponent(CoulombBristleFriction):
    """Coulomb friction with pre-sliding displacement whose bristles yield with a power of what is left."""

    title = "Coulomb friction with pre-sliding displacement of any exponent"
    equation = r"f = f_c\,\zeta,\quad \delta\,\dot \zeta = \dot y\,(1 - \zeta\,\mathrm{sgn}\,\dot y)^i"
    reference = CoulombBristleFriction.reference
    parameters = (
        *CoulombBristleFriction.parameters,
        Parameter("bristle_exponent", "", "exponent i of the bristles; 1 without it", LEAST, LARGEST, scale="one"),
    )

    @compiled
    def memory_after(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        # Exact: what is left to break away falls as dw/dx = -w^i/δ.
        side = 1.0 if position >= 0.0 else -1.0
        way, left = side * position / values[1], 1.0 - side * memory
        further = values[2] - 1.0
        if left <= ALL:
            return side
        if abs(further) < PLAIN:
            return side * (1.0 - left * exp(-way))
        power = left**-further + further * way
        return side * (1.0 - power ** (-1.0 / further)) if power > 0.0 else side

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Level with the sign of the plant's gain, displacement and exponent."""
        return [motion_sign(plant) * self.values["force"], self.values["presliding"], self.values["bristle_exponent"]]

    def frequency(self, plant: TransferFunction) -> float:
        """Of the body on bristles that have turned round, which are the stiffer the larger the exponent is."""
        return float(super().frequency(plant) * max(2.0 ** (0.5 * (self.values["bristle_exponent"] - 1.0)), 1.0))

    def simplified(self) -> CoulombBristleFriction:
        """The plain law of the same displacement."""
        return CoulombBristleFriction(force=self.values["force"], presliding=self.values["presliding"])

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """None."""
        return ()

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """Brittle and ductile, of bristles that were found."""
        if "presliding" in values:
            yield from (cls(**values, bristle_exponent=exponent).along(situation) for exponent in FIRST)
