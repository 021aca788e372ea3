"""What is known of a recording when an effect is first guessed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction

Array = NDArray[np.float64]

# Start of a recording, in its durations, beyond which a drift from the zero of its clock is a constant.
FAR_FROM_ZERO = 100.0


@dataclass(frozen=True)
class Situation:
    """What is known when an effect is first guessed: the recording and the refitted simulation without the effect.

    Attributes
    ----------
    time, signal, recorded, position, velocity, residual : ndarray, shape (N,)
        Time in seconds, input of the plant, output, simulated output, its derivative by time, recorded minus simulated
        output. In a closed loop the input is what the controller put out, and the residual is of that.
    plant : TransferFunction
    acquisition : Acquisition
    used : ndarray of bool, shape (N,)
        Rows that are fitted; on the others the residual is zero.
    rest : callable, optional
        Of a plant of equations, its states at rest, by name, at an output; None where it rests nowhere.
    controlled : bool
        Whether a controller puts the input out.
    answer : TransferFunction, optional
        What a force at the plant's input does to what the residual is of, where it is not what it does to the position.
    others : ndarray, shape (M,), optional
        Input of the other recordings of the rig, whose levels this one may not have.
    """

    time: Array
    signal: Array
    recorded: Array
    position: Array
    velocity: Array
    residual: Array
    plant: TransferFunction
    acquisition: Acquisition
    used: NDArray[np.bool_]
    rest: Callable[[float], dict[str, float] | None] | None = None
    controlled: bool = False
    answer: TransferFunction | None = None
    others: Array | None = None

    def until(self, rows: int) -> Situation:
        """The begin of the recording, at most so many rows."""
        names = ("time", "signal", "recorded", "position", "velocity", "residual", "used")
        return replace(self, **{name: getattr(self, name)[:rows] for name in names})

    def while_finite(self) -> Situation:
        """The begin of the recording, until the motion runs away, as it may behind the rows that are fitted."""
        ends = np.flatnonzero(~np.isfinite(self.position + self.velocity))
        return self.until(int(ends[0])) if len(ends) else self

    def largest(self, name: str, share: float = 1.0) -> float:
        """The value that a share of the absolute values of a signal does not exceed; 1 for a signal that is zero.

        The input is that of all recordings: what bends it may do so in another one.
        Without input the force that would hold the plant where it moves takes its place.
        """
        values = self.all_signals if name == "signal" else getattr(self, name)
        found = float(np.quantile(np.abs(values), share))
        if name == "signal" and found == 0.0 and self.plant.denominator[-1] != 0.0:
            found = abs(self.plant.denominator[-1] / self.plant.numerator[-1]) * self.largest("position", share)
        return found or 1.0

    @property
    def all_signals(self) -> Array:
        """Input of all recordings of the rig, one behind the other."""
        return self.signal if self.others is None else np.concatenate([self.signal, self.others])

    @property
    def response_to_force(self) -> TransferFunction:
        """From a force at the plant's input to what the residual is of."""
        return self.plant if self.answer is None else self.answer

    @property
    def duration(self) -> float:
        """Seconds."""
        return float(self.time[-1] - self.time[0])

    @property
    def far_from_zero(self) -> str | None:
        """Why drifts, which count from the zero of the time column, cannot be identified; None if they can."""
        if abs(float(self.time[0])) <= FAR_FROM_ZERO * self.duration:
            return None
        return "the time column begins far from zero, where drifts count from: start the time column near zero"
