"""SRIVC with symmetric instruments and step control: the default method."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.identification.fit import (
    LARGEST_CONDITION,
    Fit,
    is_stable,
    leaves_coefficients_determined,
    sum_of_squares,
)
from camid.identification.predictor import Predictor

Array = NDArray[np.float64]

# A step that changes the simulated output by less than this share of the residual decides nothing (the relative offset
# of Bates & Watts 1981), nor does one below the rounding error of the output itself.
OFFSET_TOLERANCE = 1e-6
ROUNDING = 1e-14
LARGEST_DAMPING = 1e8
# Shares of the promised gain below which a step was too long, and above which it may be longer.
BROKEN_PROMISE, KEPT_PROMISE = 0.25, 0.75


@dataclass(frozen=True)
class _NormalEquations:
    """Σ ẑ ẑᵀ δ = Σ ẑ (w − x) for the coefficients that move, by singular values of the column-scaled instruments."""

    singular: Array
    right: Array
    lengths: Array
    projected: Array
    kept: NDArray[np.bool_]

    @classmethod
    def of(cls, instruments: Array, residual: Array) -> _NormalEquations:
        lengths = np.linalg.norm(instruments, axis=0)
        lengths[lengths == 0.0] = 1.0
        left, singular, right = np.linalg.svd(instruments / lengths, full_matrices=False)
        # What the data do not determine at all must not move.
        kept = singular > singular[:1] / LARGEST_CONDITION
        return cls(singular, right, lengths, np.where(kept, left.T @ residual, 0.0), kept)

    def step(self, damping: float) -> tuple[Array, float]:
        """Damped step, and the decrease of the sum of squares that it promises."""
        gain = np.where(self.kept, self.singular / (self.singular**2 + damping), 0.0)
        effect = self.singular * gain * self.projected
        return (
            self.right.T @ (gain * self.projected) / self.lengths,
            float(2.0 * effect @ self.projected - effect @ effect),
        )


def safeguarded_srivc(
    predictor: Predictor,
    start: Array,
    *,
    maximum_iterations: int = 100,
    on_iteration: Callable[[int, float], None] | None = None,
) -> Fit:
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
        Called with the iteration and the sum of squared residuals, for progress.
    """
    coefficients = len(predictor.structure.free)
    bounded = np.zeros(len(predictor.free), bool)
    bounded[predictor.structure.degree + 1 : coefficients] = predictor.structure.free_denominator[1:]
    parameters = start.copy()
    # Coefficients held at zero, the limit of stability: an integrator or an undamped mode in noise.
    held = bounded & (parameters <= 0.0)
    parameters[held] = 0.0
    residual, sensitivities = predictor.linearise(parameters)
    cost = sum_of_squares(residual)
    rounding = ROUNDING * float(np.linalg.norm(predictor.target))
    if not np.isfinite(cost):
        return Fit(parameters, np.inf, False, 0)
    damping, converged, determined, iteration = 0.0, False, False, 0
    while iteration < maximum_iterations:
        iteration += 1
        moving = predictor.free & ~held
        equations = _NormalEquations.of(sensitivities[:, moving], residual)
        determined = leaves_coefficients_determined(
            equations.right[~equations.kept], np.flatnonzero(moving) < coefficients
        )
        offset = float(np.linalg.norm(equations.projected))  # effect of the undamped step on the simulated output
        small = max(OFFSET_TOLERANCE * np.sqrt(cost), rounding)
        if offset <= small:
            released = held & _pushed_inwards(sensitivities, residual, small)
            if not released.any():
                converged = True
                break
            held &= ~released
            continue
        accepted = False
        while not accepted and damping < LARGEST_DAMPING:
            step, promised = equations.step(damping)
            trial = parameters.copy()
            trial[moving] += step
            clipped = bounded & (trial < 0.0)
            trial[clipped] = 0.0
            trial_cost = np.inf
            if is_stable(predictor.split(trial)[1]):
                trial_residual, trial_sensitivities = predictor.linearise(trial)
                trial_cost = sum_of_squares(trial_residual)
            accepted = trial_cost < cost
            gained = (cost - trial_cost) / promised if accepted and promised > 0.0 else 0.0
            # A step that gains far less than promised overshoots: plain Gauss–Newton would then swing for ever.
            if gained < BROKEN_PROMISE:
                damping = max(4.0 * damping, 1e-3)
            elif gained > KEPT_PROMISE:
                damping = damping / 5.0 if damping > 1e-6 else 0.0
        if not accepted:
            converged = offset <= 1e5 * rounding  # only rounding was left to gain
            break
        parameters, residual, sensitivities, cost = trial, trial_residual, trial_sensitivities, trial_cost
        held |= clipped
        if on_iteration is not None:
            on_iteration(iteration, cost)
    return Fit(parameters, cost, converged and determined, iteration)


def _pushed_inwards(sensitivities: Array, residual: Array, small: float) -> NDArray[np.bool_]:
    """Whether a larger coefficient would lower the output error: a held one is then let go."""
    lengths = np.linalg.norm(sensitivities, axis=0)
    lengths[lengths == 0.0] = 1.0
    return np.asarray(sensitivities.T @ residual / lengths > small)
