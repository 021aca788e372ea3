"""The controller of a closed loop: proportional in the position, proportional in the velocity, limited."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Controller:
    """u_k = clip(k_v (k_p (r_k − y) − ẏ), ±limit), held until the next sample.

    Position and velocity are those of the plant at the sample: the controller's own sensor is not the camera.

    Attributes
    ----------
    reference : str
        Column of r, in units of y.
    position_gain : float
        k_p in 1/s.
    velocity_gain : float
        k_v in units of u per unit of y and second.
    limit : float
        Largest magnitude of u; infinite without one.
    """

    reference: str
    position_gain: float
    velocity_gain: float
    limit: float = inf

    def answer_to_force(self, plant: TransferFunction) -> TransferFunction:
        """What the control adds for a force at the plant's input, in continuous time and without the limit.

        With K = k_v (k_p + s) it is -K G / (1 + K G), for G the plant: the control makes up for the force.
        """
        gains = np.array([self.velocity_gain, self.velocity_gain * self.position_gain])
        loop = np.polymul(gains, plant.numerator)
        return TransferFunction(tuple(-loop), tuple(np.polyadd(plant.denominator, loop)))

    def to_mapping(self) -> dict[str, str | float]:
        """Part of a simulation file."""
        content: dict[str, str | float] = {
            "reference": self.reference,
            "position_gain": self.position_gain,
            "velocity_gain": self.velocity_gain,
        }
        if self.limit < inf:
            content["limit"] = self.limit
        return content


@dataclass(frozen=True)
class Loop:
    """A controller with the reference that it followed.

    Attributes
    ----------
    controller : Controller
    reference : ndarray, shape (N,)
        r_k in units of y.
    """

    controller: Controller
    reference: Array
