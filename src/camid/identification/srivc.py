"""Refined instrumental variables for continuous-time models (SRIVC), as published and safeguarded.

References
----------
Garnier, Gilson, Young, Huselstein (2007), Control Engineering Practice 15(4), 471–486 (the method that the paper used);
Young (2011), *Recursive Estimation and Time-Series Analysis*, ch. 8.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.chain import Acquisition, companion, derivative_rows, respond
from camid.identification.predictor import Predictor
from camid.plant import STABILITY_TOLERANCE

Array = NDArray[np.float64]

# A step that changes the simulated output by less than this share of the residual decides nothing (the relative offset
# of Bates & Watts 1981), nor does one below the rounding error of the output itself.
OFFSET_TOLERANCE = 1e-6
ROUNDING = 1e-14
LARGEST_CONDITION = 1e11
LARGEST_DAMPING = 1e8


@dataclass(frozen=True)
class Fit:
    """Where an iteration ended.

    Attributes
    ----------
    parameters : ndarray
        In the predictor's scaled units.
    cost : float
        Sum of squared differences between recorded and simulated output.
    converged : bool
    iterations : int
    """

    parameters: Array
    cost: float
    converged: bool
    iterations: int


def reflect(denominator: Array) -> Array:
    """Mirror roots with a positive real part into the left half plane (filters must be stable)."""
    roots = np.roots(denominator)
    if not np.any(roots.real > 0.0):
        return denominator
    return np.real(np.poly(np.where(roots.real > 0.0, -np.conj(roots), roots)))


def is_stable(denominator: Array) -> bool:
    """Whether no root lies clearly in the right half plane; integrators and undamped modes are stable here."""
    if not np.all(np.isfinite(denominator)):
        return False
    roots = np.roots(denominator)
    return bool(np.all(roots.real <= STABILITY_TOLERANCE * np.abs(roots)))


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
    between_samples = Acquisition(predictor.experiments[0].acquisition.period, "foh", "instant")
    tables, regressands = [], []
    position = split + order
    for experiment, output in zip(predictor.experiments, outputs, strict=True):
        unit = predictor.time_unit
        between_samples = replace(between_samples, period=experiment.acquisition.period)
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
            )
            position += order
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
        Parameter vector in scaled units; what is not free keeps its value.
    """
    order = predictor.structure.order
    filter_denominator = np.asarray(np.poly(np.full(order, -cut_off * predictor.time_unit)), dtype=np.float64)
    outputs = [e.output for e in predictor.experiments]
    regressors, regressand = _regression(predictor, filter_denominator, outputs)
    parameters = predictor.from_physical(predictor.structure.coefficients())
    free = predictor.free
    regressand = regressand - regressors[:, ~free] @ parameters[~free]
    parameters[free] = np.linalg.lstsq(regressors[:, free], regressand, rcond=None)[0]
    return parameters


def plain_srivc(predictor: Predictor, start: Array, *, maximum_iterations: int = 100, tolerance: float = 1e-8) -> Fit:
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
    recorded = [e.output for e in predictor.experiments]
    parameters = start.copy()
    converged, iterations = False, 0
    while iterations < maximum_iterations and not converged:
        iterations += 1
        filter_denominator = reflect(np.concatenate([[1.0], parameters[split : split + order]]))
        auxiliary = parameters.copy()
        auxiliary[split : split + order] = filter_denominator[1:]
        simulated = predictor.simulate(auxiliary)
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
        [x[e.used] for x, e in zip(predictor.simulate(parameters), predictor.experiments, strict=True)]
    )
    cost = _sum_of_squares(residual)
    stable = not np.any(np.roots(np.concatenate([[1.0], parameters[split : split + order]])).real > 0.0)
    return Fit(parameters, cost, converged and stable, iterations)


def safeguarded_srivc(
    predictor: Predictor,
    start: Array,
    *,
    maximum_iterations: int = 100,
    on_iteration: Callable[[int, float], None] | None = None,
) -> Fit:
    """SRIVC that cannot run away: symmetric instruments and a step that must lower the output error.

    Both methods solve Σ ẑ_k (w_k − x_k) = 0 with the instruments ẑ = ∂x/∂θ. Plain SRIVC inverts Σ ẑ φᵀ, whose noisy
    regressors φ make the iteration lose its contraction near the Shannon frequency; Σ ẑ ẑᵀ (Young's symmetric form) has
    the same fixed points and makes each iteration a Gauss–Newton step, here damped as Levenberg and Marquardt do
    whenever the output error would grow or the plant become unstable. The instruments go through hold and sensor
    exactly, so nothing is assumed between samples.

    Parameters
    ----------
    predictor : Predictor
    start : ndarray
        Parameter vector in scaled units.
    maximum_iterations : int
    on_iteration : callable, optional
        Called with the iteration and the sum of squared residuals, for progress.
    """
    free = predictor.free
    parameters = start.copy()
    residual, sensitivities = predictor.linearise(parameters)
    cost = _sum_of_squares(residual)
    rounding = ROUNDING * float(np.linalg.norm(predictor.target))
    if not np.isfinite(cost):
        return Fit(parameters, np.inf, False, 0)
    damping, converged, determined, iteration = 0.0, False, False, 0
    while iteration < maximum_iterations:
        iteration += 1
        instruments = sensitivities[:, free]
        lengths = np.linalg.norm(instruments, axis=0)
        lengths[lengths == 0.0] = 1.0
        left, singular, right = np.linalg.svd(instruments / lengths, full_matrices=False)
        # What the data do not determine at all must not move.
        kept = singular > singular[0] / LARGEST_CONDITION
        determined = bool(np.all(kept))
        projected = np.where(kept, left.T @ residual, 0.0)
        offset = float(np.linalg.norm(projected))  # effect of the undamped step on the simulated output
        if offset <= OFFSET_TOLERANCE * np.sqrt(cost) or offset <= rounding:
            converged = True
            break
        accepted = False
        while not accepted and damping < LARGEST_DAMPING:
            gain = np.where(kept, singular / (singular**2 + damping), 0.0)
            trial = parameters.copy()
            trial[free] += right.T @ (gain * projected) / lengths
            effect = singular * gain * projected
            promised = float(2.0 * effect @ projected - effect @ effect)
            trial_cost = np.inf
            if is_stable(predictor.split(trial)[1]):
                trial_residual, trial_sensitivities = predictor.linearise(trial)
                trial_cost = _sum_of_squares(trial_residual)
            accepted = trial_cost < cost
            kept_promise = (cost - trial_cost) / promised if accepted and promised > 0.0 else 0.0
            # A step that gains far less than promised overshoots: plain Gauss–Newton would then swing for ever.
            if kept_promise < 0.25:
                damping = max(4.0 * damping, 1e-3)
            elif kept_promise > 0.75:
                damping = damping / 5.0 if damping > 1e-6 else 0.0
        if not accepted:
            converged = offset <= 1e5 * rounding  # only rounding was left to gain
            break
        parameters, residual, sensitivities, cost = trial, trial_residual, trial_sensitivities, trial_cost
        if on_iteration is not None:
            on_iteration(iteration, cost)
    return Fit(parameters, cost, converged and determined, iteration)


def _sum_of_squares(residual: Array) -> float:
    """Infinite rather than a warning where an unstable trial overflows."""
    with np.errstate(over="ignore", invalid="ignore"):
        total = float(residual @ residual)
    return total if np.isfinite(total) else np.inf
