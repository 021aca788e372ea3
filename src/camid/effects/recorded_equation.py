"""A plant beside a force that repeats along the way, both from the plant's equation at the recorded positions.

Cogging bends the coefficients that are estimated without it, and a simulation beside those leaves the recorded way, so
that no fit finds where the poles of the motor are: worst of all in a loop around a plant that integrates. The equation
of motion holds at the recorded positions with all of it, is linear in all but the period, and needs no simulation. It
yields a beginning alone, since noise in the derivatives bends it (an equation error; Ljung 1999, section 7.3).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction
from camid.effects.recorded_force import CUT_OFFS, FILTER_ORDER, MOST_POLES, MOST_ROWS, TURNED_ROUND
from camid.effects.situation import Situation

Array = NDArray[np.float64]

# Periods around a guess that are looked at, as shares of it.
PERIODS = np.linspace(0.93, 1.07, 57)
# Rows at either end that the filter spoils, in its time constants.
SPOILED = 3.0
# A harmonic leaves less than this share of what is left without it.
MOST_LEFT_BY_HARMONIC = 0.7
# Factor within which the plant's gain lies to what was estimated without the force.
NEAR = 300.0


@dataclass(frozen=True)
class PlantBesideWave:
    """A plant and the waves of its position that oppose its input.

    Attributes
    ----------
    plant : TransferFunction
        Monic, without zeros.
    bias : float
        Constant in units of the input that acts with it.
    period : float
        In units of the output.
    waves : tuple of (float, float)
        Amplitude in units of the input and phase at the position zero: of the period itself, and of a harmonic.
    order : int
        Which harmonic that is; 1 where there is none.
    """

    plant: TransferFunction
    bias: float
    period: float
    waves: tuple[tuple[float, float], ...]
    order: int


def plant_beside_wave(situation: Situation, period: float, orders: tuple[int, ...]) -> PlantBesideWave | None:
    """The plant and the wave of about a period, with the harmonic that explains more, that fit the recorded motion.

    Parameters
    ----------
    situation : Situation
    period : float
        In units of the output.
    orders : tuple of int
        Harmonics that may be there.

    Returns
    -------
    PlantBesideWave or None
        None where the plant has zeros or too many poles, or the equation yields none of about its gain.
    """
    situation = situation.until(MOST_ROWS)
    monic = situation.plant.monic
    if len(monic.numerator) != 1 or monic.order not in range(1, MOST_POLES + 1):
        return None
    equations = [each for cut in CUT_OFFS if (each := _Equation.of(situation, cut)) is not None]
    tried = [
        (equation.left(period * share, harmonic), index, period * share, harmonic)
        for index, equation in enumerate(equations)
        for share in PERIODS
        for harmonic in (1, *orders)
    ]
    plain = min((each for each in tried if each[3] == 1), default=None)
    if plain is None:
        return None
    finer = min((each for each in tried if each[3] > 1), default=plain)
    _, index, length, harmonic = finer if finer[0] < MOST_LEFT_BY_HARMONIC * plain[0] else plain
    return equations[index].solved(length, harmonic, monic)


@dataclass(frozen=True)
class _Equation:
    """The filtered terms of the equation of motion: what the rest of the input is compared with."""

    position: Array
    sections: Array
    inner: slice
    command: Array
    table: Array
    basis: Array
    rest: Array

    @classmethod
    def of(cls, situation: Situation, cut_off: float) -> _Equation | None:
        """With one filter; None where the recording is too short for it."""
        from scipy.signal import butter, sosfiltfilt

        spoiled = int(SPOILED / (0.5 * pi * cut_off)) + 1
        position = situation.recorded
        inner = slice(spoiled, len(position) - spoiled)
        if len(position) < 10 * spoiled:
            return None
        sections = butter(FILTER_ORDER, cut_off, output="sos")
        command = situation.signal if situation.command is None else situation.command
        smooth = sosfiltfilt(sections, np.column_stack([position, command]), axis=0)
        derivatives = [smooth[:, 0]]
        for _ in range(situation.plant.monic.order):
            derivatives.append(np.gradient(derivatives[-1], situation.acquisition.period))
        slow = TURNED_ROUND * float(np.sqrt(np.mean(derivatives[1] ** 2))) or 1.0
        friction = sosfiltfilt(sections, np.tanh(derivatives[1] / slow))
        # A coefficient that is zero, as that of a plant that integrates, stays so.
        terms = zip(derivatives[::-1], situation.plant.monic.denominator, strict=True)
        columns = [term if coefficient != 0.0 else np.zeros_like(term) for term, coefficient in terms]
        table = np.column_stack([*columns, np.ones(len(position)), friction])[inner]
        basis = np.linalg.qr(table / np.maximum(np.linalg.norm(table, axis=0), 1e-300))[0]
        rest = smooth[inner, 1]
        rest = rest - basis @ (basis.T @ rest)
        return cls(position, sections, inner, smooth[inner, 1], table, basis, rest)

    def waves(self, period: float, harmonic: int) -> Array:
        """Filtered sines and cosines of the recorded position, shape (N, 2) or (N, 4)."""
        from scipy.signal import sosfiltfilt

        angles = 2.0 * pi / period * np.outer(self.position, [1] if harmonic == 1 else [1, harmonic])
        pairs = np.stack([np.sin(angles), np.cos(angles)], axis=-1).reshape(len(angles), -1)
        return np.asarray(sosfiltfilt(self.sections, pairs, axis=0)[self.inner])

    def left(self, period: float, harmonic: int) -> float:
        """Share of the rest that waves of a period leave."""
        waves = self.waves(period, harmonic)
        waves = waves - self.basis @ (self.basis.T @ waves)
        explained = np.linalg.lstsq(waves, self.rest, rcond=None)[0]
        left = self.rest - waves @ explained
        return float(left @ left) / max(float(self.rest @ self.rest), 1e-300)

    def solved(self, period: float, harmonic: int, given: TransferFunction) -> PlantBesideWave | None:
        """All terms together; None where the plant's gain is none."""
        table = np.hstack([self.table, self.waves(period, harmonic)])
        sizes = np.maximum(np.linalg.norm(table, axis=0), 1e-300)
        terms = np.linalg.lstsq(table / sizes, self.command, rcond=1e-10)[0] / sizes
        order = given.order
        gain = 1.0 / terms[0] if terms[0] != 0.0 else 0.0
        if not 1.0 / NEAR < gain / given.numerator[0] < NEAR:
            return None
        plant = TransferFunction((float(gain),), (1.0, *(float(gain * term) for term in terms[1 : order + 1])))
        pairs = terms[order + 3 :].reshape(-1, 2)
        waves = tuple((float(np.hypot(*pair)), float(np.arctan2(pair[1], pair[0]))) for pair in pairs)
        return PlantBesideWave(plant, -float(terms[order + 1]), period, waves, harmonic)
