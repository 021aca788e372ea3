"""What a rig allows an experiment to do."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError
from camid.experiment_design.columns import AS_SIMULATED, Columns

Array = NDArray[np.float64]

# Digits of an input that is written, and simulated as it is written.
DIGITS = 6
FEWEST_ROWS = 100
MOST_ROWS = 50_000


@dataclass(frozen=True)
class Limits:
    """What a rig allows, in the units of its columns and SI.

    Attributes
    ----------
    low, high : float
        Least and largest input.
    rate : float
        Largest change of the input in a second; infinite where nothing limits it.
    duration : float
        Seconds.
    periods : tuple of float
        Periods of the frames in seconds that the camera can have.
    exposures : tuple of float
        Exposures in seconds that it can have; empty: as the simulation declares.
    travel : tuple of float or None
        Least and largest position, in units of the output; None where nothing limits it.
    positions : tuple of float
        Positions from which the rig can be released at rest instead of where it rests.
    columns : Columns
        In whose units people are told what is wrong.
    where : str or None
        What the limits are for.

    Raises
    ------
    InputError
        If they cannot be kept, or leave nothing to do.
    """

    low: float
    high: float
    rate: float
    duration: float
    periods: tuple[float, ...]
    exposures: tuple[float, ...] = ()
    travel: tuple[float, float] | None = None
    positions: tuple[float, ...] = ()
    columns: Columns = AS_SIMULATED
    where: str | None = None

    def __post_init__(self) -> None:
        self._refuse_inputs()
        if not (isfinite(self.duration) and self.duration > 0.0):
            raise self._refusal(f"duration {self.duration:g} s", "give a positive number of seconds with --duration")
        if not self.periods or not all(isfinite(p) and p > 0.0 for p in self.periods):
            raise self._refusal("no frame rate", "give one in frames per second with --frame-rate")
        self._refuse_lengths()
        self._refuse_positions()
        for exposure in self.exposures:
            if not 0.0 < exposure <= max(self.periods):
                raise self._refusal(f"exposure {exposure:g} s", "it is positive, and no longer than a frame")

    def _refusal(self, problem: str, hint: str) -> InputError:
        return InputError(problem, where=self.where, hint=hint)

    def _refuse_inputs(self) -> None:
        if not (isfinite(self.low) and isfinite(self.high) and self.low <= self.high):
            shown = self.columns.input_range(self.low, self.high)
            raise self._refusal(f"amplitude {shown}", "give a least and a largest input with --amplitude")
        if self.low == self.high and not self.positions:
            raise self._refusal(
                f"the input can only be {self.columns.input_text(self.low)}",
                "give two limits with --amplitude, or a position to release the rig from with --initial-position",
            )
        if not self.rate > 0.0:
            shown = self.columns.input_text(self.rate, per_second=True)
            raise self._refusal(f"rate {shown}", "give the largest change of the input in a second, above zero")

    def _refuse_positions(self) -> None:
        if self.travel is None:
            return
        allowed = self.columns.output_range(*self.travel)
        if not self.travel[0] < self.travel[1]:
            raise self._refusal(f"travel {allowed}", "give the least position first")
        for position in self.positions:
            if not self.travel[0] <= position <= self.travel[1]:
                raise self._refusal(
                    f"the initial position {self.columns.output_text(position)} lies outside of the travel",
                    f"it lies within {allowed}, or allow more with --travel",
                )

    def _refuse_lengths(self) -> None:
        for period in self.periods:
            rows = self.rows(period)
            if rows < FEWEST_ROWS:
                raise self._refusal(
                    f"{self.duration:g} s at {1.0 / period:g} frames per second are {rows} rows",
                    f"a diagnosis needs {FEWEST_ROWS}: allow at least {FEWEST_ROWS * period:g} s",
                )
            if rows > MOST_ROWS:
                raise self._refusal(
                    f"{self.duration:g} s at {1.0 / period:g} frames per second are {rows} rows",
                    f"at most {MOST_ROWS}: name a shorter duration",
                )

    def rows(self, period: float) -> int:
        """Rows of an experiment."""
        return round(self.duration / period)

    @property
    def settings(self) -> list[tuple[float, float | None]]:
        """Periods with the exposures that are possible at each; None: as declared."""
        found: list[tuple[float, float | None]] = []
        for period in self.periods:
            exposures = [e for e in self.exposures if e <= period * (1.0 + 1e-9)]
            found += [(period, e) for e in exposures] or [(period, None)]
        return found

    def kept(self, signal: Array, period: float) -> Array:
        """A signal between minus one and one, shape (N,), brought into the range of the input and slowed to its rate.

        Zero becomes what is nearest to zero in the middle of the range: rigs that push and pull rest at no input.
        """
        centre, half = 0.5 * (self.low + self.high), 0.5 * (self.high - self.low)
        return self.slowed(np.clip(centre + half * signal, self.low, self.high), period)

    def slowed(self, signal: Array, period: float) -> Array:
        """A signal that changes no faster than the rate allows, from no input at first, with the digits of a file."""
        most = self.rate * period
        result = np.asarray(signal, float)
        if isfinite(most) and np.max(np.abs(np.diff(result, prepend=0.0)), initial=0.0) > most:
            values, last = np.empty(len(result)), 0.0
            for k, wanted in enumerate(result.tolist()):
                last = min(max(wanted, last - most), last + most)
                values[k] = last
            result = values
        return self.written(result)

    def written(self, signal: Array) -> Array:
        """A signal as its file has it."""
        size = max(abs(self.low), abs(self.high), 1e-300)
        decimals = DIGITS - 1 - int(np.floor(np.log10(size)))
        # Towards zero: what is rounded up would leave the range.
        factor = 10.0**decimals
        whole = np.trunc(signal * factor + np.sign(signal) * 1e-6)
        return np.asarray((whole + 0.0) / factor)  # what is rounded to zero has no sign
