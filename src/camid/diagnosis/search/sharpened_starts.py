"""Starts of a plant that integrates, sharpened while an observer pulls its simulation towards the recordings.

The equation of motion holds at the recorded positions, but its derivatives are those of noisy readings: a period that
is off by a thousandth of itself sends the simulation by itself into another well of a motor. One that is pulled follows
whatever is off, and least squares with it have one minimum.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from camid.fitting.fit import Fitted, fit
from camid.fitting.initial_motion import recorded_start
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.side_by_side import side_by_side

# Evaluations of a fit while it is pulled.
STEPS = 20


def sharpened(problem: Problem, pulled: Problem, starts: Sequence[Model]) -> list[Model]:
    """Models fitted while they are pulled, as starts for a simulation by itself, the likeliest first.

    Parameters
    ----------
    problem : Problem
    pulled : Problem
        The same with an observer.
    starts : sequence of Model
        Those that diverge are left out.
    """
    fitted = [each for each in side_by_side(partial(_fitted_while_pulled, pulled), starts) if each is not None]
    if not fitted:
        return []
    closest = min(fitted, key=lambda each: each.cost)
    return [let_go(each.model, problem) for each in sorted(fitted, key=lambda each: each.criterion_beyond(closest))]


def let_go(pulled: Model, problem: Problem) -> Model:
    """A model that was pulled, as a start for a simulation by itself, with what that one knows of offset and bias."""
    return _with_constants_of(problem, pulled)


def _fitted_while_pulled(pulled: Problem, start: Model) -> Fitted | None:
    try:
        fitted = fit(pulled, recorded_start(pulled, _with_constants_of(pulled, start)), steps=STEPS, finest=False)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return None
    return fitted if np.isfinite(fitted.cost) else None


def _with_constants_of(problem: Problem, model: Model) -> Model:
    """A model with the constants that a problem knows, and without initial states."""
    constants = problem.kind.constants()
    constants |= {name: value for name, value in model.constants.items() if name in constants}
    return replace(model, constants=constants, initial=())
