"""``camid.step``: step responses of models with bands."""

from __future__ import annotations

from math import isfinite

from camid.analysis.linear_model import linear_models, units_of
from camid.analysis.models import ModelSource, named_models
from camid.analysis.step_response import StepResponses, remarks_of_step, step_curve, times_for
from camid.errors import InputError, need


def step(*models: ModelSource, amplitude: float = 1.0, duration: float | None = None) -> StepResponses:
    """Motion of the plants of models after a step of the input from rest, with 95 % bands.

    Parameters
    ----------
    *models : path, mapping, Simulation, result of ``camid.identify`` or ``camid.diagnose``, or python-control system
        Linear plants run in python-control, nonlinear ones, with their effects, in the engine.
    amplitude : float
        Height of the step, in the unit that the first model declares for the input.
    duration : float, optional
        Seconds; as long as python-control takes for the slowest model.

    Returns
    -------
    StepResponses
        ``numbers`` is a table, ``figure()`` draws, ``save(path)`` writes.

    Raises
    ------
    InputError
        If a model cannot be read or run, or amplitude or duration are none.
    """
    need("a step response", "control")
    if not (isfinite(amplitude) and amplitude != 0.0):
        raise InputError(f"a step of {amplitude:g}", hint="give a number other than zero")
    if duration is not None and not (isfinite(duration) and duration > 0.0):
        raise InputError(f"a duration of {duration:g} s", hint="give a positive number of seconds")
    simulations = named_models(models, plants_alone=True)
    linear = linear_models(simulations)
    times = times_for(linear, duration)
    units = units_of(linear[0].simulation)
    amplitude *= units.input.factor
    curves = [step_curve(model, times, amplitude) for model in linear]
    remarks = [s for model, curve in zip(linear, curves, strict=True) for s in remarks_of_step(model, curve)]
    return StepResponses(curves, amplitude, units, tuple(remarks))
