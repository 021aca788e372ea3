"""SRIVC with symmetric instruments and step control: the default method."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import STABILITY_TOLERANCE
from camid.compiled import njit
from camid.identification.factorisation import Records, factorise, solve
from camid.identification.iteration import LARGEST_CONDITION, UNDETERMINED_SHARE, IterationResult
from camid.identification.predictor import Predictor

Array = NDArray[np.float64]

# A step that changes the simulated output by less than this share of the residual decides nothing (the relative offset
# of Bates & Watts 1981), nor does one below the rounding error of the output itself.
OFFSET_TOLERANCE = 1e-6
ROUNDING = 1e-14
LARGEST_DAMPING = 1e8
# Shares of the promised gain below which a step was too long, and above which it may be longer.
BROKEN_PROMISE, KEPT_PROMISE = 0.25, 0.75
# Smallest share of a column's length beside the others for which Gram–Schmidt is as good as singular values.
SOUND = 1e-4
# Iterations between two reports of progress.
REPORTED_ITERATIONS = 10


@njit
def _is_stable(denominator: Array) -> bool:
    """As :func:`camid.identification.iteration.has_stable`; non-negative coefficients suffice up to the order two."""
    if not np.all(np.isfinite(denominator)):
        return False
    if len(denominator) <= 3 and np.all(denominator >= 0.0):
        return True
    order = len(denominator) - 1
    matrix = np.zeros((order, order), dtype=np.complex128)
    for i in range(order):
        matrix[0, i] = -denominator[1 + i]
        if i + 1 < order:
            matrix[i + 1, i] = 1.0
    roots = np.linalg.eigvals(matrix)
    return bool(np.all(roots.real <= STABILITY_TOLERANCE * np.abs(roots)))


@njit
def _decomposed(triangle: Array, moving: NDArray[np.int64]) -> tuple[Array, Array, Array, Array, NDArray[np.bool_]]:
    """Singular values and right vectors of the column-scaled instruments that move, the scale and the projections."""
    size = triangle.shape[0]
    # A column of zeros stands for no parameter at all where all are held, which no factorisation takes.
    table = np.zeros((size, max(len(moving), 1)))
    for k in range(len(moving)):
        table[:, k] = triangle[:, moving[k]]
    lengths = np.sqrt(np.sum(table * table, axis=0))
    lengths[lengths == 0.0] = 1.0
    left, singular, right = np.linalg.svd(table / lengths, False)
    # What the data do not determine at all must not move.
    kept = singular > np.max(singular) / LARGEST_CONDITION
    return singular, right, lengths, np.where(kept, left.T @ np.ascontiguousarray(triangle[:, size - 1]), 0.0), kept


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


@njit
def _damped_step(
    singular: Array, right: Array, lengths: Array, projected: Array, kept: NDArray[np.bool_], damping: float
) -> tuple[Array, float]:
    """Damped step, and the decrease of the sum of squares that it promises."""
    gain = np.where(kept, singular / (singular**2 + damping), 0.0)
    effect = singular * gain * projected
    step = np.zeros(len(lengths))
    for i in range(len(singular)):
        step += gain[i] * projected[i] * right[i]
    return step / lengths, float(np.sum(2.0 * effect * projected - effect * effect))


@njit
def _iterate(  # noqa: PLR0912, PLR0915 - a call between the parts would cost more than some of them
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
    denominator = np.ones(order + 1)
    denominator[1:] = parameters[split:coefficients]
    triangle, cost = factorise(
        parameters[:split], denominator, parameters[coefficients:], records, time_unit, True, residual
    )
    if not np.isfinite(cost):
        return parameters, np.inf, damping, False, True, 0
    iteration = 0
    while iteration < maximum_iterations:
        iteration += 1
        moving = np.flatnonzero(free & ~held)
        if not np.all(np.isfinite(triangle)):
            return parameters, cost, damping, False, True, iteration
        target = np.ascontiguousarray(triangle[:, count])
        direct, left_over, offset, independence = solve(triangle, moving)
        sound = independence > SOUND and np.isfinite(left_over)
        determined = True
        if not sound or damping > 0.0:
            singular, right, lengths, projected, kept = _decomposed(triangle, moving)
            offset = np.sqrt(np.sum(projected**2))  # effect of the undamped step on the simulated output
            determined = _determined(right, kept, moving, coefficients)
        small = max(OFFSET_TOLERANCE * np.sqrt(cost), rounding)
        if offset <= small:
            # A larger coefficient would lower the output error: a held one is then let go.
            released = False
            for j in np.flatnonzero(held):
                length = np.sqrt(np.sum(triangle[:, j] ** 2))
                if np.sum(triangle[:, j] * target) / (length if length > 0.0 else 1.0) > small:
                    held[j] = False
                    released = True
            if released:
                continue
            return parameters, cost, damping, determined, True, iteration
        accepted = False
        while not accepted and damping < LARGEST_DAMPING:
            if sound and damping == 0.0:
                step, promised = direct, offset * offset
            else:
                singular, right, lengths, projected, kept = _decomposed(triangle, moving)
                step, promised = _damped_step(singular, right, lengths, projected, kept, damping)
            trial = parameters.copy()
            trial[moving] += step[: len(moving)]
            clipped = bounded & (trial < 0.0)
            trial[clipped] = 0.0
            trial_cost = np.inf
            denominator[1:] = trial[split:coefficients]
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
        held |= clipped
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
