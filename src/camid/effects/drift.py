"""Coefficients of the plant that change while it is recorded."""

# Compiled parts are functions in a class body: they have no self, and Compiled lists their arguments.
# ruff: noqa: D102, N805

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.compiled_part import compiled
from camid.effects.parameter import Parameter
from camid.effects.plant_force import static_damping, static_stiffness
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation


class ParameterDrift(Effect):
    """A coefficient of the plant that changes in proportion to the time."""

    identifier = "parameter-drift"
    place = "plant"
    title = "Drift of a coefficient"
    drawn_against = "time"
    equation = r"c(t) = c\,(1 + r\,t)"
    reference = "Ljung (1999), System Identification, 2nd ed., section 11.2"
    parameters = (
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
        kind = self.values["coefficient"]
        return [
            self.values["rate"],
            static_stiffness(plant) if kind == "stiffness" else 0.0,
            static_damping(plant) if kind == "damping" else 0.0,
            1.0 if kind == "gain" else 0.0,
        ]

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Each coefficient, by a twentieth over the recording."""
        for kind in ("stiffness", "damping", "gain"):
            yield cls(coefficient=kind, rate=0.05 / situation.duration)

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """Of a clock that began long before, the drift is another coefficient."""
        return situation.far_from_zero
