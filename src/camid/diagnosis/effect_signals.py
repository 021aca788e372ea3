"""What a recording shows of each effect beside what the effect's law says, free of what coefficients absorb.

A fit without an effect bends the plant's coefficients towards it, so that its residual is the law less what they took:
friction comes out tilted by the damping that was put in its place. Here the law is taken along the motion of the
improved simulation, whose coefficients are those beside the effect, and what that simulation leaves is added: the
component-plus-residual of regression (Larsen & McCleary 1972, Technometrics 14, 781–790). For a plant that is linear in
the force this is exactly the recording less the improved plant without the effect.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.effects.base import Effect
from camid.effects.plant_force import force_along
from camid.fitting.fit import Fitted
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem

Array = NDArray[np.float64]


@dataclass(frozen=True)
class EffectSignals:
    """What the first recording shows of an effect, beside what its law says.

    Attributes
    ----------
    identifier : str
    position : ndarray, shape (N,)
        As the sensor sees it: in the improved simulation, or without the effect where that is one of the sensor.
    velocity : ndarray, shape (N,)
        Of the plant, in units of y per second.
    rate : ndarray, shape (N,)
        Of ``position`` from row to row, in its units per second.
    data, law : ndarray, shape (N,)
        What the recording shows and what the law says: a force at the plant's input in units of u, or of an effect of
        the sensor what it adds to the reading.
    """

    identifier: str
    position: Array
    velocity: Array
    rate: Array
    data: Array
    law: Array
    seen: Array
    unit: str = "u"


def effect_signals(problem: Problem, final: Fitted, identifiers: Sequence[str]) -> list[EffectSignals]:
    """Of the first recording, for every effect of a model that is named.

    Parameters
    ----------
    problem : Problem
    final : Fitted
        The improved model.
    identifiers : sequence of str
        Of effects that change the expected output.
    """
    wanted = [(i, e) for i, e in enumerate(final.model.effects) if e.identifier in identifiers]
    if not wanted:
        return []
    model, experiment = final.model, problem.experiments[0]
    simulated = problem.simulate_one(model, 0)
    left = experiment.output - simulated
    position, velocity = problem.motion(model)[0]
    seen = problem.kind.position_seen(problem, model, 0, position)
    found = []
    for index, effect in wanted:
        if effect.place == "sensor":
            without = problem.simulate_one(model.without(index), 0)
            law = (simulated - without) / experiment.weight
            shown, position_here = law, without / experiment.weight
            rest = left / experiment.weight
        else:
            force = _force(problem, model, index, position, velocity)
            if force is None:
                continue
            law = problem.kind.shown_sign * force
            shown, position_here = problem.kind.force_seen(problem, model, law), seen
            rest = problem.kind.equivalent_input(problem, model, left)
        unit = "y" if effect.place == "sensor" else "u"
        rate = np.gradient(position_here, problem.acquisition.period)
        if np.all(np.isfinite(law)) and np.all(np.isfinite(shown + rest)):
            found.append(
                EffectSignals(effect.identifier, position_here, velocity, rate, shown + rest, law, shown, unit)
            )
    return found


def _force(problem: Problem, model: Model, index: int, position: Array, velocity: Array) -> Array | None:
    """What an effect adds to the plant's input in every row, shape (N,); None where it adds no force."""
    effect, experiment = model.effects[index], problem.experiments[0]
    chain = problem.chain(model, 0)
    if effect.force is not None or effect.friction_level is not None:
        motion = (problem.times[0], position, velocity, experiment.signal)
        return force_along(effect.beside(chain.effects, chain.acquisition.period), chain.plant, motion)
    if type(effect).transform is not Effect.transform:
        signal = np.asarray(experiment.signal, float)
        start, _ = effect.transform(signal, signal, problem.acquisition.period)
        return np.asarray(start - signal)
    if effect.place != "actuator":
        return None
    # A hold or a lag adds what its response would have taken.
    difference = problem.simulate_one(model, 0) - problem.simulate_one(model.without(index), 0)
    return problem.kind.equivalent_input(problem, model, difference)
