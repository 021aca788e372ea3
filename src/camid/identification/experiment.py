"""A recording as identification sees it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.input_log import InputLog

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Experiment:
    """One recording as identification sees it.

    Attributes
    ----------
    signal, output : ndarray, shape (N,)
        Input samples u_k and sensor samples w_k.
    acquisition : Acquisition
    used : ndarray of bool, shape (N,)
        Rows that are fitted; the others are simulated through.
    estimate_initial_state : bool
        False: at rest before the first sample.
    offset : float
        Reading of the sensor at the plant's zero, in units of y; where it is estimated, what is known of it beforehand.
    estimate_offset : bool
        Whether the offset is unknown. One for all experiments of a rig.
    estimate_bias : bool
        Whether an unknown constant is added to the input from the first sample on. One for all experiments of a rig.
    estimate_latency, estimate_skew : bool
        Whether the latency of the sensor, and the rate of its clock, are unknown. One for all experiments of a rig.
    input_log : InputLog, optional
        The input at times of its own; ``signal`` then holds what stands for it in the rows of the frames.
    seen : int, optional
        Number of the column, where a sensor has several.
    weight : float
        Factor that ``output`` holds, so that the noise of all columns is the same.
    same_run_as : int, optional
        Index of the experiment that is the first column of the same run, whose initial state is that of all.
    interpolated : bool
        Whether the output is interpolated between irregular times, so that its noise has a colour of its own.
    """

    signal: Array
    output: Array
    acquisition: Acquisition
    used: NDArray[np.bool_]
    estimate_initial_state: bool = False
    offset: float = 0.0
    estimate_offset: bool = False
    estimate_bias: bool = False
    estimate_latency: bool = False
    estimate_skew: bool = False
    input_log: InputLog | None = None
    seen: int | None = None
    weight: float = 1.0
    same_run_as: int | None = None
    interpolated: bool = False

    @property
    def position(self) -> Array:
        """Output samples counted from the offset that is known, shape (N,)."""
        return self.output if self.offset == 0.0 else self.output - self.offset

    def for_regression(self) -> tuple[Array, Array]:
        """Input and position, shapes (N,), about their means where the offset is unknown, as if beside a constant."""
        if not self.estimate_offset or not self.used.any():
            return self.signal, self.position
        rows = self.used
        driven = bool(np.any(self.signal))
        signal = self.signal - np.mean(self.signal[rows]) if driven else self.signal
        return signal, self.position - np.mean(self.position[rows])

    @property
    def free_motion_before_record(self) -> bool:
        """Whether the unknown initial state is that before the first frame's exposure, or that at the first sample.

        A free decay is the same motion before and after the first sample. Where an input acts that is not recorded
        before it, frames exposed earlier are not fitted, and a state at their time would have lost its fast part since.
        """
        return bool(self.used[: self.acquisition.window()[0]].any())
