"""The equation of motion at the recorded positions, linear in the plant's coefficients and in the sizes of forces.

A force that is left out bends the coefficients that are estimated without it, and a simulation beside those leaves the
recorded way. The equation of motion holds at the recorded positions with all of it, and needs no simulation. It yields
a beginning alone, since noise in the derivatives bends it (an equation error; Ljung 1999, section 7.3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction
from camid.effects.recorded_force import CUT_OFFS, FILTER_ORDER, MOST_POLES, MOST_ROWS, TURNED_ROUND
from camid.effects.situation import Situation

Array = NDArray[np.float64]

# Rows at either end that the filter spoils, in its time constants.
SPOILED = 3.0
# Factor within which the plant's gain lies to what was estimated without the force, at high or at low frequencies.
NEAR = 300.0
# Power of a force beside the others, as a share of the largest, below which it is one of them.
SAME_FORCE = 1e-12
# Share of a force beside the others below which nothing is left of it.
LEAST_SHOWN = 1e-3


@dataclass(frozen=True)
class PlantBesideForce:
    """A plant beside a force over its position.

    Attributes
    ----------
    plant : TransferFunction
        Monic, without zeros.
    bias : float
        Constant in units of the input that acts with it.
    """

    plant: TransferFunction
    bias: float


def equations_of_motion(situation: Situation, *, friction: bool = True) -> list[EquationOfMotion]:
    """The equation of motion with each filter; none of a plant that has zeros or too many poles."""
    situation = situation.until(MOST_ROWS)
    monic = situation.plant.monic
    if len(monic.numerator) != 1 or monic.order not in range(1, MOST_POLES + 1):
        return []
    return [each for cut in CUT_OFFS if (each := EquationOfMotion.of(situation, cut, friction)) is not None]


@dataclass(frozen=True)
class EquationOfMotion:
    """The filtered terms of the equation of motion: what the rest of the input is compared with."""

    position: Array
    motion: tuple[Array, Array, Array, Array]
    sections: Array
    inner: slice
    command: Array
    table: Array
    basis: Array
    rest: Array

    @classmethod
    def of(cls, situation: Situation, cut_off: float, friction: bool) -> EquationOfMotion | None:
        """With one filter, and dry friction or none; None where the recording is too short for it."""
        from scipy.signal import butter, sosfiltfilt

        spoiled = int(SPOILED / (0.5 * pi * cut_off)) + 1
        position = situation.recorded
        inner = slice(spoiled, len(position) - spoiled)
        if len(position) < 10 * spoiled:
            return None
        sections = butter(FILTER_ORDER, cut_off, output="sos")
        smooth = sosfiltfilt(sections, np.column_stack([position, situation.signal]), axis=0)
        derivatives = [smooth[:, 0]]
        for _ in range(situation.plant.monic.order):
            derivatives.append(np.gradient(derivatives[-1], situation.acquisition.period))
        slow = TURNED_ROUND * float(np.sqrt(np.mean(derivatives[1] ** 2))) or 1.0
        dry = sosfiltfilt(sections, np.tanh(derivatives[1] / slow)) if friction else np.zeros(len(position))
        # A coefficient that is zero, as that of a plant that integrates, stays so.
        terms = zip(derivatives[::-1], situation.plant.monic.denominator, strict=True)
        columns = [term if coefficient != 0.0 else np.zeros_like(term) for term, coefficient in terms]
        table = np.column_stack([*columns, np.ones(len(position)), dry])[inner]
        basis = np.linalg.qr(table / np.maximum(np.linalg.norm(table, axis=0), 1e-300))[0]
        rest = smooth[inner, 1]
        rest = rest - basis @ (basis.T @ rest)
        motion = situation.time, smooth[:, 0], derivatives[1], situation.signal
        return cls(position, motion, sections, inner, smooth[inner, 1], table, basis, rest)

    def beside(self, arrived: Array) -> EquationOfMotion:
        """The same of what arrives of the command, shape (N,)."""
        filtered = self._filtered(arrived)
        rest = filtered - self.basis @ (self.basis.T @ filtered)
        return replace(self, command=filtered, rest=rest, motion=(*self.motion[:3], arrived))

    @property
    def unexplained(self) -> float:
        """Share of the command's power that the plant without forces leaves."""
        varying = self.command - np.mean(self.command)
        return float(self.rest @ self.rest) / max(float(varying @ varying), 1e-300)

    def _filtered(self, forces: Array) -> Array:
        """Functions of the recorded position, shape (N, k), as the terms of the equation are filtered."""
        from scipy.signal import sosfiltfilt

        return np.asarray(sosfiltfilt(self.sections, forces, axis=0)[self.inner])

    def left_by_sets(self, forces: Array, sets: Sequence[Sequence[int]]) -> list[float]:
        """Share of the rest that each set of some forces over the position, shape (N, k), leaves."""
        forces = self._filtered(forces)
        forces = forces - self.basis @ (self.basis.T @ forces)
        products, seen = forces.T @ forces, forces.T @ self.rest
        power = max(float(self.rest @ self.rest), 1e-300)
        found = []
        for chosen in map(list, sets):
            explained = np.linalg.lstsq(products[np.ix_(chosen, chosen)], seen[chosen], rcond=SAME_FORCE)[0]
            found.append(1.0 - float(seen[chosen] @ explained) / power)
        return found

    def left_by_pairs(self, forces: Array) -> Array:
        """Share of the rest that each two of some forces, shape (N, k), leave together: shape (k, k)."""
        forces = self._filtered(forces)
        forces = forces - self.basis @ (self.basis.T @ forces)
        products, seen = forces.T @ forces, forces.T @ self.rest
        powers = np.diag(products)
        determinant = np.outer(powers, powers) - products**2
        gains = np.outer(seen**2, powers) + np.outer(powers, seen**2) - 2.0 * np.outer(seen, seen) * products
        # Two that are one leave what no pair of others is worse than.
        told = determinant > LEAST_SHOWN * np.outer(powers, powers)
        explained = np.where(told, gains / np.where(told, determinant, 1.0), 0.0)
        return 1.0 - explained / max(float(self.rest @ self.rest), 1e-300)

    def left_by_each(self, forces: Array, beside: Array) -> Array:
        """Share of the rest that each of some forces, shape (N, k), leaves beside others, shape (N, m): shape (k,)."""
        others, forces = self._filtered(beside), self._filtered(forces)
        others = others - self.basis @ (self.basis.T @ others)
        basis = np.linalg.qr(np.hstack([self.basis, others]))[0] if others.shape[1] else self.basis
        rest = self.rest - basis @ (basis.T @ self.rest)
        sizes = np.linalg.norm(forces, axis=0)
        forces = forces - basis @ (basis.T @ forces)
        powers = np.sum(forces**2, axis=0)
        gains = np.where(powers > (LEAST_SHOWN * sizes) ** 2, (rest @ forces) ** 2 / np.maximum(powers, 1e-300), 0.0)
        return (float(rest @ rest) - gains) / max(float(self.rest @ self.rest), 1e-300)

    def left_with_each(self, arrived: Sequence[Array], forces: Array) -> Array:
        """Share of the power of each of some commands, (N,) each, that each of some forces beside it, (N, k), leaves.

        The shape is (commands, k).
        """
        forces = self._filtered(forces)
        sizes = np.linalg.norm(forces, axis=0)
        forces = forces - self.basis @ (self.basis.T @ forces)
        powers = np.sum(forces**2, axis=0)
        shown = powers > (LEAST_SHOWN * sizes) ** 2
        left = np.zeros((len(arrived), forces.shape[1]))
        for row, command in zip(left, arrived, strict=True):
            bent = self.beside(command)
            gains = np.where(shown, (bent.rest @ forces) ** 2 / np.maximum(powers, 1e-300), 0.0)
            row[:] = bent.unexplained * (1.0 - gains / max(float(bent.rest @ bent.rest), 1e-300))
        return left

    def solved(self, forces: Array, given: TransferFunction) -> tuple[TransferFunction, float, Array] | None:
        """Plant, bias and the sizes of the forces, shape (k,), all together; None where the plant's gain is none."""
        table = np.hstack([self.table, self._filtered(forces)])
        sizes = np.maximum(np.linalg.norm(table, axis=0), 1e-300)
        terms = np.linalg.lstsq(table / sizes, self.command, rcond=1e-10)[0] / sizes
        order = given.order
        if terms[0] == 0.0:
            return None
        gain = float(1.0 / terms[0])
        terms[1 : order + 1][np.array(given.denominator[1:]) == 0.0] = 0.0
        plant = TransferFunction((gain,), (1.0, *(float(gain * term) for term in terms[1 : order + 1])))
        ratios = gain / given.numerator[0], _slow_gain(plant) / _slow_gain(given)
        # What was estimated without the force may even have the other sign.
        if not any(1.0 / NEAR < abs(ratio) < NEAR for ratio in ratios):
            return None
        return plant, -float(terms[order + 1]), terms[order + 3 :]


def _slow_gain(plant: TransferFunction) -> float:
    """Gain at the lowest frequencies, but for integrations: what stays where a pole has run away to a high rate."""
    return plant.numerator[0] / next((a for a in reversed(plant.denominator) if a != 0.0), 1.0)
