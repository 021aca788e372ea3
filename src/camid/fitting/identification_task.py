"""What an identification is asked for, the same for every kind of plant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.recording.recording import Recording
from camid.simulation.model import Simulation


@dataclass(frozen=True)
class IdentificationTask:
    """What an identification is asked for.

    Attributes
    ----------
    believed : Simulation
    recordings : list of Recording
        Of one rig.
    held_out : list of ndarray of bool
        Validation rows.
    nominal : TransferFunction, optional
        Plant to start from.
    method : str
        See :func:`camid.identification.estimate.estimate`; a kind of plant may have its own.
    progress : callable, optional
        Called with a sentence about the current step.
    effects : tuple of Effect
        Those that the simulation declares; they are re-estimated with the plant, but for those on the noise.
    """

    believed: Simulation
    recordings: list[Recording]
    held_out: list[NDArray[np.bool_]]
    nominal: TransferFunction | None
    method: str
    progress: Callable[[str], None] | None
    effects: tuple[Effect, ...] = ()
