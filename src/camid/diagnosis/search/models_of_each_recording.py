"""Models with an effect that each of several recordings suggests alone: where fits to all of them may start.

What is missing may leave the coefficients of one recording as they are, and bend those of another of a smaller input
beyond repair, so that no fit of both starts well: play, beside a motion that hardly exceeds it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camid.diagnosis.search.screening import ScreenedEffect, screen
from camid.diagnosis.watch import NAMES, Watch
from camid.effects.base import Effect
from camid.fitting.fit import Fitted, fit
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem

# Different effects that are tried of each recording, recordings, and evaluations of a fit.
EFFECTS, RECORDINGS, STEPS = 6, 3, 12
# Rows that a recording needs to say something alone.
FEWEST_ROWS = 100


def models_of_each_recording(problem: Problem, base: Fitted, watch: Watch) -> list[Model]:
    """Models whose last effect is what one of the recordings suggests; none where there is one recording.

    Parameters
    ----------
    problem : Problem
    base : Fitted
        All recordings refitted without the effect.
    watch : Watch
    """
    runs = problem.runs
    if len(problem.fitted_runs) < 2:
        return []
    found = []
    for run in problem.fitted_runs[:RECORDINGS]:
        used = [e.used if r == run else np.zeros_like(e.used) for e, r in zip(problem.experiments, runs, strict=True)]
        watch.take_stock(NAMES)
        if np.count_nonzero(used[run]) < FEWEST_ROWS or watch.no_time_for("what each recording says alone"):
            continue
        found += _models(problem.with_used(used), base)
    return found


def _models(alone: Problem, base: Fitted) -> list[Model]:
    """The likeliest effects of one recording, fitted to it."""
    try:
        refitted = fit(alone, base.model, steps=STEPS)
        screened = screen(alone, refitted)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return []
    models = []
    for effect in _likeliest(screened):
        try:
            models.append(fit(alone, refitted.model.plus(effect), steps=STEPS).model)
        except (ValueError, ArithmeticError, np.linalg.LinAlgError):
            continue
    return models


def _likeliest(screened: Sequence[ScreenedEffect]) -> list[Effect]:
    """The first candidate of each of the likeliest effects, in the size that the screening suggests."""
    found: dict[str, Effect] = {}
    for candidate in screened:
        if len(found) == EFFECTS:
            break
        effect = candidate.start
        found.setdefault(effect.identifier, effect)
    return list(found.values())
