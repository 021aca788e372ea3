"""SRIVC with symmetric instruments and step control: the default method."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import STABILITY_TOLERANCE
from camid.compiled import njit
from camid.identification.factorisation import factorise
from camid.identification.iteration_result import LARGEST_CONDITION, UNDETERMINED_SHARE, IterationResult
from camid.identification.least_squares import solve
from camid.identification.predictor import Predictor
from camid.identification.records import Records

Array = NDArray[np.float64]

# A step that changes the simulated output by less than this share of the residual decides nothing (the relative offset
# of Bates & Watts 1981), nor does one below the rounding error of the output itself.
OFFSET_TOLERANCE = 1e-6
ROUNDING = 1e-14
LARGEST_DAMPING = 1e8
# Shares of the promised gain below which a step was too long, and above which it may be longer.
BROKEN_PROMISE, KEPT_PROMISE = 0.25, 0.75
# Smallest share of a column's length beside the others for which Gram–Schmidt is as good as singular values.
SMALLEST_INDEPENDENT_SHARE = 1e-4
# Iterations between two reports of progress.
REPORTED_ITERATIONS = 10


@njit
def _is_stable(denominator: Array) -> bool:
    """As :func:`camid.identification.iteration_result.has_stable`; non-negative coefficients suffice to order two."""
    negative = False
    for coefficient in denominator:
        if not np.isfinite(coefficient):
            return False
        negative = negative or coefficient < 0.0
    if len(denominator) <= 3 and not negative:
        return True
    order = len(denominator) - 1
    matrix = np.zeros((order, order), dtype=np.complex128)
    for i in range(order):
        matrix[0, i] = -denominator[1 + i]
        if i + 1 < order:
            matrix[i + 1, i] = 1.0
    for root in np.linalg.eigvals(matrix):  # noqa: SIM110 - compiled code has no generators in all()
        if not root.real <= STABILITY_TOLERANCE * abs(root):
            return False
    return True


@njit(error_model="numpy")
def _decomposed(triangle: Array, moving: NDArray[np.int64]) -> tuple[Array, Array, Array, Array, NDArray[np.bool_]]:
    """Singular values and right vectors of the column-scaled instruments that move, the scale and the projections."""
    size = triangle.shape[0]
    # A column of zeros stands for no parameter at all where all are held, which no factorisation takes.
    columns = max(len(moving), 1)
    table, lengths, target = np.zeros((size, columns)), np.zeros(columns), np.empty(size)
    for i in range(size):
        target[i] = triangle[i, size - 1]
        for k in range(len(moving)):
            table[i, k] = triangle[i, moving[k]]
            lengths[k] += table[i, k] * table[i, k]
    for k in range(columns):
        lengths[k] = np.sqrt(lengths[k])
        if lengths[k] == 0.0:
            lengths[k] = 1.0
        for i in range(size):
            table[i, k] /= lengths[k]
    left, singular, right = np.linalg.svd(table, False)
    projected = left.T @ target
    kept = np.empty(len(singular), np.bool_)
    for k in range(len(singular)):
        # What the data do not determine at all must not move.
        kept[k] = singular[k] > singular[0] / LARGEST_CONDITION
        if not kept[k]:
            projected[k] = 0.0
    return singular, right, lengths, projected, kept


@njit
def _determined(right: Array, kept: NDArray[np.bool_], moving: NDArray[np.int64], coefficients: int) -> bool:
    """Whether directions that the data do not determine concern initial states alone."""
    for i in range(len(kept)):
        share = 0.0
        for k in range(len(moving)):
            if moving[k] < coefficients:
                share += right[i, k] ** 2
        if not kept[i] and share >= UNDETERMINED_SHARE**2:
            return False
    return True


@njit(error_model="numpy")
def _damped_step(
    singular: Array, right: Array, lengths: Array, projected: Array, kept: NDArray[np.bool_], damping: float
) -> tuple[Array, float]:
    """Damped step, and the decrease of the sum of squares that it promises."""
    step, promised = np.zeros(len(lengths)), 0.0
    for i in range(len(singular)):
        gain = singular[i] / (singular[i] * singular[i] + damping) if kept[i] else 0.0
        effect = singular[i] * gain * projected[i]
        promised += 2.0 * effect * projected[i] - effect * effect
        for k in range(len(lengths)):
            step[k] += gain * projected[i] * right[i, k]
    for k in range(len(lengths)):
        step[k] /= lengths[k]
    return step, promised


@njit
def _all_finite(triangle: Array) -> bool:
    for i in range(triangle.shape[0]):
        for j in range(triangle.shape[1]):
            if not np.isfinite(triangle[i, j]):
                return False
    return True


@njit
def _moving(free: NDArray[np.bool_], held: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Places of the parameters that are free and not held."""
    found = np.empty(len(free), np.int64)
    count = 0
    for j in range(len(free)):
        if free[j] and not held[j]:
            found[count] = j
            count += 1
    return found[:count]


@njit(error_model="numpy")
def _release(triangle: Array, held: NDArray[np.bool_], small: float) -> bool:
    """Let go the held coefficients that would lower the output error if they were larger; whether there are any."""
    last = triangle.shape[0] - 1
    released = False
    for j in range(last):
        if held[j]:
            power, slope = 0.0, 0.0
            for i in range(last + 1):
                power += triangle[i, j] * triangle[i, j]
                slope += triangle[i, j] * triangle[i, last]
            length = np.sqrt(power)
            if slope / (length if length > 0.0 else 1.0) > small:
                held[j] = False
                released = True
    return released


@njit
def _iterate(  # noqa: C901, PLR0912 - its steps share more variables than a call can return
    parameters: Array,
    free: NDArray[np.bool_],
    bounded: NDArray[np.bool_],
    held: NDArray[np.bool_],
    split: int,
    order: int,
    records: Records,
    time_unit: float,
    rounding: float,
    damping: float,
    maximum_iterations: int,
) -> tuple[Array, float, float, bool, bool, int]:
    """Parameters, cost, damping, whether converged, whether finished, iterations; ``held`` changes in place."""
    coefficients, count = split + order, len(parameters)
    residual = np.empty(len(records.signal))
    denominator, clipped = np.ones(order + 1), np.zeros(count, np.bool_)
    for i in range(order):
        denominator[1 + i] = parameters[split + i]
    triangle, cost = factorise(
        parameters[:split], denominator, parameters[coefficients:], records, time_unit, True, residual
    )
    if not np.isfinite(cost):
        return parameters, np.inf, damping, False, True, 0
    iteration = 0
    while iteration < maximum_iterations:
        iteration += 1
        moving = _moving(free, held)
        if not _all_finite(triangle):
            return parameters, cost, damping, False, True, iteration
        direct, left_over, offset, independence = solve(triangle, moving)
        well_conditioned = independence > SMALLEST_INDEPENDENT_SHARE and np.isfinite(left_over)
        determined = True
        if not well_conditioned or damping > 0.0:
            singular, right, lengths, projected, kept = _decomposed(triangle, moving)
            power = 0.0
            for value in projected:
                power += value * value
            offset = np.sqrt(power)  # effect of the undamped step on the simulated output
            determined = _determined(right, kept, moving, coefficients)
        small = max(OFFSET_TOLERANCE * np.sqrt(cost), rounding)
        if offset <= small:
            if _release(triangle, held, small):
                continue
            return parameters, cost, damping, determined, True, iteration
        accepted = False
        while not accepted and damping < LARGEST_DAMPING:
            if well_conditioned and damping == 0.0:
                step, promised = direct, offset * offset
            else:
                singular, right, lengths, projected, kept = _decomposed(triangle, moving)
                step, promised = _damped_step(singular, right, lengths, projected, kept, damping)
            trial = parameters.copy()
            for k in range(len(moving)):
                trial[moving[k]] += step[k]
            for j in range(count):
                clipped[j] = bounded[j] and trial[j] < 0.0
                if clipped[j]:
                    trial[j] = 0.0
            trial_cost = np.inf
            for i in range(order):
                denominator[1 + i] = trial[split + i]
            if _is_stable(denominator):
                trial_triangle, trial_cost = factorise(
                    trial[:split], denominator, trial[coefficients:], records, time_unit, True, residual
                )
            accepted = trial_cost < cost
            gained = (cost - trial_cost) / promised if accepted and promised > 0.0 else 0.0
            # A step that gains far less than promised overshoots: plain Gauss–Newton would then swing for ever.
            if gained < BROKEN_PROMISE:
                damping = max(4.0 * damping, 1e-3)
            elif gained > KEPT_PROMISE:
                damping = damping / 5.0 if damping > 1e-6 else 0.0
        if not accepted:
            # Only rounding was left to gain, or nothing that a step could do.
            return parameters, cost, damping, determined and offset <= 1e5 * rounding, True, iteration
        parameters, triangle, cost = trial, trial_triangle, trial_cost
        for j in range(count):
            held[j] = held[j] or clipped[j]
    return parameters, cost, damping, False, False, iteration


def safeguarded_srivc(
    predictor: Predictor,
    start: Array,
    *,
    maximum_iterations: int = 100,
    on_iteration: Callable[[int, float], None] | None = None,
) -> IterationResult:
    """SRIVC that cannot run away: symmetric instruments and a step that must lower the output error.

    Both this and plain SRIVC solve Σ ẑ_k (w_k − x_k) = 0 with the instruments ẑ = ∂x/∂θ. Plain SRIVC inverts Σ ẑ φᵀ,
    whose noisy regressors φ make the iteration lose its contraction near the Shannon frequency; Σ ẑ ẑᵀ (Young's
    symmetric form) has the same fixed points and makes each iteration a Gauss–Newton step, here damped as Levenberg and
    Marquardt do whenever the output error would grow. The instruments go through hold and sensor exactly, so nothing is
    assumed between samples. Denominator coefficients do not become negative, which keeps up to two poles in the stable
    region; with more, steps out of it are not taken.

    Parameters
    ----------
    predictor : Predictor
    start : ndarray
        Parameter vector in scaled units.
    maximum_iterations : int
    on_iteration : callable, optional
        Called now and then with the iteration and the sum of squared residuals, for progress.
    """
    split, order = predictor.structure.degree + 1, predictor.structure.order
    bounded = np.zeros(len(predictor.free), bool)
    bounded[split : split + order] = predictor.structure.free_denominator[1:]
    parameters = start.copy()
    # Coefficients held at zero, the limit of stability: an integrator or an undamped mode in noise.
    held = bounded & (parameters <= 0.0)
    parameters[held] = 0.0
    rounding = ROUNDING * predictor.target_norm
    damping, iterations, finished = 0.0, 0, False
    cost, converged = np.inf, False
    while not finished and iterations < maximum_iterations:
        batch = maximum_iterations if on_iteration is None else REPORTED_ITERATIONS
        parameters, cost, damping, converged, finished, done = _iterate(
            parameters,
            predictor.free,
            bounded,
            held,
            split,
            order,
            predictor.records,
            predictor.time_unit,
            rounding,
            damping,
            min(batch, maximum_iterations - iterations),
        )
        iterations += done
        if on_iteration is not None:
            on_iteration(iterations, cost)
    return IterationResult(parameters, cost, bool(converged), iterations)
