"""A plant beside a force over the position, both from the plant's equation at the recorded positions.

Cogging, or a stop that holds a plant which integrates, bends the coefficients that are estimated without it, so that no
fit finds where the poles of the motor or the stop are. The equation is linear in all but the period or the place.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from camid.effects.equation_of_motion import EquationOfMotion, PlantBesideForce, equations_of_motion
from camid.effects.situation import Situation

Array = NDArray[np.float64]

# Periods around a guess that are looked at, as shares of it.
PERIODS = np.linspace(0.93, 1.07, 57)
# A harmonic leaves less than this share of what is left without it.
MOST_LEFT_BY_HARMONIC = 0.7
# Places of a stop that are looked at, as shares of the way from either end, and what a stop that is worth a beginning
# leaves of what is left without it.
PLACES = np.linspace(0.0, 0.3, 16)[1:]
MOST_LEFT_BY_STOP = 0.7


@dataclass(frozen=True)
class PlantBesideWave(PlantBesideForce):
    """A plant and the waves of its position that oppose its input.

    Attributes
    ----------
    period : float
        In units of the output.
    waves : tuple of (float, float)
        Amplitude in units of the input and phase at the position zero: of the period itself, and of a harmonic.
    order : int
        Which harmonic that is; 1 where there is none.
    """

    period: float
    waves: tuple[tuple[float, float], ...]
    order: int


@dataclass(frozen=True)
class PlantBesideStops(PlantBesideForce):
    """A plant and the stop that holds it, or one at either end of the way.

    Attributes
    ----------
    stops : tuple of (float, float)
        Where each contact begins, in units of the output, and its stiffness in units of the input by those of the
        output.
    """

    stops: tuple[tuple[float, float], ...]


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
    equations = equations_of_motion(situation)
    # Of sines and cosines of the period and of each harmonic: those of the period alone, and with each other one.
    multiples = (1, *orders)
    sets = [sorted({0, 1, 2 * i, 2 * i + 1}) for i in range(len(multiples))]
    tried = [
        (left, index, period * share, harmonic)
        for index, equation in enumerate(equations)
        for share in PERIODS
        for left, harmonic in zip(
            equation.left_by_sets(_waves(equation.position, period * share, multiples), sets), multiples, strict=True
        )
    ]
    plain = min((each for each in tried if each[3] == 1), default=None)
    if plain is None:
        return None
    finer = min((each for each in tried if each[3] > 1), default=plain)
    _, index, length, harmonic = finer if finer[0] < MOST_LEFT_BY_HARMONIC * plain[0] else plain
    equation = equations[index]
    waves_there = _waves(equation.position, length, (1,) if harmonic == 1 else (1, harmonic))
    found = equation.solved(waves_there, situation.plant.monic)
    if found is None:
        return None
    plant, bias, terms = found
    waves = tuple((float(np.hypot(*pair)), float(np.arctan2(pair[1], pair[0]))) for pair in terms.reshape(-1, 2))
    return PlantBesideWave(plant, bias, length, waves, harmonic)


def plant_beside_stops(situation: Situation) -> PlantBesideStops | None:
    """The plant and the stop near an end of the recorded way, or near both, that fit the recorded motion.

    Returns
    -------
    PlantBesideStops or None
        None where the plant has zeros or too many poles, or no stop that pushes back explains much.
    """
    best: tuple[float, EquationOfMotion, list[float]] | None = None
    for equation in equations_of_motion(situation):
        left, places = _likeliest_stops(equation)
        if left < (MOST_LEFT_BY_STOP if best is None else best[0]):
            best = left, equation, places
    if best is None:
        return None
    _, equation, places = best
    forces = np.column_stack([_beyond(equation.position, place) for place in places])
    found = equation.solved(forces, situation.plant.monic)
    if found is None:
        return None
    plant, bias, sizes = found
    # The force opposes the motion that the input drives.
    pushing = zip(places, (sizes * np.sign(plant.numerator[0])).tolist(), strict=True)
    stops = tuple((place, stiffness) for place, stiffness in pushing if stiffness > 0.0)
    return PlantBesideStops(plant, bias, stops) if stops else None


def _likeliest_stops(equation: EquationOfMotion) -> tuple[float, list[float]]:
    """Share that stops leave, and where they are: one, or one at either end where that leaves much less."""
    low, high = float(np.min(equation.position)), float(np.max(equation.position))
    above = [float(p) for p in high - PLACES * (high - low) if p > 0.0]
    below = [float(p) for p in low + PLACES * (high - low) if p < 0.0]
    places = above + below
    if not places:
        return 1.0, []
    columns = np.column_stack([_beyond(equation.position, place) for place in places])
    alone = equation.left_by_each(columns, np.zeros((len(columns), 0)))
    least = int(np.argmin(alone))
    if above and below:
        pairs = equation.left_by_pairs(columns)[: len(above), len(above) :]
        first, second = np.unravel_index(int(np.argmin(pairs)), pairs.shape)
        if pairs[first, second] < MOST_LEFT_BY_STOP * alone[least]:
            return float(pairs[first, second]), [above[first], below[second]]
    return float(alone[least]), [places[least]]


def _waves(position: Array, period: float, multiples: tuple[int, ...]) -> Array:
    """Sine and cosine of some multiples of the angle that a position is of a period, shape (N, 2k)."""
    angles = 2.0 * pi / period * np.outer(position, multiples)
    return np.stack([np.sin(angles), np.cos(angles)], axis=-1).reshape(len(angles), -1)


def _beyond(position: Array, place: float) -> Array:
    """Way beyond a stop, shape (N,)."""
    way = position - place
    return np.maximum(way, 0.0) if place > 0.0 else np.minimum(way, 0.0)
