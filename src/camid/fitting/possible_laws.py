"""Which laws without a name are possible: curves over what the recordings visit, which no coefficient can imitate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.effects.learned import FORCES, LearnedCurve, LearnedEffect, LearnedForce
from camid.fitting.fit import Fitted
from camid.fitting.problem import Problem

Array = NDArray[np.float64]

KNOTS = 17
# Values of a signal, among its first ones, from which a curve over it says more than a straight line.
FEW_ROWS, FEWEST_VALUES = 1000, 4
# Prior precision of a slope that no free coefficient stands for, beside that of a curve.
LEAST_ROUGHNESS = 1e-6


@dataclass(frozen=True)
class PossibleLaws:
    """Which laws are possible: heights = origin + directions · c.

    Attributes
    ----------
    directions : ndarray, shape (k, m)
        Of k heights, those that no coefficient imitates.
    roughness : ndarray, shape (m, m)
        Precision of the weights c that a smooth curve has beforehand, positive definite.
    origin : ndarray, shape (k,)
    unit : float
        What heights are measured by, in theirs.
    """

    directions: Array
    roughness: Array
    origin: Array
    unit: float


def blank_laws(problem: Problem, fitted: Fitted) -> dict[str, LearnedEffect]:
    """Laws that do nothing, on knots over what the recordings visit, by what they depend on."""
    found: dict[str, LearnedEffect] = {}
    seen = visited(problem, fitted)
    for name in (*FORCES, "input", *(["reading"] if problem.kind.one_reading else [])):
        over, times = FORCES.get(name, (name, None))
        low, high = float(np.min(seen[over])), float(np.max(seen[over]))
        if not np.isfinite(high - low) or high <= low or (times and not np.any(seen[times])):
            continue
        if len(np.unique(seen[over][:FEW_ROWS])) < FEWEST_VALUES:
            continue
        knots = _knots(seen[over]).tolist()
        law: LearnedEffect
        if name in FORCES:
            law = LearnedForce(variables=name, knots=knots, values=[0.0] * len(knots))
        else:
            law = LearnedCurve(variables=name, knots=knots, values=knots)
        if law.place not in problem.kind.hidden_places:
            found[name] = law
    return found


def _knots(seen: Array) -> Array:
    """Over what is visited, evenly; of a command of few levels these themselves, as nothing tells of those between."""
    levels = np.unique(seen)
    return levels if len(levels) <= KNOTS else np.linspace(levels[0], levels[-1], KNOTS)


def laws_on_knots(problem: Problem, fitted: Fitted, law: LearnedEffect) -> PossibleLaws:
    """Laws on the same knots that no coefficient can imitate."""
    name, knots = str(law.values["variables"]), law.knots
    over, times = FORCES.get(name, (name, None))
    seen = visited(problem, fitted)
    often = np.ones(len(seen[over])) if times is None else seen[times] ** 2
    often /= max(float(often.sum()), 1e-300)
    counts = _at_knots(knots, seen[over], often)
    constraints = []
    if times is None:
        middle = np.array([np.interp(0.0, knots, row) for row in np.eye(len(knots))])
        constraints.append(middle if knots[0] <= 0.0 <= knots[-1] else counts)
    if coefficient_is_free(problem, name):
        # What a coefficient does is a straight line through zero, or where the law multiplies a signal a constant.
        spread = seen[over] - float(often @ seen[over]) if times is None else np.ones(len(often))
        constraints.append(_at_knots(knots, seen[over], often * spread) / max(float(often @ spread**2), 1e-300))
    directions = null_space(np.array(constraints)) if constraints else np.eye(len(knots))
    second = np.diff(np.eye(len(knots)), 2, axis=0) @ directions
    roughness = second.T @ second
    roughness += LEAST_ROUGHNESS * float(np.trace(roughness)) / len(roughness) * np.eye(len(roughness))
    unit = float(np.ptp(knots)) if isinstance(law, LearnedCurve) else largest_force(seen["input"], problem, fitted)
    if times is not None:
        unit /= float(np.max(np.abs(seen[times])))
    return PossibleLaws(directions, roughness, law.heights, unit)


def _at_knots(knots: Array, seen: Array, weights: Array) -> Array:
    """Weights of a law's values at its knots in the sum of what it is where it is visited, shape (k,).

    With the nearest knot of each a law might swing between the levels of a command, and do what a gain does.
    """
    right = np.clip(np.searchsorted(knots, seen), 1, len(knots) - 1)
    share = np.clip((seen - knots[right - 1]) / (knots[right] - knots[right - 1]), 0.0, 1.0)
    count = len(knots)
    return np.asarray(
        np.bincount(right - 1, weights * (1.0 - share), count) + np.bincount(right, weights * share, count)
    )


def largest_force(signal: Array, problem: Problem, fitted: Fitted) -> float:
    """The largest input, or without one the force that would hold the plant where it moves."""
    return float(np.max(np.abs(signal), initial=0.0)) or problem.situation(fitted.model).largest("signal")


def visited(problem: Problem, fitted: Fitted) -> dict[str, Array]:
    """Values of what a law may depend on, on the fitted rows, shapes (M,)."""
    motions = problem.motion(fitted.model)
    return {
        "position": problem.fitted([m[0] for m in motions]),
        "velocity": problem.fitted([m[1] for m in motions]),
        "input": problem.fitted([e.signal for e in problem.experiments]),
        "reading": problem.fitted(problem.simulate(fitted.model)),
    }


def over_of(law: LearnedEffect) -> str:
    """Which of these a law is over."""
    name = str(law.values["variables"])
    return FORCES.get(name, (name, None))[0]


def coefficient_is_free(problem: Problem, name: str) -> bool:
    """Whether a free coefficient does what a straight line, or a constant factor, in the law's place would."""
    free, structure = problem.structure.free, problem.structure
    if name == "position":
        return bool(free[-1])
    if name in ("velocity", "damping over position"):
        return bool(len(free) > structure.degree + 2 and free[-2])
    return bool(np.any(free[: structure.degree + 1]))


def null_space(rows: Array) -> Array:
    """Orthonormal columns that all rows send to zero."""
    _, sizes, vectors = np.linalg.svd(rows)
    return np.asarray(vectors[int(np.count_nonzero(sizes > 1e-12 * sizes[0])) :].T)
