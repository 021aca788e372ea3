"""Experiments as compiled code takes them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.chain.hold import driven

if TYPE_CHECKING:
    from camid.identification.experiment import Experiment

Array = NDArray[np.float64]


class Records(NamedTuple):
    """Experiments, concatenated, as compiled code takes them.

    Attributes
    ----------
    signal, output : ndarray, shape (total,)
    used : ndarray of bool, shape (total,)
    offsets : ndarray of int, shape (E + 1,)
        Rows of experiment e: ``offsets[e]`` up to ``offsets[e + 1]``.
    first_order, straddles, early, initial : ndarray of bool, shape (E,)
        First-order hold; window in two intervals; initial state that of the first exposure; initial state unknown.
    period, start, length : ndarray, shape (E,)
        In seconds, see :meth:`camid.chain.acquisition.Acquisition.window`.
    delay : ndarray of int, shape (E,)
    input_bias, sensor_offset : bool
        Whether a constant that is added to all inputs, or to all outputs, is unknown.
    """

    signal: Array
    output: Array
    used: NDArray[np.bool_]
    offsets: NDArray[np.int64]
    first_order: NDArray[np.bool_]
    straddles: NDArray[np.bool_]
    early: NDArray[np.bool_]
    initial: NDArray[np.bool_]
    period: Array
    start: Array
    length: Array
    delay: NDArray[np.int64]
    input_bias: bool
    sensor_offset: bool

    @classmethod
    def of(cls, experiments: Sequence[Experiment]) -> Records:
        """Pack experiments."""
        windows = [e.acquisition.window() for e in experiments]
        inputs = [driven(e.signal, e.acquisition.hold) for e in experiments]
        return cls(
            np.concatenate([signal for signal, _ in inputs], dtype=np.float64),
            np.concatenate([e.position for e in experiments], dtype=np.float64),
            np.concatenate([e.used for e in experiments]),
            np.cumsum([0, *(len(e.output) for e in experiments)]),
            np.array([first_order for _, first_order in inputs]),
            np.array([w[3] for w in windows]),
            np.array([e.free_motion_before_record for e in experiments]),
            np.array([e.estimate_initial_state for e in experiments]),
            np.array([e.acquisition.period for e in experiments]),
            np.array([w[1] for w in windows]),
            np.array([w[2] for w in windows]),
            np.array([w[0] for w in windows]),
            any(e.estimate_bias for e in experiments),
            any(e.estimate_offset for e in experiments),
        )

    def linear_unknowns(self, order: int) -> int:
        """How many numbers beside the coefficients are fitted: initial polynomials, bias and offset."""
        return order * int(self.initial.sum()) + int(self.input_bias) + int(self.sensor_offset)
