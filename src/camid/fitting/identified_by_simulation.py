"""Identification of a plant that the engine has to simulate: a pendulum, or one in a closed loop."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.fitting.identification_task import IdentificationTask
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.identification.estimate import Estimate
from camid.identification.identification import Identification


def identify_by_simulation(problem: Problem, task: IdentificationTask) -> Identification:
    """Output error through the engine, whatever the method asked for; in a closed loop the error of the control."""
    structure, kind = problem.structure, problem.kind
    nominal = Model(structure.coefficients(), constants=kind.constants())
    fitted = kind.refit(problem, problem.with_initial_states(nominal))
    count = int(np.count_nonzero(structure.free))
    covariance = structure.full_covariance(fitted.covariance[:count, :count])
    residuals = [e.output - s for e, s in zip(problem.experiments, problem.simulate(fitted.model), strict=True)]
    spread = float(np.std(problem.output)) or 1.0

    def error(rows: list[NDArray[np.bool_]]) -> float:
        values = np.concatenate([r[k] for r, k in zip(residuals, rows, strict=True)])
        return float(np.sqrt(np.mean(values**2))) / spread

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
    )
    return Identification(
        simulation=kind.written_back(task.believed, structure, fitted),
        estimate=estimate,
        converged=estimate.converged,
        period=task.recordings[0].period,
        rows_fitted=len(fitted.residual),
        nrmse=error([e.used for e in problem.experiments]),
        nrmse_validation=error(task.held_out) if any(k.any() for k in task.held_out) else None,
        acquisition=problem.acquisition,
        method=kind.method,
    )
