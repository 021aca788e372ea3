"""A recording as identification sees it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition

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
    """

    signal: Array
    output: Array
    acquisition: Acquisition
    used: NDArray[np.bool_]
    estimate_initial_state: bool = False

    @property
    def free_motion_before_record(self) -> bool:
        """Whether the unknown initial state is that before the first frame's exposure, or that at the first sample.

        A free decay is the same motion before and after the first sample. Where an input acts that is not recorded
        before it, frames exposed earlier are not fitted, and a state at their time would have lost its fast part since.
        """
        return bool(self.used[: self.acquisition.window()[0]].any())
