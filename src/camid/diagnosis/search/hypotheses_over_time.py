"""Hypotheses about a plant whose phases add up, fitted over a horizon that grows, with the worst left behind.

Over the whole of a decay that the nominal structure cannot follow, its refit says little: coefficients, initial states
and the screening around them belong to a motion that soon runs out of phase, and each effect would be fitted from
there into another minimum. Over the first few periods every hypothesis follows. It keeps following while the horizon
grows only if it is right, so that fewer and fewer are carried on; halving the field while the effort for each grows is
that of Jamieson & Talwalkar (2016), Non-stochastic best arm identification, AISTATS. Shapes of one effect mostly end in
one minimum over the first horizon: its best is carried on alone. How far behind an effect is says little: a constant
force imitates the friction of a decay over a few periods, and leaves it behind by hundreds.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from camid.diagnosis.search.screening import ScreenedEffect, screen
from camid.fitting.fit import Fitted, fit
from camid.fitting.growing_horizon import GROWTH, first_horizon
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.side_by_side import side_by_side

# Evaluations for each horizon.
STEPS = 8
# Shapes of each effect over the first horizon, and models over the whole.
SHAPES = 2
FEWEST = 5


def raced(problem: Problem, start: Model) -> list[Model]:
    """The effects that follow the recordings longest beside a model, each fitted with it, the best first.

    Parameters
    ----------
    problem : Problem
    start : Model
        With the effects found already; its coefficients and initial states are fitted to the first horizon.

    Returns
    -------
    list of Model
        The last effect of each is another one.
    """
    first, longest = first_horizon(problem, start), max(len(t) for t in problem.times)
    part = problem.start_of(first)
    models = _entrants(part, part.kind.refit(part, part.with_initial_states(start)))
    entered, rows = 0, first
    while models:
        part = problem.start_of(rows)
        results = [f for f in side_by_side(partial(_fitted, part), models) if f is not None]
        closest = min(results, key=lambda f: f.cost, default=None)
        if closest is not None:
            results.sort(key=lambda f: f.criterion_beyond(closest))
        results = _best_of_each(results)
        entered = entered or len(results)
        # The field shrinks as the horizon grows, so that a longer one costs little more.
        models = [f.model for f in results[: max(FEWEST, round(entered * first / rows))]]
        if rows >= longest:
            break
        rows = min(int(GROWTH * rows), longest)
    return models


def _entrants(part: Problem, base: Fitted) -> list[Model]:
    """The likeliest shapes of every effect over the first horizon, in the size that it suggests."""
    shapes: dict[str, list[ScreenedEffect]] = {}
    for candidate in screen(part, base):
        known = shapes.setdefault(candidate.effect.identifier, [])
        if len(known) < SHAPES:
            known.append(candidate)
    found = []
    for candidate in (c for known in shapes.values() for c in known):
        try:
            found.append(base.model.plus(candidate.start))
        except ValueError:
            found.append(base.model.plus(candidate.effect))
    return found


def _fitted(part: Problem, model: Model) -> Fitted | None:
    try:
        result = fit(part, model, steps=STEPS, refreshes=1, finest=False)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return None
    return result if np.isfinite(result.noise.deviance) else None


def _best_of_each(results: Sequence[Fitted]) -> list[Fitted]:
    """The first result of each effect."""
    found: dict[str, Fitted] = {}
    for result in results:
        found.setdefault(result.model.effects[-1].identifier, result)
    return list(found.values())
