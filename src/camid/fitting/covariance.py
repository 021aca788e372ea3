"""How well a recording determines what was fitted to it.

A standard deviation says how the sum of squares rises over its own width. Where a law has an edge, its derivative at a
point does not: the output of an edge that is moved by next to nothing changes in the few rows that lie just there, and
with the steps of an integrator. Differences over a standard deviation to either side say it, and for laws that are
smooth they are the derivatives (Bates & Watts 1988, Nonlinear Regression Analysis and Its Applications, chapter 6).
Where the two differ, the less sure one is stated.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from camid.fitting.step_profile import jumping_places, with_jumps
from camid.identification.autoregression import coloured
from camid.side_by_side import in_threads

if TYPE_CHECKING:
    from camid.fitting.fit import Fitted

Array = NDArray[np.float64]

# Largest difference that is taken, in what a parameter is measured by: mostly its own value.
LARGEST_STEP = 0.3


def covariance_of(fitted: Fitted) -> Array:
    """Covariance of the packed parameters in their own units, shape (p, p); infinite where undetermined.

    Of least squares in coloured noise it is the sandwich (Ljung 1999, section 9.4 and appendix II).

    Parameters
    ----------
    fitted : Fitted
    """
    jumping = jumping_places(fitted)
    kept = np.setdiff1d(np.arange(len(fitted.packing.names)), list(jumping))
    found = np.zeros((len(fitted.packing.names),) * 2)
    found[np.ix_(kept, kept)] = _without_jumps(fitted, kept)
    return with_jumps(fitted, found, jumping)


def _without_jumps(fitted: Fitted, kept: NDArray[np.int64]) -> Array:
    """Covariance of some of the packed parameters, by derivatives and secants, the others being known."""
    local = _from_derivatives(fitted, fitted.sensitivities[:, kept])
    if not any(effect.numeric() for effect in fitted.model.effects):
        return local
    deviations = np.full(len(fitted.packing.names), np.inf)
    deviations[kept] = np.sqrt(np.maximum(np.diag(local), 0.0))
    secants = _secants(fitted, deviations)[:, kept]
    wide = np.sqrt(np.maximum(np.diag(_from_derivatives(fitted, secants)), 0.0))
    deviations = deviations[kept]
    # Of a number that is hardly determined the secants say nothing, and the point is all there is.
    known = (deviations > 0.0) & np.isfinite(deviations) & np.isfinite(wide)
    growth = np.ones(len(deviations))
    growth[known] = np.maximum(wide[known] / deviations[known], 1.0)
    return local * np.outer(growth, growth)


def _secants(fitted: Fitted, deviations: Array) -> Array:
    """Changes of the simulated output, shape (M, p), over a standard deviation of each parameter to either side.

    Where one cannot be moved, or is not determined, it is the derivative.
    """
    packing, problem, table = fitted.packing, fitted.problem, fitted.sensitivities.copy()
    vector = packing.pack(fitted.model)
    steps = np.minimum(deviations / packing.units, LARGEST_STEP)

    def secant(i: int) -> Array | None:
        ends = np.clip(vector[i] + np.array([-steps[i], steps[i]]), packing.lower[i], packing.upper[i])
        outputs = []
        for end in ends:
            moved = vector.copy()
            moved[i] = end
            try:
                outputs.append(problem.simulate_fitted(packing.unpack(moved)))
            except (ValueError, ArithmeticError):
                return None
        change = (outputs[1] - outputs[0]) / ((ends[1] - ends[0]) * packing.units[i])
        return change if np.all(np.isfinite(change)) else None

    moving = [
        i
        for i, name in enumerate(packing.names)
        if np.isfinite(deviations[i]) and deviations[i] > 0.0 and not name.startswith("initial")
    ]
    for i, column in zip(moving, in_threads(secant, moving), strict=True):
        if column is not None:
            table[:, i] = column
    return table


def _from_derivatives(fitted: Fitted, table: Array) -> Array:
    """Covariance from derivatives of the simulated output, shape (M, p)."""
    innovations = fitted.problem.whitened(fitted.residual, fitted.noise.whitening)
    residual = fitted.residual
    if fitted.weighted:
        table, residual = fitted.problem.whitened(table, fitted.noise.whitening), innovations
    lengths = np.linalg.norm(table, axis=0)
    moving = lengths > 0.0
    result = np.full((len(lengths), len(lengths)), np.inf)
    if not moving.any():
        return result
    scaled = table[:, moving] / lengths[moving]
    alone = scaled
    if fitted.nuisance is not None and not fitted.weighted:
        # What the other numbers could do of a column says nothing of its parameter.
        inner = fitted.nuisance.T @ fitted.nuisance + np.eye(fitted.nuisance.shape[1])
        alone = scaled - fitted.nuisance @ np.linalg.solve(inner, fitted.nuisance.T @ scaled)
    variance = float(residual @ residual) / max(len(residual) - len(lengths), 1)
    products = alone.T @ scaled
    inverse = np.linalg.pinv(0.5 * (products + products.T), rcond=1e-12)
    if fitted.weighted or len(fitted.noise.whitening) == 1:
        inverse = inverse * variance
    else:
        # Noise e = H ε has the covariance σ² H Hᵀ; Hᵀ runs backwards through the rows.
        carried = coloured(alone[::-1], fitted.noise.whitening)
        spread = float(innovations @ innovations) / max(len(residual) - len(lengths), 1)
        inverse = inverse @ (carried.T @ carried) @ inverse * spread
    result[np.ix_(moving, moving)] = inverse / np.outer(lengths[moving], lengths[moving])
    return result


def effect_deviations(fitted: Fitted) -> list[dict[str, float | None]]:
    """Standard deviations of every effect's parameters; None where the data leave one undetermined."""
    variances = np.diag(fitted.covariance).copy()
    for place, deviation in fitted.onset_deviations.items():
        variances[place] = max(deviation**2, variances[place])
    found: list[dict[str, float | None]] = []
    period = float(fitted.problem.acquisition.period)
    for i, effect in enumerate(fitted.model.effects):
        least = effect.least_deviations(period)
        row: dict[str, float | None] = {}
        for parameter in effect.numeric():
            variance = float(variances[fitted.packing.names.index(f"{i} {parameter.name}")])
            known = np.isfinite(variance) and variance >= 0.0
            row[parameter.name] = max(float(np.sqrt(variance)), least.get(parameter.name, 0.0)) if known else None
        found.append(row)
    return found
