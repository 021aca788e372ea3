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
    ordered = sorted(fitted, key=lambda each: each.criterion_beyond(closest))
    return [as_start_of(problem, each.model) for each in ordered]


def _fitted_while_pulled(pulled: Problem, start: Model) -> Fitted | None:
    try:
        fitted = fit(pulled, recorded_start(pulled, as_start_of(pulled, start)), steps=STEPS, finest=False)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return None
    return fitted if np.isfinite(fitted.cost) else None


def as_start_of(problem: Problem, model: Model) -> Model:
    """A model of one problem as a start for another: with the constants that one knows, and without initial states.

    A pull takes the place of an offset or a bias, so that with and without an observer other constants are known.
    """
    constants = problem.kind.constants()
    constants |= {name: value for name, value in model.constants.items() if name in constants}
    return replace(model, constants=constants, initial=())
