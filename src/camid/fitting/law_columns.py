"""Derivatives of the simulated output by the heights of a learned law."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from camid.effects.learned import LearnedEffect
from camid.engine.law_derivatives import by_law
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.side_by_side import side_by_side

Array = NDArray[np.float64]

# Share of the heights that a direction changes up to which it acts in a small part of the motion.
LOCAL = 0.25


def law_columns(pinned: Problem, model: Model, index: int, ways: Array, size: float, simulated: Array) -> Array:
    """Derivatives of the simulated output by a law's heights along given directions, zero where they are not finite.

    Parameters
    ----------
    pinned : Problem
        With the steps of the integrator that suit the model.
    model : Model
    index : int
        Which of its effects is the law.
    ways : ndarray, shape (k, m)
        Each column is a direction in which the k heights change.
    size : float
        Step of differences by heights.
    simulated : ndarray, shape (M,)
        Output of the model.

    Returns
    -------
    ndarray, shape (M, m)
    """
    columns = _by_tangents(pinned, model, index, ways, size)
    if columns is None:
        columns = by_differences(pinned, model, index, ways, size, simulated)
    columns[~np.isfinite(columns)] = 0.0
    return columns


def _by_tangents(pinned: Problem, model: Model, index: int, ways: Array, size: float) -> Array | None:
    """The same from one run of each recording, or None where only whole simulations tell it."""
    local = np.count_nonzero(ways) <= LOCAL * ways.size
    # What acts everywhere is put together from what single heights do, each of which acts near its knot.
    single = ways if local else np.eye(len(ways))
    law, parts = model.effects[index], []
    for chain, signal, time, used in pinned.fitted_chains(model):
        place = next(i for i, effect in enumerate(chain.effects) if effect is law)
        part = by_law(chain, signal, time, place, single, size)
        if part is None:
            return None
        parts.append(part[used])
    if not parts:
        return None
    columns = pinned.as_compared(np.concatenate(parts))
    return columns if local else columns @ ways


def by_differences(pinned: Problem, model: Model, index: int, ways: Array, size: float, simulated: Array) -> Array:
    """The same from a whole simulation for each direction, by one-sided differences; see :func:`law_columns`."""
    return np.column_stack(side_by_side(partial(_difference, pinned, model, index, size, simulated), list(ways.T)))


def _difference(pinned: Problem, model: Model, index: int, size: float, simulated: Array, way: Array) -> Array:
    law = model.effects[index]
    assert isinstance(law, LearnedEffect)
    moved = law.with_heights(law.heights + size * way)
    effects = (*model.effects[:index], moved, *model.effects[index + 1 :])
    return (pinned.simulate_fitted(replace(model, effects=effects)) - simulated) / size
