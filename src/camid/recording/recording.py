"""A recording: columns in SI units on a regular grid."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.input_log import InputLog
from camid.recording.two_rates import rows_before

Array = NDArray[np.float64]

# Distance of the rows from the grid, in periods (root mean square), from which an interpolation colours their noise:
# that of a spline is 1 - 3 d² of it at a distance d, and goes into the neighbours.
COLOURING = 0.1


@dataclass(frozen=True)
class Recording:
    """A recording on a regular grid, in SI units.

    Attributes
    ----------
    time : ndarray, shape (N,)
        Seconds, strictly increasing: the recorded times where they are regular, else the grid.
    columns : dict of str to ndarray, each of shape (N,)
        The columns that were asked for. Outputs are interpolated where the times were irregular.
    period : float
        Seconds: the median step, or the slope of the times where rounding or jitter makes the steps differ.
    source : str
        Name for messages.
    period_uncertainty : float
        Seconds by which rounded or irregular times may have falsified the period; 0 where the steps are equal.
    missing : ndarray of bool, shape (N,)
        RowNumbers without recorded output near, which are not compared.
    recorded_time : ndarray, shape (M,)
        Seconds: the times in the file.
    recorded_columns : dict of str to ndarray, each of shape (M,)
        The rows of the file.
    experiment : str or None
        What tells this recording from the others in its file.
    logs : dict of str to InputLog
        The inputs at times of their own, where the frames have theirs; the columns then hold what stands for them in
        the rows of the frames.
    warnings : tuple of str
        What was done to the rows, one sentence each.
    units : dict of str to str
        What the cells of columns are in, as the simulation declares it or the header of the file says.
    """

    time: Array
    columns: dict[str, Array]
    period: float
    source: str
    period_uncertainty: float = 0.0
    missing: NDArray[np.bool_] = field(default=None)  # type: ignore[arg-type]
    recorded_time: Array = field(default=None)  # type: ignore[arg-type]
    recorded_columns: dict[str, Array] = field(default=None)  # type: ignore[arg-type]
    experiment: str | None = None
    logs: dict[str, InputLog] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    units: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, value in (
            ("missing", np.zeros(len(self.time), bool)),
            ("recorded_time", self.time),
            ("recorded_columns", self.columns),
        ):
            if getattr(self, name) is None:
                object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.time)

    @property
    def interpolated(self) -> bool:
        """Whether outputs are interpolated so far from the recorded times that it colours their noise."""
        if self.recorded_time is self.time:
            return False
        nearest = np.round((self.recorded_time - self.time[0]) / self.period)
        distance = (self.recorded_time - self.time[0]) / self.period - nearest
        return bool(np.sqrt(np.mean(distance**2)) > COLOURING)

    def from_start_of_log(self) -> Recording:
        """The recording with rows without output back to where the log of its inputs begins; itself without a log."""
        if not self.logs:
            return self
        begin = min(float(log.time[0]) for log in self.logs.values())
        count = rows_before(float(self.time[0]), begin, self.period)
        time = np.concatenate([self.time[0] - self.period * np.arange(count, 0, -1), self.time])
        columns = {
            name: self.logs[name].samples(time, self.period)
            if name in self.logs
            else np.pad(values, (count, 0), mode="reflect")
            for name, values in self.columns.items()
        }
        missing = np.concatenate([np.ones(count, bool), self.missing])
        return replace(self, time=time, columns=columns, missing=missing)
