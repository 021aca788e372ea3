"""A smooth curve in a linear model: how much smoothing the data call for, and the evidence for a curve at all.

The values c of a curve have a Gaussian prior with the covariance ρ σ² R⁻¹, where R measures its roughness and σ² is
the variance of the noise. With what else is fitted projected out, the data r = C c + e have the marginal likelihood

    log p = −½ (Σ log(1 + ρ λ_i) + n log(S(ρ))),   S(ρ) = r·r − Σ g_i² ρ / (1 + ρ λ_i),

with the eigenvalues λ_i of L⁻¹ Cᵀ C L⁻ᵀ, R = L Lᵀ, and g = Vᵀ L⁻¹ Cᵀ r; σ² is integrated out with its scale-free prior
(Wahba 1990, Spline Models for Observational Data, chapter 4; MacKay 1992, Neural Computation 4, 415–447).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Ratios of the variances of curve and noise that are tried, in inverse eigenvalues.
RATIOS = np.geomspace(1e-3, 1e8, 67)


@dataclass(frozen=True)
class SmoothCurve:
    """A curve at the smoothing of most evidence.

    Attributes
    ----------
    values : ndarray, shape (m,)
        c, its posterior mean.
    covariance : ndarray, shape (m, m)
        Of c.
    ratio : float
        ρ, of the variances of the curve's prior and the noise.
    log_evidence : float
        log p, without constants that all curves of the same rows share.
    without : float
        The same without a curve.
    """

    values: Array
    covariance: Array
    ratio: float
    log_evidence: float
    without: float


def smooth_curve(table: Array, data: Array, roughness: Array, freedom: int) -> SmoothCurve:
    """The curve that the data call for.

    Parameters
    ----------
    table : ndarray, shape (M, m)
        C, what else is fitted projected out.
    data : ndarray, shape (M,)
        r, the same projected out.
    roughness : ndarray, shape (m, m)
        R, positive definite.
    freedom : int
        n, rows less the numbers that are projected out.
    """
    factor = np.linalg.cholesky(roughness)
    with np.errstate(over="ignore", invalid="ignore"):  # of a motion that runs away; its eigenvalues are refused
        products = np.linalg.solve(factor, np.linalg.solve(factor, table.T @ table).T)
    eigenvalues, vectors = np.linalg.eigh(0.5 * (products + products.T))
    eigenvalues = np.maximum(eigenvalues, 0.0)
    along = vectors.T @ np.linalg.solve(factor, table.T @ data)
    energy = max(float(data @ data), 1e-300)
    largest = float(eigenvalues[-1]) or 1.0
    best: tuple[float, float, float] | None = None
    for ratio in RATIOS / largest:
        left = max(energy - float(np.sum(along**2 * ratio / (1.0 + ratio * eigenvalues))), 1e-12 * energy)
        evidence = -0.5 * (float(np.sum(np.log1p(ratio * eigenvalues))) + freedom * float(np.log(left)))
        if best is None or evidence > best[0]:
            best = evidence, float(ratio), left
    assert best is not None
    evidence, ratio, left = best
    shrunk = ratio / (1.0 + ratio * eigenvalues)
    back = np.linalg.solve(factor.T, vectors)
    covariance = (back * shrunk) @ back.T * left / max(freedom, 1)
    return SmoothCurve(back @ (shrunk * along), covariance, ratio, evidence, -0.5 * freedom * float(np.log(energy)))
