"""A state observer: what pulls a simulated motion towards the recorded one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction

Array = NDArray[np.float64]

# Poles that a plant has more than zeros where a force at its input is an acceleration.
RELATIVE_DEGREE = 2


def acceleration_of(plant: TransferFunction) -> float | None:
    """By a force of one at a plant's input, in units of y per unit of u and s²; None where the force is not one."""
    if len(plant.denominator) - len(plant.numerator) != RELATIVE_DEGREE:
        return None
    return float(plant.numerator[0] / plant.denominator[0])


@dataclass(frozen=True)
class Observer:
    """An acceleration 2 w ė_k + w² e_k of the simulated motion, held until the next sample, for e_k = w_k − ŵ_k.

    The frames w_k are those that were recorded, and ŵ_k what the camera shows of the simulated motion: a true model is
    not pulled at all, but by the noise. A plant that only its controller keeps from running away leaves any recording
    soon when it is simulated with the recorded input alone, as a small error grows exponentially; with an observer
    (Luenberger's) it does not.

    Attributes
    ----------
    rate : float
        w in rad/s: an error of a double integrator falls with two poles at -w.
    gain : float
        Acceleration in units of y per unit of u and s² that the pull is divided by. It stays as it is when a plant is
        re-estimated: were the pull of a plant with a small gain larger, no input at all would suit any recording.

    References
    ----------
    Ljung (1999), System Identification, 2nd ed., section 7.4: predictors of unstable systems. Luenberger (1971), IEEE
    Trans. Autom. Control 16, 596-602.
    """

    rate: float
    gain: float

    @property
    def position_gain(self) -> float:
        """Of the error, in units of u per unit of y."""
        return self.rate**2 / self.gain

    @property
    def velocity_gain(self) -> float:
        """Of its rate, in units of u per unit of y and second."""
        return 2.0 * self.rate / self.gain

    def holds(self, plant: TransferFunction) -> bool:
        """Whether a plant no longer runs away from what it is pulled towards."""
        return bool(np.max(np.roots(self.answer_to_force(plant).denominator).real) < 0.0)

    def answer_to_force(self, plant: TransferFunction) -> TransferFunction:
        """What a force at the plant's input does to the position, in continuous time: G / (1 + K G)."""
        loop = np.polymul(np.array([self.velocity_gain, self.position_gain]), plant.numerator)
        return TransferFunction(plant.numerator, tuple(np.polyadd(plant.denominator, loop)))

    def to_mapping(self) -> dict[str, float]:
        """Part of a simulation file."""
        return {"rate": self.rate, "gain": self.gain}


@dataclass(frozen=True)
class Pull:
    """An observer with the frames that it pulls towards.

    Attributes
    ----------
    observer : Observer
    frames : ndarray, shape (N,)
        In units of y from the plant's zero; nan where it does not pull.
    acquisition : Acquisition
        How the camera took them.
    """

    observer: Observer
    frames: Array
    acquisition: Acquisition

    @property
    def exposure(self) -> float:
        """In seconds; zero of an instant sensor."""
        return self.acquisition.window()[2]
