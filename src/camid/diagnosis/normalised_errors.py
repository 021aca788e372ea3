"""What simulations leave of the recorded output, as a share of its spread, on rows that were not fitted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from camid.number_text import span

# Error, as a share of the output's standard deviation, from which a simulation explains hardly anything.
EXPLAINS_NOTHING = 0.9
# Error in these rows, in that of the noise, from which what holds in the fitted ones is said not to carry over to them.
CARRIED_OVER = 2.0


@dataclass(frozen=True)
class NormalisedErrors:
    """Normalised errors on rows that were not fitted.

    Attributes
    ----------
    nominal, refitted, improved : float
        RMSE over the standard deviation of the recorded output in these rows, or over that of the whole recording where
        it rests in them: the simulation as given, with its coefficients re-estimated, and with the effects found.
    noise_floor : float
        What a perfect model would leave, from the noise of the improved model.
    validation : tuple of float
        Start and end in seconds of the rows not fitted.
    chosen : bool
        Whether the tool chose those rows itself.
    position : tuple of float or None
        In a closed loop, where the other errors are those of the control: the same of the position, with coefficients
        re-estimated and with the effects found.
    nominal_in_place : float or None
        As ``nominal``, with the sensor's zero and the input's bias estimated where the simulation leaves them open;
        None where it leaves neither open.
    at_rest : bool
        Whether the output rests in these rows, so that its standard deviation there is that of the noise.
    improved_everywhere : float or None
        As ``improved``, on all rows and over the standard deviation of all.
    of_recording : str
        Which of several recordings those rows are of; empty where there is one.
    """

    nominal: float
    refitted: float
    improved: float
    noise_floor: float
    validation: tuple[float, float]
    chosen: bool = True
    position: tuple[float, float] | None = None
    nominal_in_place: float | None = None
    at_rest: bool = False
    improved_everywhere: float | None = None
    of_recording: str = ""

    @property
    def explains_nothing(self) -> bool:
        """Whether the simulation explains hardly anything, neither of these rows nor of the whole recording."""
        everywhere = self.improved if self.improved_everywhere is None else self.improved_everywhere
        return min(self.improved, everywhere) >= EXPLAINS_NOTHING

    @property
    def carries_over(self) -> bool:
        """Whether these rows are left about as small as the noise in those that were fitted."""
        return self.explains_nothing or not self.improved > CARRIED_OVER * self.noise_floor > 0.0

    @property
    def rows(self) -> str:
        """Which rows those are: their times, and of what."""
        return span(self.validation, "s") + (f" of {self.of_recording}" if self.of_recording else "")

    @property
    def reference(self) -> str:
        """Which standard deviation of the output the errors are over."""
        return "over the whole recording, as it rests in these rows" if self.at_rest else "in these rows"

    @property
    def as_given(self) -> float:
        """What the simulation as given leaves, but for a zero of the sensor of which it says nothing."""
        return self.nominal if self.nominal_in_place is None else self.nominal_in_place

    def to_mapping(self) -> dict[str, Any]:
        """Part of diagnosis.json."""
        position: dict[str, Any] = {}
        if self.position is not None:
            position["position"] = {"nrmse_refitted": self.position[0], "nrmse_improved": self.position[1]}
        return {
            **position,
            "nrmse_nominal": self.nominal,
            **({} if self.nominal_in_place is None else {"nrmse_nominal_in_place": self.nominal_in_place}),
            "nrmse_refitted": self.refitted,
            "nrmse_improved": self.improved,
            "noise_floor": self.noise_floor,
            "reference": "whole-recording" if self.at_rest else "validation",
            "explains_output": not self.explains_nothing,
            "validation": {
                "start": self.validation[0],
                "end": self.validation[1],
                **({"recording": self.of_recording} if self.of_recording else {}),
            },
        }
