"""Identification of what the engine has to simulate: a pendulum, a plant in a closed loop, or one with effects."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.effects.declared import declared
from camid.fitting.covariance import effect_deviations
from camid.fitting.fit import Fitted
from camid.fitting.identification_task import IdentificationTask
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.identification.estimate import Constant, Estimate
from camid.identification.identification import Identification
from camid.number_text import equals_probability
from camid.simulation.model import DeclaredEffect

# Probability of as much structure in white noise below which it is said.
SURE = 1e-4


def identify_by_simulation(problem: Problem, task: IdentificationTask) -> Identification:
    """Output error through the engine, whatever the method asked for; in a closed loop the error of the control."""
    structure, kind = problem.structure, problem.kind
    moving = tuple(effect for effect in task.effects if not effect.noise_like)
    nominal = Model(structure.coefficients(), moving, constants=kind.constants())
    fitted = kind.refit(problem, problem.with_initial_states(nominal))
    covariance = kind.coefficient_covariance(structure, fitted)
    residuals = [e.output - s for e, s in zip(problem.experiments, problem.simulate(fitted.model), strict=True)]

    def error(rows: list[NDArray[np.bool_]]) -> float:
        values = np.concatenate([r[k] for r, k in zip(residuals, rows, strict=True)])
        return float(np.sqrt(np.mean(values**2))) / problem.spread(rows)

    estimate = Estimate(
        structure.plant(fitted.model.coefficients),
        np.sqrt(np.abs(np.diag(covariance))),
        covariance,
        fitted.cost / max(len(fitted.residual) - len(fitted.packing.names), 1),
        bool(np.all(np.isfinite(fitted.residual)) and np.all(np.isfinite(covariance))),
        0,
        residuals,
        structure.free,
        [],
        [],
        **_constants(fitted),
    )
    found = kind.written_back(task.believed, structure, fitted)
    exposure = problem.acquisition.exposure if found.sensor == "camera" else None
    return Identification(
        simulation=replace(found, exposure=exposure, effects=_declared_again(task, fitted)),
        estimate=estimate,
        # Where a constant follows the recordings as well, a fit has ended nowhere.
        converged=estimate.converged and error([e.used for e in problem.experiments]) < 1.0,
        period=task.recordings[0].period,
        rows_fitted=len(fitted.residual),
        nrmse=error([e.used for e in problem.experiments]),
        nrmse_validation=error(task.held_out) if any(k.any() for k in task.held_out) else None,
        acquisition=problem.acquisition,
        method=kind.method or "output error",
        notes=_whiteness(problem, fitted),
        effect_rows=_rows(fitted),
    )


def _declared_again(task: IdentificationTask, fitted: Fitted) -> tuple[DeclaredEffect, ...]:
    """The effects of the simulation in their order: those on the motion as estimated, the others as before."""
    estimated = iter(declared(fitted.model.effects, effect_deviations(fitted)))
    return tuple(
        one if effect.noise_like else next(estimated)
        for one, effect in zip(task.believed.effects, task.effects, strict=True)
    )


def _rows(fitted: Fitted) -> tuple[dict[str, Any], ...]:
    """Parameters of the effects that were estimated."""
    return tuple(
        {
            "effect": effect.identifier,
            "name": parameter.name,
            "value": effect.values[parameter.name],
            "standard_deviation": deviations[parameter.name],
            "unit": parameter.unit,
        }
        for effect, deviations in zip(fitted.model.effects, effect_deviations(fitted), strict=True)
        for parameter in effect.numeric()
    )


def _constants(fitted: Fitted) -> dict[str, Constant]:
    """Bias and offset where they were fitted, as an estimate holds them."""
    found: dict[str, Constant] = {}
    names = fitted.packing.names
    for name in ("bias", "offset"):
        if name in names:
            variance = float(fitted.covariance[names.index(name), names.index(name)])
            deviation = float(np.sqrt(variance)) if np.isfinite(variance) else np.inf
            found[name] = Constant(float(fitted.model.constants[name]), deviation)
    return found


def _whiteness(problem: Problem, fitted: Fitted) -> tuple[str, ...]:
    """A sentence where the residual is not white, as it is where a fit ends in another minimum."""
    if not np.all(np.isfinite(fitted.residual)):
        return ()
    p = problem.whiteness(fitted.residual, fitted.sensitivities)
    if p >= SURE:
        return ()
    coloured = f"{problem.kind.why_coloured}; or " if problem.kind.why_coloured else ""
    return (
        f"the residual is not white (p {equals_probability(p)}): {coloured}physics that is left out, or first values "
        "too far off; camid diagnose tells more",
    )
