"""Forces that explain most of the recorded motion, one after the other, beside the plant that holds with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.effects.base import Effect
from camid.effects.equation_of_motion import EquationOfMotion, PlantBesideForce, equations_of_motion
from camid.effects.plant_force import force_along
from camid.effects.situation import Situation

Array = NDArray[np.float64]

# What each of several forces leaves of what was left before, at most; and what a simpler one may leave in the place of
# the one that leaves least.
MOST_LEFT_BY_ANOTHER, NEARLY_AS_MUCH = 0.7, 1.15
# What another force in the place of one of them may leave over what is left with that one, and how many are looked at
# in each place: noise in the derivatives bends laws of friction into one another.
MOST_LEFT_INSTEAD, MOST_INSTEAD = 2.0, 2
# What a curve of the command, and a delay of it, leaves of what is left without it, at most: forces beside a curve may
# be most of that, and a command that is held is late by half a period anyway. Rounds in which each is chosen anew.
MOST_LEFT_BY_CURVE, MOST_LEFT_BY_DELAY, ROUNDS = 0.95, 0.8, 3
# First steps from a guess of a period, as a share of it, and of a phase in rad; and when the search for both ends.
NEXT_PERIOD, WIDEST_TURN = 0.003, 0.1
SIMPLEX = {"maxfev": 120, "xatol": 0.01, "fatol": 1e-6}
# What all laws leave at most where a rate or a delay is among them: these smooth any command, which explains some.
MOST_LEFT_IF_LATE = 0.1


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


def plants_beside_laws(
    situation: Situation,
    shapes: Sequence[Effect],
    most: int,
    curves: Sequence[Effect] = (),
    delays: Sequence[Effect] = (),
) -> list[PlantBesideLaws]:
    """The plant and the forces that explain most of the recorded motion, one after the other (matching pursuit).

    Parameters
    ----------
    situation : Situation
    shapes : sequence of Effect
        Forces, in any size; what remembers the motion is passed over.
    most : int
        How many, of different names: as many as explain something beside those before them.
    curves : sequence of Effect
        Of the command, in the sizes that they may have: the best of them stands before the forces, if it explains
        something.
    delays : sequence of Effect
        Of the output after the command; the best of them does, too.

    Returns
    -------
    list of PlantBesideLaws
        The likeliest first, and among them those in which another force, that leaves about as much, has the place of
        one of them, and the first one alone. Empty where the plant has zeros or too many poles, or forces of such signs
        explain nothing.

    References
    ----------
    Mallat & Zhang (1993), IEEE Trans. Signal Process. 41, 3397-3415.
    """
    equations = equations_of_motion(situation, friction=False)
    if not equations:
        return []
    found = _with_forces(equations, situation, shapes, most)
    path = _best_path(situation, curves, delays)
    beside = _behind(path, equations, situation, shapes, most)
    # Beside a strong force the curve that leaves least alone is another one.
    together = _curve_beside_a_force(equations, situation, shapes, curves)
    if together and together != path:
        beside = [*beside, *_behind(together, equations, situation, shapes, most)]
    # A static curve keeps a held command held, a rate and a delay do not.
    if not all(law.keeps_hold for law in path) and min((each.left for each in beside), default=1.0) > MOST_LEFT_IF_LATE:
        path = _best_path(situation, [curve for curve in curves if curve.keeps_hold], ())
        beside = _behind(path, equations, situation, shapes, most)
    return sorted((*beside, *found), key=lambda each: each.left) if beside else found


def _behind(
    path: Sequence[Effect],
    equations: Sequence[EquationOfMotion],
    situation: Situation,
    shapes: Sequence[Effect],
    most: int,
) -> list[PlantBesideLaws]:
    """The plant and forces behind what changes the command on its way; nothing without such."""
    if not path:
        return []
    bent = [each.beside(_arrived(path, each)) for each in equations]
    # What is left with the path is a share of another command.
    middle = len(equations) // 2
    share = bent[middle].unexplained / max(equations[middle].unexplained, 1e-300)
    with_forces = _with_forces(bent, situation, shapes, most)
    alone = _with_sizes(bent[middle], [], np.zeros((len(bent[middle].position), 0)), 1.0, situation)
    return [
        replace(each, laws=(*path, *each.laws), left=share * each.left)
        for each in (*with_forces, *((alone,) if alone else ()))
    ]


def _arrived(path: Sequence[Effect], equation: EquationOfMotion) -> Array:
    """What arrives of the command, shape (N,), by when its effect is recorded."""
    time, _, _, command = equation.motion
    for law in path:
        if law.place == "actuator":
            command = law.transform(command, command, float(time[1] - time[0]))[0]
        else:
            command = np.interp(time - law.values["delay"], time, command)
    return command


def _best_path(situation: Situation, curves: Sequence[Effect], delays: Sequence[Effect]) -> tuple[Effect, ...]:
    """The curve of the command and the delay beside which the plant, with dry friction, leaves least of what arrives.

    One may hide the other, so that each is chosen first.
    """
    equations = equations_of_motion(situation) if curves or delays else []
    if not equations:
        return ()
    equation = equations[len(equations) // 2]

    def left(path: Sequence[Effect | None]) -> float:
        return equation.beside(_arrived([law for law in path if law is not None], equation)).unexplained

    choices = ([None, *curves], MOST_LEFT_BY_CURVE), ([None, *delays], MOST_LEFT_BY_DELAY)
    ends: list[tuple[float, list[Effect | None]]] = []
    for first in (0, 1):
        path: list[Effect | None] = [None, None]
        for place in [first, 1 - first] * ROUNDS:
            laws, most = choices[place]
            paths = [[law, path[1]] if place == 0 else [path[0], law] for law in laws]
            shares = [left(each) for each in paths]
            best = int(np.argmin(shares))
            changed = paths[best if shares[best] < most * shares[0] else 0]
            if changed == path:
                break
            path = changed
        ends.append((left(path), path))
    return tuple(law for law in min(ends, key=lambda each: each[0])[1] if law is not None)


def _with_forces(
    equations: Sequence[EquationOfMotion], situation: Situation, shapes: Sequence[Effect], most: int
) -> list[PlantBesideLaws]:
    """What the equation of motion, with each filter, shows of forces."""
    laws, columns = _columns(equations[len(equations) // 2], situation, shapes)
    if not laws:
        return []
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


def _columns(equation: EquationOfMotion, situation: Situation, shapes: Sequence[Effect]) -> tuple[list[Effect], Array]:
    """Those of some laws that are forces along the recorded motion, and these, shape (N, k)."""
    plain = equation.solved(np.zeros((len(equation.position), 0)), situation.plant.monic)
    plant = situation.plant if plain is None else plain[0]
    taken = [(law, -force_along(law, plant, equation.motion)) for law in shapes if law.memory_after is None]
    taken = [(law, force) for law, force in taken if np.all(np.isfinite(force)) and np.any(force)]
    if not taken:
        return [], np.zeros((len(equation.position), 0))
    return [law for law, _ in taken], np.column_stack([force for _, force in taken])


def _curve_beside_a_force(
    equations: Sequence[EquationOfMotion],
    situation: Situation,
    shapes: Sequence[Effect],
    curves: Sequence[Effect],
) -> tuple[Effect, ...]:
    """The static curve of the command that leaves least together with one force; nothing where none leaves less."""
    middle = equations[len(equations) // 2]
    curves = [curve for curve in curves if curve.keeps_hold]
    laws, columns = _columns(middle, situation, shapes)
    if not curves or not laws:
        return ()
    straight, *bent = middle.left_with_each(
        [middle.motion[3], *(_arrived([curve], middle) for curve in curves)], columns
    )
    least = [float(np.min(row)) for row in bent]
    best = int(np.argmin(least))
    return (curves[best],) if least[best] < MOST_LEFT_BY_CURVE * float(np.min(straight)) else ()


def _with_others_instead(
    equation: EquationOfMotion, laws: Sequence[Effect], columns: Array, chosen: Sequence[int], left: float
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
    equation: EquationOfMotion, laws: Sequence[Effect], columns: Array, left: float, situation: Situation
) -> PlantBesideLaws | None:
    """The plant and the laws, in the sizes that fit the equation; None where these are impossible."""
    laws, columns, left = _sharpened(equation, laws, columns, left, situation)
    found = equation.solved(columns, situation.plant.monic)
    if found is None:
        return None
    plant, bias, sizes = found
    in_sizes = _in_sizes(laws, sizes)
    return PlantBesideLaws(plant, bias, in_sizes, left) if in_sizes or not laws else None


def _sharpened(
    equation: EquationOfMotion, laws: Sequence[Effect], columns: Array, left: float, situation: Situation
) -> tuple[Sequence[Effect], Array, float]:
    """The laws with periods between those of a grid, their forces, and what they leave.

    A period that is off by a third of a percent is half a pole off at the end of a way of many, and a motor that stops
    there is pulled to another one.
    """
    from scipy.optimize import minimize

    places = [i for i, law in enumerate(laws) if law.trials == "frequencies"]
    if not places:
        return laws, columns, left
    plain = equation.solved(columns, situation.plant.monic)
    plant = situation.plant if plain is None else plain[0]
    moved = [[j for j, p in enumerate(laws[i].numeric()) if p.name != laws[i].strength] for i in places]
    starts = [laws[i].vector[which] for i, which in zip(places, moved, strict=True)]
    steps = np.concatenate(
        [
            [WIDEST_TURN if laws[i].numeric()[j].scale == "one" else NEXT_PERIOD * laws[i].vector[j] for j in which]
            for i, which in zip(places, moved, strict=True)
        ]
    )

    def at(change: Array) -> tuple[list[Effect], Array]:
        values, found, forces = change * steps, list(laws), columns.copy()
        for i, which, start in zip(places, moved, starts, strict=True):
            own, values = values[: len(which)], values[len(which) :]
            vector = laws[i].vector.copy()
            vector[which] = start + own
            found[i] = laws[i].with_vector(vector)
            forces[:, i] = -force_along(found[i], plant, equation.motion)
        return found, forces

    def left_at(change: Array) -> float:
        forces = at(change)[1]
        return equation.left_by_sets(forces, [range(forces.shape[1])])[0] if np.all(np.isfinite(forces)) else np.inf

    simplex = np.vstack([np.zeros(len(steps)), np.eye(len(steps))])
    options: Any = SIMPLEX | {"initial_simplex": simplex}
    best = minimize(left_at, np.zeros(len(steps)), method="Nelder-Mead", options=options)
    return (*at(best.x), float(best.fun)) if best.fun < left else (laws, columns, left)


def _pursued(
    equation: EquationOfMotion, laws: Sequence[Effect], columns: Array, most: int
) -> tuple[list[int], list[float]]:
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
