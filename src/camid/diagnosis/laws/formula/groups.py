"""The learned laws of a decision by what they depend on, and what stands in for a part of the same law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.search.decision import Decision
from camid.effects.base import Effect
from camid.effects.learned import LearnedEffect
from camid.fitting.fit import Fitted
from camid.fitting.problem import Problem
from camid.fitting.static_laws import static_values

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Group:
    """The learned laws over one variable, and what stands in for a part of the same law.

    Attributes
    ----------
    variables : str
    index : int
        Of the last such law among the effects of the improved model.
    laws, named, others : tuple of int
        The laws, effects found that are static laws of the same variable, and all other effects found or learned
        that are no constants.
    """

    variables: str
    index: int
    laws: tuple[int, ...]
    named: tuple[int, ...]
    others: tuple[int, ...]


def groups_of(problem: Problem, decision: Decision, known: int, done: Sequence[str] = ()) -> list[Group]:
    """The learned laws of a decision by what they depend on, but for those over variables that are done."""
    model = decision.improved.model
    plant = problem.structure.plant(model.coefficients)
    count = len(decision.fitted.model.effects)
    learned: dict[str, list[int]] = {}
    for i, effect in enumerate(model.effects):
        if i >= count and isinstance(effect, LearnedEffect) and effect.values["variables"] not in done:
            learned.setdefault(str(effect.values["variables"]), []).append(i)
    groups = []
    for variables, indices in learned.items():
        law = model.effects[indices[-1]]
        assert isinstance(law, LearnedEffect)
        period = problem.acquisition.period
        named = [
            i
            for i in range(known, count)
            if static_values(model.effects[i], variables, law.knots, plant, period) is not None
        ]
        # A constant stays beside a formula, which is zero at zero as the learned law is.
        free = [i for i in range(known, len(model.effects)) if not _stays(model.effects[i], done)]
        others = [i for i in free if i not in indices]
        groups.append(Group(variables, indices[-1], tuple(indices), tuple(named), tuple(others)))
    return groups


def _stays(effect: Effect, done: Sequence[str]) -> bool:
    """Whether no formula may take the place of an effect: a constant, or a law that is a formula already."""
    return effect.is_constant or (isinstance(effect, LearnedEffect) and effect.values["variables"] in done)


def values_of(problem: Problem, fitted: Fitted, index: int, variables: str, at: Array) -> Array:
    """Force, or bend, of an effect at some points, shape (N,); zero where it depends on something else."""
    plant = problem.structure.plant(fitted.model.coefficients)
    found = static_values(fitted.model.effects[index], variables, at, plant, problem.acquisition.period)
    return np.zeros(len(at)) if found is None else found


def other_laws(decision: Decision, group: Group, replaced: tuple[int, ...] = ()) -> Array | None:
    """Derivatives by the learned laws over other variables that stay beside a formula."""
    first = len(decision.fitted.model.effects)
    start, kept = 0, []
    for i, law in enumerate(decision.laws):
        whole = law.fitted.nuisance
        if whole is None:
            continue
        if first + i not in (*group.laws, *replaced):
            kept.append(whole[:, start:])
        start = whole.shape[1]
    return np.hstack(kept) if kept else None
