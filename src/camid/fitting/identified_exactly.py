"""Identification of a linear plant driven by a recorded input, with the tests of its residual."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction
from camid.fitting.identification_task import IdentificationTask
from camid.fitting.problem import Problem
from camid.identification.declaration_search import alternative_declarations
from camid.identification.estimate import Estimate, estimate
from camid.identification.experiment import Experiment
from camid.identification.identification import Identification
from camid.identification.residual_analysis import analyse_residual
from camid.identification.structure import Structure


def identify_exactly(problem: Problem, task: IdentificationTask) -> Identification:
    """Estimate, test the residual, and fit other declarations where it contradicts this one."""
    structure, experiments, progress = problem.structure, problem.experiments, task.progress
    result = estimate(structure, experiments, nominal=task.nominal, method=task.method, progress=progress)
    identification = _identification(task, result, experiments)
    return analysed(identification, structure, experiments, progress)


def _identification(task: IdentificationTask, result: Estimate, experiments: list[Experiment]) -> Identification:
    """The estimate as a simulation, with its errors."""
    believed, held_out = task.believed, task.held_out
    lead = believed.plant.denominator[0] if len(believed.plant.denominator) == result.plant.order + 1 else 1.0
    split = len(result.plant.numerator)
    deviations, covariance = abs(lead) * result.standard_deviations, np.square(lead) * result.covariance
    free_numerator, free_denominator = result.free[:split], np.concatenate([[False], result.free[split:]])
    if believed.input_column is None:  # the numerator was not fitted, but a recording with an input may fit it
        free_numerator = believed.free_numerator
    plant = TransferFunction(
        tuple(lead * b for b in result.plant.numerator), tuple(lead * a for a in result.plant.denominator)
    )
    model = replace(
        believed,
        plant=plant,
        exposure=experiments[0].acquisition.exposure if believed.sensor == "camera" else None,
        free_numerator=free_numerator,
        free_denominator=free_denominator,
        **_constants(result),
        # Where the data leave a coefficient undetermined there is no accuracy to write down.
        standard_deviations={
            "numerator": [float(v) for v in deviations[:split]],
            "denominator": [0.0, *(float(v) for v in deviations[split:])],
        }
        if np.all(np.isfinite(deviations))
        else None,
        covariance=covariance.tolist() if np.all(np.isfinite(covariance)) else None,
    )

    def nrmse(rows: list[NDArray[np.bool_]]) -> float:
        residual = np.concatenate([r[k] for r, k in zip(result.residuals, rows, strict=True)])
        recorded = np.concatenate([e.output[k] for e, k in zip(experiments, rows, strict=True)])
        spread = float(np.std(recorded))
        return float(np.sqrt(np.mean(residual**2))) / spread if spread > 0.0 else float("inf")

    fitted = [e.used for e in experiments]
    return Identification(
        simulation=model,
        estimate=result,
        converged=result.converged,
        period=task.recordings[0].period,
        rows_fitted=int(sum(k.sum() for k in fitted)),
        nrmse=nrmse(fitted),
        nrmse_validation=nrmse(held_out) if any(k.any() for k in held_out) else None,
        acquisition=experiments[0].acquisition,
    )


def _constants(result: Estimate) -> dict[str, Any]:
    """Offset and bias, where they were estimated, as a simulation holds them."""
    found: dict[str, Any] = {}
    for name, constant in (("offset", result.offset), ("bias", result.bias)):
        if constant is not None:
            known = np.isfinite(constant.standard_deviation)
            found[name] = constant.value
            found[f"{name}_deviation"] = constant.standard_deviation if known else None
    return found


def analysed(
    identification: Identification,
    wanted: Structure,
    experiments: list[Experiment],
    progress: Callable[[str], None] | None,
) -> Identification:
    """The identification with the tests of its residual and, where they contradict the declaration, with others."""
    plant = identification.estimate.plant
    try:
        analysis = analyse_residual(wanted, plant, experiments)
    except (ValueError, ArithmeticError):  # a method without safeguard diverged
        return identification
    alternatives = []
    if identification.converged and analysis is not None and analysis.contradicts:
        alternatives = alternative_declarations(wanted, plant, experiments, progress)
    return replace(identification, residual_analysis=analysis, alternatives=alternatives)
