"""Refined instrumental variables for continuous-time models (SRIVC) as published, and its start by LSSVF.

References
----------
Garnier, Gilson, Young, Huselstein (2007), Control Engineering Practice 15(4), 471–486 (the method that the paper used);
Young (2011), *Recursive Estimation and Time-Series Analysis*, ch. 8.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.companion_form import companion, derivative_rows
from camid.chain.exact import respond
from camid.identification.iteration_result import IterationResult, sum_of_squares
from camid.identification.predictor import Predictor

Array = NDArray[np.float64]


def reflect(denominator: Array) -> Array:
    """Mirror roots with a positive real part into the left half plane (filters must be stable)."""
    roots = np.roots(denominator)
    if not np.any(roots.real > 0.0):
        return denominator
    return np.real(np.poly(np.where(roots.real > 0.0, -np.conj(roots), roots)))


def filtered_derivatives(signal: Array, filter_denominator: Array, acquisition: Acquisition, unit: float) -> Array:
    """p^n/F, …, p/F, 1/F applied to a signal through hold and sensor, shape (N, n + 1)."""
    order = len(filter_denominator) - 1
    return respond(
        companion(filter_denominator),
        np.eye(order)[0],
        np.zeros(order),
        derivative_rows(filter_denominator, range(order, -1, -1)),
        signal,
        acquisition,
        unit,
    )


def _regression(predictor: Predictor, filter_denominator: Array, outputs: list[Array]) -> tuple[Array, Array]:
    """Prefiltered regressors [u-part, y-part, initial states] and regressand p^n/F y of all experiments.

    The sampled output is taken as joined by straight lines (first-order hold), the input goes through its own hold and
    the sensor: at convergence Σ a_i p^(n-i)/A = 1 and the equation error is exactly y − x, whatever joins the output.
    """
    order, split = predictor.structure.order, predictor.structure.degree + 1
    tables, regressands = [], []
    position = split + order
    for experiment, output in zip(predictor.experiments, outputs, strict=True):
        unit = predictor.time_unit
        between_samples = Acquisition(experiment.acquisition.period, "foh", "instant")
        derivatives = filtered_derivatives(output, filter_denominator, between_samples, unit)
        table = np.zeros((len(output), len(predictor.free)))
        table[:, :split] = filtered_derivatives(experiment.signal, filter_denominator, experiment.acquisition, unit)[
            :, order + 1 - split :
        ]
        table[:, split : split + order] = -derivatives[:, 1:]
        if experiment.estimate_initial_state:
            table[:, position : position + order] = respond(
                companion(filter_denominator),
                np.zeros(order),
                np.eye(order)[0],
                np.eye(order, order + 1),
                experiment.signal,
                experiment.acquisition,
                unit,
                before_record=experiment.free_motion_before_record,
            )
            position += order
        if predictor.records.sensor_offset:
            # A(p)/F of a constant is a_n/F of it, once the filter has settled.
            ones = np.ones(len(output))
            table[:, -1] = filtered_derivatives(ones, filter_denominator, between_samples, unit)[:, -1]
        tables.append(table[experiment.used])
        regressands.append(derivatives[experiment.used, 0])
    return np.concatenate(tables), np.concatenate(regressands)


def least_squares_state_variable_filter(predictor: Predictor, cut_off: float) -> Array:
    """LSSVF estimate: least squares on derivatives through the filter λ^n/(p + λ)^n.

    Parameters
    ----------
    predictor : Predictor
    cut_off : float
        λ in rad/s.

    Returns
    -------
    ndarray
        Parameter vector in scaled units; what is not free keeps its value. An unknown offset is taken into account and
        stands in it times the last coefficient of the denominator; an unknown bias is not.
    """
    order = predictor.structure.order
    filter_denominator = np.asarray(np.poly(np.full(order, -cut_off * predictor.time_unit)), dtype=np.float64)
    outputs = [e.position for e in predictor.experiments]
    regressors, regressand = _regression(predictor, filter_denominator, outputs)
    parameters = predictor.from_physical(predictor.structure.coefficients())
    free = predictor.free
    regressand = regressand - regressors[:, ~free] @ parameters[~free]
    parameters[free] = np.linalg.lstsq(regressors[:, free], regressand, rcond=None)[0]
    return parameters


def plain_srivc(
    predictor: Predictor, start: Array, *, maximum_iterations: int = 100, tolerance: float = 1e-8
) -> IterationResult:
    """SRIVC as the paper used it: no step control, so it may diverge near the Shannon frequency.

    Parameters
    ----------
    predictor : Predictor
    start : ndarray
        Parameter vector in scaled units, e.g. from :func:`least_squares_state_variable_filter`.
    maximum_iterations : int
    tolerance : float
        Largest relative change of a parameter that counts as convergence.
    """
    split, order = predictor.structure.degree + 1, predictor.structure.order
    free = predictor.free
    recorded = [e.position for e in predictor.experiments]
    parameters = start.copy()
    converged, iterations = False, 0
    while iterations < maximum_iterations and not converged:
        iterations += 1
        filter_denominator = reflect(np.concatenate([[1.0], parameters[split : split + order]]))
        auxiliary = parameters.copy()
        auxiliary[split : split + order] = filter_denominator[1:]
        known = [e.offset for e in predictor.experiments]
        simulated = [x - offset for x, offset in zip(predictor.simulate(auxiliary), known, strict=True)]
        regressors, regressand = _regression(predictor, filter_denominator, recorded)
        instruments, _ = _regression(predictor, filter_denominator, simulated)
        regressand = regressand - regressors[:, ~free] @ parameters[~free]
        try:
            estimate = np.linalg.solve(
                instruments[:, free].T @ regressors[:, free], instruments[:, free].T @ regressand
            )
        except np.linalg.LinAlgError:
            break
        if not np.all(np.isfinite(estimate)):
            break
        change = np.max(np.abs(estimate - parameters[free]) / np.maximum(np.abs(estimate), 1e-12))
        parameters = parameters.copy()
        parameters[free] = estimate
        converged = bool(change < tolerance)
    residual = predictor.target - np.concatenate(
        [x[e.used] - e.offset for x, e in zip(predictor.simulate(parameters), predictor.experiments, strict=True)]
    )
    cost = sum_of_squares(residual)
    stable = not np.any(np.roots(np.concatenate([[1.0], parameters[split : split + order]])).real > 0.0)
    return IterationResult(parameters, cost, converged and stable, iterations)
