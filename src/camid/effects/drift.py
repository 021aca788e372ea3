"""Coefficients of the plant that change while it is recorded."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from math import exp
from typing import Any, ClassVar

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.parameter import Parameter
from camid.effects.plant_force import static_damping, static_stiffness
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

# A drift that settles faster has always been settled.
LEAST_TIME_CONSTANT = 1e-6
# Relative change over the recording of first guesses, and the shares of it that time constants are of.
CHANGE = 0.05
SETTLED_WITHIN = (0.2, 0.6)


class ParameterDrift(Effect):
    """A coefficient of the plant that changes in proportion to the time."""

    identifier = "parameter-drift"
    place = "plant"
    title = "Drift of a coefficient"
    drawn_against = "time"
    equation = r"c(t) = c\,(1 + r\,t)"
    reference = "Ljung (1999), System Identification, 2nd ed., section 11.2"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("coefficient", "", "what drifts", choices=("stiffness", "damping", "gain")),
        Parameter("rate", "1/s", "relative change r per second"),
    )
    separated_by = (SeparatingExperiment.REPEATED_INPUT,)
    of_one_recording = True
    strength = "rate"

    def __init__(self, **values: Any) -> None:
        super().__init__(**values)
        self.uses_velocity = self.values["coefficient"] == "damping"

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        return values[0] * time * (values[1] * position + values[2] * velocity - values[3] * signal)

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Rate, and the coefficients of position, velocity and input that drift."""
        return [self.values["rate"], *self.changing(plant)]

    def changing(self, plant: TransferFunction) -> tuple[float, float, float]:
        """The coefficients of position, velocity and input that change."""
        kind = self.values["coefficient"]
        return (
            static_stiffness(plant) if kind == "stiffness" else 0.0,
            static_damping(plant) if kind == "damping" else 0.0,
            1.0 if kind == "gain" else 0.0,
        )

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Each coefficient, by a twentieth over the recording, at a constant rate, early on, or at once.

        What settles within a fifth of the recording is no drift at a constant rate, and is not found by way of one.
        """
        for kind in ("stiffness", "damping", "gain"):
            drift = cls(coefficient=kind, rate=CHANGE / situation.duration)
            yield drift
            yield from islice(SettlingDrift.starts(situation, **drift.values), 1)
        for law in cls.finer_laws:
            yield from law.candidates(situation)

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """Of a clock that began long before, the drift is another coefficient."""
        return situation.far_from_zero


class Settling(Effect):
    """What drifts that settle have in common: where they are started from."""

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """Of time constants within the recording, the drift by its end being what it is."""
        for share in SETTLED_WITHIN:
            settled = share * (1.0 - exp(-1.0 / share))
            yield cls(**(values | {"rate": values["rate"] / settled, "time_constant": share * situation.duration}))

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """It is started from a drift that was found."""
        yield from ()


class SettlingDrift(Settling, ParameterDrift):
    """A coefficient of the plant that changes and settles, as one does of a machine that warms up."""

    title = "Drift of a coefficient that settles"
    equation = r"c(t) = c\,(1 + r\,\tau\,(1 - e^{-t/\tau}))"
    reference = "Incropera et al. (2007), Fundamentals of Heat and Mass Transfer, 6th ed., section 5.1"
    parameters = (*ParameterDrift.parameters, Parameter("time_constant", "s", "time constant τ", LEAST_TIME_CONSTANT))

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """None of a free decay: there a time is an amplitude, and drag or dry friction settles with it."""
        if np.any(situation.signal):
            yield from super().starts(situation, **values)

    @compiled
    def force(time, position, velocity, signal, memory, values):  # type: ignore[no-untyped-def]
        change = values[0] * values[4] * (1.0 - exp(time / -values[4]))
        return change * (values[1] * position + values[2] * velocity - values[3] * signal)

    def force_values(self, plant: TransferFunction) -> list[float]:
        """Rate at the begin, the coefficients of position, velocity and input that drift, and the time constant."""
        return [*super().force_values(plant), self.values["time_constant"]]

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """What changes early on may do so at once."""
        laws = (law for law in ParameterDrift.finer_laws if "change" in {p.name for p in law.parameters})
        return tuple(start for law in laws for start in law.starts(situation, **self.values))

    def simplified(self) -> ParameterDrift:
        """The same rate for ever."""
        return ParameterDrift(coefficient=self.values["coefficient"], rate=self.values["rate"])
