"""Overflow of a storage whose edge lets out the more, the higher the level stands above it."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import sqrt
from typing import Any

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.flows_of_storages import time_constants
from camid.effects.parameter import Parameter
from camid.effects.plant_force import motion_sign
from camid.effects.situation import Situation
from camid.effects.storage import STEP_SHARE, Overflow

# How far the largest input raises the level above the edge in first guesses, as shares of the edge's height.
LEVELS_ABOVE = (0.05, 0.2)
# Level above the edge up to which steps of the integrator are short enough, as a share of the edge's height.
STEEPEST_AT = 0.25
NO_SINGLE_STORAGE = "only a single storage is known to flow off over a weir: a plant of one pole without zeros"


class OverflowOverWeir(Overflow):
    """A single storage whose excess flows off over a weir, so that its level stands above the edge for a while."""

    title = "Overflow over a weir"
    equation = r"e = w\,(x - h)^{3/2}\quad \mathrm{where}\quad x > h"
    reference = "Bos (1989), Discharge Measurement Structures, 3rd ed., ILRI publication 20, chapter 1 (weirs)"
    parameters = (
        Parameter("height", "y", "level h of the edge"),
        Parameter("weir", "u/y^1.5", "flow w over the edge at a level of one above it", 0.0),
    )
    strength = "weir"
    uses_velocity = False

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """Only a single storage is known to flow off so."""
        return None if len(time_constants(situation.plant)) == 1 else NO_SINGLE_STORAGE

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        side = 1.0 if values[0] >= 0.0 else -1.0
        above = side * (position - values[0])
        return side * values[1] * above * sqrt(above) if above > 0.0 else 0.0

    @compiled
    def switch(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return position - values[0]

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Height and flow at a level of one above it, which has the sign of the plant's gain."""
        return [self.values["height"], motion_sign(plant) * self.values["weir"]]

    def frequency(self, plant: TransferFunction) -> float:
        """Of a storage that flows off over its edge."""
        steepness = 1.5 * self.values["weir"] * sqrt(STEEPEST_AT * abs(self.values["height"]))
        return STEP_SHARE * abs(plant.monic.numerator[0]) * steepness if plant.order == 1 else 0.0

    def beside(self, others: Sequence[Effect], period: float) -> OverflowOverWeir:
        """No other outflow changes what flows over the edge."""
        return self

    def simplified(self) -> Overflow:
        """The same edge, at which the level ends."""
        return Overflow(height=self.values["height"], share=0.0)

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """From edges below the level that ended the motion, of which the largest input needs a little or more."""
        if values["below"] != "none" or values["state"] or not values["height"]:
            return
        for share in LEVELS_ABOVE:
            weir = situation.largest("signal") / abs(share * values["height"]) ** 1.5
            yield cls(height=(1.0 - share) * values["height"], weir=weir)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from an overflow that was found."""
        yield from ()
