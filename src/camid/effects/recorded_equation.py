"""A plant beside a force over the position, both from the plant's equation at the recorded positions.

Cogging, or a stop that holds a plant which integrates, bends the coefficients that are estimated without it, and a
simulation beside those leaves the recorded way, so that no fit finds where the poles of the motor or the stop are. The
equation of motion holds at the recorded positions with all of it, is linear in all but the period or the place, and
needs no simulation. It yields a beginning alone, since noise in the derivatives bends it (an equation error; Ljung
1999, section 7.3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction
from camid.effects.base import Effect
from camid.effects.plant_force import force_along
from camid.effects.recorded_force import CUT_OFFS, FILTER_ORDER, MOST_POLES, MOST_ROWS, TURNED_ROUND
from camid.effects.situation import Situation

Array = NDArray[np.float64]

# Periods around a guess that are looked at, as shares of it.
PERIODS = np.linspace(0.93, 1.07, 57)
# Rows at either end that the filter spoils, in its time constants.
SPOILED = 3.0
# A harmonic leaves less than this share of what is left without it.
MOST_LEFT_BY_HARMONIC = 0.7
# Places of a stop that are looked at, as shares of the way from either end, and what a stop that is worth a beginning
# leaves of what is left without it.
PLACES = np.linspace(0.0, 0.3, 16)[1:]
MOST_LEFT_BY_STOP = 0.7
# Factor within which the plant's gain lies to what was estimated without the force, at high or at low frequencies.
NEAR = 300.0
# Share of a force beside the others below which nothing is left of it.
LEAST_SHOWN = 1e-3
# What each of several forces leaves of what was left before, at most; and what a simpler one may leave in the place of
# the one that leaves least.
MOST_LEFT_BY_ANOTHER, NEARLY_AS_MUCH = 0.7, 1.15
# What another force in the place of one of them may leave over what is left with that one, and how many are looked at
# in each place: noise in the derivatives bends laws of friction into one another.
MOST_LEFT_INSTEAD, MOST_INSTEAD = 2.0, 2


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
class PlantBesideStop(PlantBesideForce):
    """A plant and the stop that holds it.

    Attributes
    ----------
    place : float
        Where the contact begins, in units of the output.
    stiffness : float
        In units of the input by those of the output.
    """

    place: float
    stiffness: float


@dataclass(frozen=True)
class PlantBesideLaws(PlantBesideForce):
    """A plant and forces that act on it.

    Attributes
    ----------
    laws : tuple of Effect
        In the sizes that fit, the one that explains most first.
    left : float
        Share that they leave of what is left without them.
    """

    laws: tuple[Effect, ...]
    left: float


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
    equations = _equations(situation)
    tried = [
        (equation.left(_waves(equation.position, period * share, harmonic)), index, period * share, harmonic)
        for index, equation in enumerate(equations)
        for share in PERIODS
        for harmonic in (1, *orders)
    ]
    plain = min((each for each in tried if each[3] == 1), default=None)
    if plain is None:
        return None
    finer = min((each for each in tried if each[3] > 1), default=plain)
    _, index, length, harmonic = finer if finer[0] < MOST_LEFT_BY_HARMONIC * plain[0] else plain
    equation = equations[index]
    found = equation.solved(_waves(equation.position, length, harmonic), situation.plant.monic)
    if found is None:
        return None
    plant, bias, terms = found
    waves = tuple((float(np.hypot(*pair)), float(np.arctan2(pair[1], pair[0]))) for pair in terms.reshape(-1, 2))
    return PlantBesideWave(plant, bias, length, waves, harmonic)


def plant_beside_stop(situation: Situation) -> PlantBesideStop | None:
    """The plant and the stop near an end of the recorded way that fit the recorded motion.

    Returns
    -------
    PlantBesideStop or None
        None where the plant has zeros or too many poles, or no stop that pushes back explains much.
    """
    best: tuple[float, _Equation, float] | None = None
    for equation in _equations(situation):
        low, high = float(np.min(equation.position)), float(np.max(equation.position))
        places = [p for p in high - PLACES * (high - low) if p > 0.0]
        places += [p for p in low + PLACES * (high - low) if p < 0.0]
        tried = [(equation.left(_beyond(equation.position, place)), place) for place in places]
        left, place = min(tried, default=(1.0, 0.0))
        if left < (MOST_LEFT_BY_STOP if best is None else best[0]):
            best = left, equation, float(place)
    if best is None:
        return None
    _, equation, place = best
    found = equation.solved(_beyond(equation.position, place), situation.plant.monic)
    if found is None:
        return None
    plant, bias, (stiffness,) = found
    # The force opposes the motion that the input drives.
    pushes_back = float(stiffness) * np.sign(plant.numerator[0])
    return PlantBesideStop(plant, bias, place, float(pushes_back)) if pushes_back > 0.0 else None


def plants_beside_laws(situation: Situation, shapes: Sequence[Effect], most: int) -> list[PlantBesideLaws]:
    """The plant and the forces that explain most of the recorded motion, one after the other (matching pursuit).

    Parameters
    ----------
    situation : Situation
    shapes : sequence of Effect
        Forces, in any size; what remembers the motion is passed over.
    most : int
        How many, of different names: as many as explain something beside those before them.

    Returns
    -------
    list of PlantBesideLaws
        Behind the likeliest those in which another force, that leaves about as much, has the place of one of them; of
        several the first one alone stands last. Empty where the plant has zeros or too many poles, or forces of such
        signs explain nothing.

    References
    ----------
    Mallat & Zhang (1993), IEEE Trans. Signal Process. 41, 3397-3415.
    """
    equations = _equations(situation, friction=False)
    if not equations:
        return []
    middle = equations[len(equations) // 2]
    plain = middle.solved(np.zeros((len(middle.position), 0)), situation.plant.monic)
    plant = situation.plant if plain is None else plain[0]
    taken = [(law, -force_along(law, plant, middle.motion)) for law in shapes if law.memory_after is None]
    taken = [(law, force) for law, force in taken if np.all(np.isfinite(force)) and np.any(force)]
    if not taken:
        return []
    laws, columns = [law for law, _ in taken], np.column_stack([force for _, force in taken])
    pursuits = [(equation, *_pursued(equation, laws, columns, most)) for equation in equations]
    # Where two laws of friction make up for each other in one filter, another one tells them apart.
    found: list[PlantBesideLaws] = []
    for equation, chosen, left in sorted(pursuits, key=lambda each: min(each[2], default=1.0)):
        sets = [(left[-1], chosen), *_with_others_instead(equation, laws, columns, chosen, left[-1])] if chosen else []
        sets += [(left[0], chosen[:1])] if len(chosen) > 1 else []
        sized = [
            _with_sizes(equation, [laws[i] for i in each], columns[:, each], rest, situation) for rest, each in sets
        ]
        found += [each for each in sized if each is not None]
        if sized and sized[0] is not None:
            return [each for each in sized if each is not None]
    return found


def _with_others_instead(
    equation: _Equation, laws: Sequence[Effect], columns: Array, chosen: Sequence[int], left: float
) -> list[tuple[float, list[int]]]:
    """The laws with one of them replaced by one of another name, and what is left then: the least first."""
    found: list[tuple[float, list[int]]] = []
    for place in range(len(chosen)):
        shares = equation.left_by_each(columns, columns[:, [i for i in chosen if i != chosen[place]]])
        named = {laws[i].identifier for i in chosen}
        for i in np.argsort(shares).tolist():
            if shares[i] > MOST_LEFT_INSTEAD * left or len(named) == len(chosen) + MOST_INSTEAD:
                break
            if laws[i].identifier not in named:
                named.add(laws[i].identifier)
                found.append((float(shares[i]), [*chosen[:place], i, *chosen[place + 1 :]]))
    return sorted(found)


def _with_sizes(
    equation: _Equation, laws: Sequence[Effect], columns: Array, left: float, situation: Situation
) -> PlantBesideLaws | None:
    """The plant and the laws, in the sizes that fit the equation; None where these are impossible."""
    found = equation.solved(columns, situation.plant.monic)
    if found is None:
        return None
    plant, bias, sizes = found
    in_sizes = _in_sizes(laws, sizes)
    return PlantBesideLaws(plant, bias, in_sizes, left) if in_sizes else None


def _pursued(equation: _Equation, laws: Sequence[Effect], columns: Array, most: int) -> tuple[list[int], list[float]]:
    """Which laws explain most, one after the other, and the shares that are left with each of them in addition."""
    chosen: list[int] = []
    left: list[float] = []
    while len(chosen) < most:
        named = {laws[i].identifier for i in chosen}
        shares = equation.left_by_each(columns, columns[:, chosen])
        shares[[law.identifier in named for law in laws]] = np.inf
        # Of those that leave about as much, the simplest.
        near = np.flatnonzero(shares <= NEARLY_AS_MUCH * np.min(shares))
        best = min(near.tolist(), key=lambda i: (len(laws[i].vector), shares[i]))
        if shares[best] > MOST_LEFT_BY_ANOTHER * min(left, default=1.0):
            break
        chosen.append(best)
        left.append(float(shares[best]))
    return chosen, left


def _in_sizes(laws: Sequence[Effect], sizes: Array) -> tuple[Effect, ...]:
    """Laws in multiples of their sizes; none where one may not have such a sign."""
    found = []
    for law, size in zip(laws, sizes.tolist(), strict=True):
        try:
            scaled = law.scaled(size)
        except ValueError:
            return ()
        if size < 0.0 and np.array_equal(scaled.vector, law.scaled(0.0).vector):
            return ()
        found.append(scaled)
    return tuple(found)


def _waves(position: Array, period: float, harmonic: int) -> Array:
    """Sines and cosines of a position, shape (N, 2) or (N, 4)."""
    angles = 2.0 * pi / period * np.outer(position, [1] if harmonic == 1 else [1, harmonic])
    return np.stack([np.sin(angles), np.cos(angles)], axis=-1).reshape(len(angles), -1)


def _beyond(position: Array, place: float) -> Array:
    """Way beyond a stop, shape (N, 1)."""
    way = position - place
    return (np.maximum(way, 0.0) if place > 0.0 else np.minimum(way, 0.0))[:, None]


def _equations(situation: Situation, *, friction: bool = True) -> list[_Equation]:
    """The equation of motion with each filter; none of a plant that has zeros or too many poles."""
    situation = situation.until(MOST_ROWS)
    monic = situation.plant.monic
    if len(monic.numerator) != 1 or monic.order not in range(1, MOST_POLES + 1):
        return []
    return [each for cut in CUT_OFFS if (each := _Equation.of(situation, cut, friction)) is not None]


@dataclass(frozen=True)
class _Equation:
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
    def of(cls, situation: Situation, cut_off: float, friction: bool) -> _Equation | None:
        """With one filter, and dry friction or none; None where the recording is too short for it."""
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
        dry = sosfiltfilt(sections, np.tanh(derivatives[1] / slow)) if friction else np.zeros(len(position))
        # A coefficient that is zero, as that of a plant that integrates, stays so.
        terms = zip(derivatives[::-1], situation.plant.monic.denominator, strict=True)
        columns = [term if coefficient != 0.0 else np.zeros_like(term) for term, coefficient in terms]
        table = np.column_stack([*columns, np.ones(len(position)), dry])[inner]
        basis = np.linalg.qr(table / np.maximum(np.linalg.norm(table, axis=0), 1e-300))[0]
        rest = smooth[inner, 1]
        rest = rest - basis @ (basis.T @ rest)
        motion = situation.time, smooth[:, 0], derivatives[1], command
        return cls(position, motion, sections, inner, smooth[inner, 1], table, basis, rest)

    def _filtered(self, forces: Array) -> Array:
        """Functions of the recorded position, shape (N, k), as the terms of the equation are filtered."""
        from scipy.signal import sosfiltfilt

        return np.asarray(sosfiltfilt(self.sections, forces, axis=0)[self.inner])

    def left(self, forces: Array) -> float:
        """Share of the rest that forces over the position, shape (N, k), leave."""
        forces = self._filtered(forces)
        forces = forces - self.basis @ (self.basis.T @ forces)
        explained = np.linalg.lstsq(forces, self.rest, rcond=None)[0]
        left = self.rest - forces @ explained
        return float(left @ left) / max(float(self.rest @ self.rest), 1e-300)

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
