"""Identification of a plant that is no linear chain behind a recorded input: a pendulum, or one in a closed loop."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.fitting.estimated_simulation import full_covariance, with_plant
from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.fitting.growing_horizon import fit_growing
from camid.fitting.refit import at_best_start
from camid.identification.estimate import Estimate
from camid.identification.experiment import Experiment
from camid.identification.result import Identification
from camid.recording.recording import Recording
from camid.simulation.model import Simulation


def identify_by_simulation(
    believed: Simulation,
    recordings: list[Recording],
    experiments: list[Experiment],
    held_out: list[NDArray[np.bool_]],
) -> Identification:
    """Output error through the engine; in a closed loop the error of the control.

    Parameters
    ----------
    believed : Simulation
        With a pendulum or a controller, without effects.
    recordings, experiments : list
        Of one rig, see :func:`camid.identification.loading.experiments_of`.
    held_out : list of ndarray of bool
        Validation rows.
    """
    structure = structure_of(believed)
    problem = problem_of(believed, structure, recordings, experiments)
    fitted = fit_growing(problem, at_best_start(problem, model_of(believed, structure, ())))
    count = int(np.count_nonzero(structure.free))
    covariance = full_covariance(structure, fitted.covariance[:count, :count])
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
        simulation=with_plant(believed, structure, fitted),
        estimate=estimate,
        converged=estimate.converged,
        period=recordings[0].period,
        rows_fitted=len(fitted.residual),
        nrmse=error([e.used for e in problem.experiments]),
        nrmse_validation=error(held_out) if any(k.any() for k in held_out) else None,
        acquisition=experiments[0].acquisition,
    )
