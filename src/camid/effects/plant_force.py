"""What forces at the input of the plant have in common: their unit, that of u, and their sign."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar

import numpy as np

from camid.chain.plant import TransferFunction
from camid.effects.base import Array, Effect
from camid.effects.residual_regression import sampled
from camid.effects.situation import Situation

# Force of a first guess as a share of the largest input: small, but above the rounding of the integrator.
GUESS = 0.02
# Times, values of position or velocity, and inputs at which a force over the other one alone is the same.
TRIALS = ((0.0, 0.3, 0.0), (1.7, -1.1, 0.8), (4.1, 2.3, -1.9))
# Smallest factor of a change of size; the effect is then below any noise.
LEAST_FACTOR = 1e-9


def static_stiffness(plant: TransferFunction) -> float:
    """Force in units of u that holds a unit of y at rest, A(0)/B(0); 0 for an integrating plant."""
    return plant.denominator[-1] / plant.numerator[-1] if plant.numerator[-1] != 0.0 else 0.0


def static_damping(plant: TransferFunction) -> float:
    """Force in units of u for a unit of y per second: the second coefficient of A/B about s = 0."""
    numerator, denominator = plant.numerator, plant.denominator
    if numerator[-1] == 0.0 or len(denominator) < 2:
        return 0.0
    slope = numerator[-2] / numerator[-1] if len(numerator) > 1 else 0.0
    return (denominator[-2] - denominator[-1] * slope) / numerator[-1]


def mobility(plant: TransferFunction) -> float:
    """Acceleration in units of y/s² for a unit of force, for a plant with two poles more than zeros; else 0."""
    monic = plant.monic
    return abs(monic.numerator[0]) if len(monic.denominator) - len(monic.numerator) == 2 else 0.0


def motion_sign(plant: TransferFunction) -> float:
    """1 where a positive force moves the plant to positive y at first, -1 where the sign of y or u is the other way."""
    return 1.0 if plant.monic.numerator[0] > 0.0 else -1.0


def static_force(effect: Effect, over: str, at: Array, plant: TransferFunction) -> Array:
    """Force of an effect over position or velocity alone, in the shape of ``at``; zero where it is no such force.

    Parameters
    ----------
    effect : Effect
    over : str
        ``position`` or ``velocity``.
    at : ndarray, shape (N,)
    plant : TransferFunction
    """
    nothing = np.zeros(len(at))
    if effect.force is None or effect.friction_level is not None or effect.memory_after is not None:
        return nothing
    values = effect.force_values(plant)
    rows = []
    for time, other, signal in TRIALS:
        along = [(x, other) if over == "position" else (other, x) for x in at.tolist()]
        rows.append([effect.force.at(time, *motion, signal, 0.0, values=values) for motion in along])
    found = np.array(rows)
    return found[0] if np.all(np.isfinite(found)) and np.all(found == found[0]) else nothing


def force_along(effect: Effect, plant: TransferFunction, motion: Sequence[Array]) -> Array:
    """What a force adds to the plant's input along a motion, shape (N,).

    Parameters
    ----------
    effect : Effect
        With a force or a level of friction.
    plant : TransferFunction
    motion : sequence of ndarray, each of shape (N,)
        Time in seconds, position, velocity and input.
    """
    values = effect.force_values(plant)
    time, position, velocity, signal = (part.tolist() for part in motion)
    force = np.zeros(len(time))
    if effect.force is not None:
        memory = [0.0] * len(time)
        if effect.memory_after is not None:
            held = 0.0
            ways, elapsed = np.diff(motion[1], prepend=motion[1][0]), np.diff(motion[0], prepend=motion[0][0])
            speeds = np.divide(ways, elapsed, out=np.zeros(len(ways)), where=elapsed > 0.0).tolist()
            for k, way in enumerate(ways.tolist()):
                held = effect.memory_after.at(time[k], way, speeds[k], 0.0, held, values=values)
                memory[k] = held
        force -= effect.force.along(time, position, velocity, signal, memory, values=values)
    if effect.friction_level is not None:
        speed = np.abs(motion[2]).tolist()
        level = effect.friction_level.along(time, position, speed, signal, [0.0] * len(time), values=values)
        force -= motion_sign(plant) * np.sign(motion[2]) * np.maximum(level, 0.0)
    return force


def without_force(situation: Situation, effect: Effect) -> Situation:
    """A situation with what the force of an effect of its model does put back into the residual, to first order."""
    motion = situation.time, situation.position, situation.velocity, situation.signal
    force = force_along(effect, situation.plant, motion)
    done = sampled(situation.response_to_force, force, situation.acquisition)
    return replace(situation, residual=situation.residual + situation.used * done)


class AgainstMotion(Effect):
    """A force that acts against the motion whatever the signs of input and output: its first value is signed."""

    def force_values(self, plant: TransferFunction) -> list[float]:
        """The parameters, the size of the force with the sign of the plant's gain."""
        return [motion_sign(plant) * p if i == self.signed else p for i, p in enumerate(self.vector)]

    signed: ClassVar[int] = 0
