"""What becomes of input and reading where both are logged: rows that do not belong together, and wires that couple."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from camid.chain.acquisition import Acquisition
from camid.effects.base import Array, Effect
from camid.effects.extent import Extent
from camid.effects.noise import noise_beside_motion
from camid.effects.parameter import Parameter
from camid.effects.plant_force import GUESS
from camid.effects.sensor import Delay
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

if TYPE_CHECKING:
    from camid.chain.motion import Motion

# Least and most periods by which a command is logged late: less is an exposure or a hold of the input, and more
# another recording.
FEWEST_PERIODS, MOST_PERIODS = 0.6, 20.0
# Noise of a command over its spread from which it may be a controller's: what an autoregression of so many rows, fitted
# to so many, does not predict of it (at so many places of a long one). Commands of few levels are no controller's.
NOISY_COMMAND = 0.01
REGRESSION_ROWS, WINDOW_ROWS, MOST_WINDOWS = 64, 512, 16
FEW_LEVELS = 16
# Prior odds beside linear dynamics that do nearly the same: most logs are right, and most wires are screened.
ODDS = 1.0 / 3.0


def noise_of_command(signal: Array) -> float:
    """Standard deviation of what nothing before tells of a command; zero where it has few levels.

    The smaller of what third differences say, which steps do not disturb, and of what an autoregression leaves, which
    tells a sweep and some tens of sines.

    Parameters
    ----------
    signal : ndarray, shape (N,)
        Input in its units.

    Returns
    -------
    float
        In the same units.
    """
    if len(np.unique(signal)) <= FEW_LEVELS:
        return 0.0
    left = noise_beside_motion(signal)
    if len(signal) < WINDOW_ROWS or left <= NOISY_COMMAND * float(np.std(signal)):
        return left
    rows = np.lib.stride_tricks.sliding_window_view(signal, REGRESSION_ROWS + 1)
    windows = np.array_split(rows, max(len(rows) // WINDOW_ROWS, 1))
    residuals = []
    for window in windows[:: max(len(windows) // MOST_WINDOWS, 1)]:
        before, now = window[:, :-1], window[:, -1]
        residuals.append(now - before @ np.linalg.lstsq(before, now)[0])
    return min(left, 1.4826 * float(np.median(np.abs(np.concatenate(residuals)))))


class LateCommand(Effect):
    """A log whose rows hold a command of some rows before, so that the output answers it early.

    A reading that is stamped late looks the same. No delay of a plant or of a sensor does so.
    """

    identifier = "late-command"
    place = "sensor"
    title = "Command that is logged late"
    drawn_against = "time shift"
    equation = r"w_k = w(t_k + \theta)"
    reference = "Ljung (1999), System Identification, 2nd ed., section 4.2 (a delay n_k, here below zero)"
    parameters = (Parameter("lead", "s", "time θ by which the output is ahead of the logged command", 0.0),)
    linear_dynamics = True
    separated_by = (SeparatingExperiment.FASTER_CAMERA,)
    prior_odds = ODDS
    strength = "lead"

    def bounds(self, acquisition: Acquisition) -> list[tuple[float, float]]:
        """About a row at least: what is ahead by half of one is sampled or held otherwise than is said."""
        return [(FEWEST_PERIODS * acquisition.period, MOST_PERIODS * acquisition.period)]

    def windows(self, motion: Motion, start: Array, end: Array) -> tuple[Array, Array]:
        """Exposures at the times of the command's rows."""
        lead = self.values["lead"]
        return start + lead, end + lead

    def ahead(self, time: Array) -> float:
        """The lead itself."""
        return float(self.values["lead"])

    def is_plausible(self, extent: Extent) -> bool:
        """Only the difference of a lead and a delay shows."""
        return Delay.identifier not in extent.beside

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """A few rows."""
        for rows in (1.0, 2.0, 4.0):
            yield cls(lead=rows * situation.acquisition.period)

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """Without input there is nothing that is early, and in a loop the reading comes before the command."""
        if situation.controlled:
            return "in a declared loop the command follows from the reading"
        return None if np.any(situation.all_signals) else "without input nothing is logged late"


class InputPickup(Effect):
    """A share of the command in the reading: pick-up of a drive in the sensor's wire, or a mount that yields to it."""

    identifier = "input-pickup"
    place = "sensor"
    title = "Pick-up of the input in the reading"
    drawn_against = "input"
    equation = r"w_k = w + c\,u_k"
    reference = "Ott (2009), Electromagnetic Compatibility Engineering, chapter 2"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("coefficient", "y/u", "reading c for a unit of the input"),
    )
    linear_dynamics = True
    separated_by = (SeparatingExperiment.HELD_POSITIONS,)
    prior_odds = ODDS
    strength = "coefficient"

    def picked_up(self, signal: Array) -> Array | None:
        """In proportion to the command of the same row."""
        return np.asarray(self.values["coefficient"] * signal)

    def is_plausible(self, extent: Extent) -> bool:
        """Whether no more is picked up than is read in all: what a plant then has to take back is no pick-up."""
        if isfinite(extent.signal) and abs(float(self.values["coefficient"])) * extent.signal > extent.span:
            return False
        return super().is_plausible(extent)

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """Small: the effect is proportional to it."""
        coefficient = GUESS * situation.largest("position") / situation.largest("signal")
        for law in (InputPickup, InputPickupOfRowBefore):
            yield law(coefficient=coefficient)

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """A controller's input is no reading."""
        if situation.controlled:
            return "in a declared loop the controller reads the position itself"
        # A controller that answers the noise of a reading puts a share of it into the command: the same, the other way.
        if noise_of_command(situation.signal) > NOISY_COMMAND * float(np.std(situation.signal)):
            return "the command is as noisy as one that a controller puts out, which answers the noise of the reading"
        return None if np.any(situation.all_signals) else "without input nothing is picked up"


class InputPickupOfRowBefore(InputPickup):
    """The same of a sensor that is read before the next command is put out."""

    equation = r"w_k = w + c\,u_{k-1}"
    parameters = (
        *InputPickup.parameters,
        Parameter("row", "", "which command is picked up", choices=("before",), default="before"),
    )

    def picked_up(self, signal: Array) -> Array | None:
        """In proportion to the command of the row before; none before the first."""
        return np.asarray(self.values["coefficient"] * np.concatenate([[0.0], signal[:-1]]))
