"""The statistics that the tests of a residual rest on; camid.identification.residual_analysis says what they mean."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from camid.identification.experiment import Experiment

Array = NDArray[np.float64]

MOST_NOISE_COEFFICIENTS = 10
# Directions of the lagged inputs that are smaller than this share of the largest, or closer than this sine to the
# sensitivities, say nothing.
SMALLEST_INPUT, SMALLEST_SINE = 1e-3, 1e-2
SMALLEST_COLUMN = 1e-8
# Rows of lagged inputs that are multiplied at once: few enough for the cache, and for BLAS to stay on one core.
BLOCK = 256
# 99 % of a normal variable lie within this many standard deviations.
BOUND = 2.5758293035489004


@dataclass(frozen=True)
class Rows:
    """All experiments concatenated, zeros between them, so that no lag reaches from one into another.

    ``basis`` is orthonormal and spans the sensitivities and a constant for each experiment; ``residual`` is orthogonal
    to it, so that an estimate at a bound, or not quite converged, is tested as well as any other.
    """

    used: NDArray[np.bool_]
    signal: Array
    residual: Array
    basis: Array
    others: Array
    first_lag: int
    whitening: Array

    @classmethod
    def of(
        cls,
        experiments: Sequence[Experiment],
        residual: Array,
        table: Array,
        others: Array,
        lags: int,
        first_lag: int,
    ) -> Rows:
        """Concatenate experiments."""
        padding = first_lag + lags
        starts = np.cumsum([0, *(len(e.output) + padding for e in experiments)])
        used, signal = np.zeros(starts[-1], bool), np.zeros(starts[-1])
        constants = np.zeros((starts[-1], len(experiments)))
        for i, (start, experiment) in enumerate(zip(starts[:-1], experiments, strict=True)):
            part = slice(start, start + len(experiment.output))
            used[part], signal[part], constants[part, i] = experiment.used, experiment.signal, 1.0
        basis = np.zeros((starts[-1], table.shape[1] + len(experiments)))
        found = _orthonormal(np.hstack([table, constants[used]]))
        basis = basis[:, : found.shape[1]]
        basis[used] = found
        packed = np.zeros(starts[-1])
        packed[used] = residual - found @ (found.T @ residual)
        changes = np.zeros((starts[-1], others.shape[1]))
        changes[used] = others
        return cls(used, signal, packed, basis, changes, first_lag, np.ones(1))


def _orthonormal(table: Array) -> Array:
    """Orthonormal basis of the columns."""
    lengths = np.max(np.abs(table), axis=0)
    table = table[:, lengths > 0.0] / lengths[lengths > 0.0]
    table = table / np.linalg.norm(table, axis=0)
    left, triangle = np.linalg.qr(table)
    if np.min(np.abs(np.diag(triangle)), initial=1.0) > SMALLEST_COLUMN:
        return left
    left, singular, _ = np.linalg.svd(table, full_matrices=False)
    return left[:, singular > SMALLEST_COLUMN * singular[0]]


def sums_of_products(residual: Array, lags: int) -> Array:
    """Σ e_t e_{t-k} for k = 0 … lags."""
    return np.array([residual[k:] @ residual[: len(residual) - k] for k in range(lags + 1)])


@dataclass(frozen=True)
class Moments:
    """tr(MA_k) and tr(MA_jMA_k) for j, k = 0 … lags, and the number of pairs of rows at each lag."""

    first: Array
    second: Array
    pairs: Array

    @classmethod
    def of(cls, rows: Rows, lags: int) -> Moments:
        """Moments under white noise for the projection that the fit made."""
        used, basis = rows.used, rows.basis
        total, columns = basis.shape
        pairs = np.round(sums_of_products(used.astype(float), lags))
        products = np.array([basis[k:].T @ basis[: total - k] for k in range(lags + 1)])
        flat = basis.ravel()
        beyond = [flat[k * columns :] @ flat[: (total - k) * columns] for k in range(lags + 1, 2 * lags + 1)]
        own = np.concatenate([np.trace(products, axis1=1, axis2=2), beyond])
        first = -own[: lags + 1]
        first[0] += pairs[0]
        # tr(PA_jA_k) is a sum over all rows less one over those that are not fitted; padding rows are among these.
        lag = np.arange(lags + 1)
        everywhere = 0.5 * (own[np.abs(lag[:, None] - lag)] + own[lag[:, None] + lag])
        padded = np.zeros((total + 3 * lags, columns))
        padded[2 * lags : 2 * lags + total] = basis
        windows = sliding_window_view(padded, 2 * lags + 1, axis=0)
        near = np.cumsum(np.concatenate([np.zeros(2 * lags + 1), used, np.zeros(lags)]))
        missing = np.concatenate([np.ones(lags, bool), ~used]) & (near[2 * lags + 1 :] > near[: -2 * lags - 1])
        elsewhere = np.zeros_like(everywhere)
        for part in np.array_split(np.flatnonzero(missing), np.count_nonzero(missing) // BLOCK + 1):
            around = windows[part]
            shifted = (0.5 * (around[..., lags:] + around[..., lags::-1])).reshape(-1, lags + 1)
            elsewhere += shifted.T @ shifted
        inner = 0.5 * (products + products.transpose(0, 2, 1)).reshape(lags + 1, -1)
        second = np.diag(np.concatenate([pairs[:1], 0.5 * pairs[1:]]))
        second += inner @ inner.T - 2.0 * (everywhere - elsewhere)
        return cls(first, second, pairs)

    def of_autocorrelations(self) -> tuple[Array, Array]:
        """Mean and covariance of the autocorrelations at the lags 1 … under white noise."""
        freedom = self.first[0]
        mean = self.first[1:] / freedom
        products = 2.0 * self.second[1:, 1:] + np.outer(self.first[1:], self.first[1:])
        return mean, products / (freedom * (freedom + 2.0)) - np.outer(mean, mean)


def levinson(correlations: Array) -> tuple[list[Array], Array]:
    """Whitening filters of the orders 0, 1, … and the shares of the variance that they leave.

    Parameters
    ----------
    correlations : ndarray, shape (p + 1,)
        Autocorrelations at the lags 0 … p, the first being 1.
    """
    filters, reflections = _reflections(correlations)
    return filters, np.concatenate([[1.0], np.cumprod(1.0 - reflections**2)])


def _reflections(correlations: Array) -> tuple[list[Array], Array]:
    """Levinson's recursion: whitening filters of the orders 0, 1, …, and minus the partial autocorrelations.

    It ends early where the correlations stop being those of a process.
    """
    filters, found, left = [np.ones(1)], [], 1.0
    longer = np.zeros(len(correlations) + 1)
    longer[0] = 1.0
    for k in range(1, len(correlations)):
        reflection = -float(longer[:k] @ correlations[k:0:-1]) / left
        if not abs(reflection) < 1.0:
            break
        longer[: k + 1] += reflection * longer[k::-1]
        filters.append(longer[: k + 1].copy())
        found.append(reflection)
        left *= 1.0 - reflection**2
    return filters, np.array(found)


def whiteness(sums: Array, moments: Moments) -> float | None:
    """P-value of the hypothesis that the noise is white, by the partial autocorrelations of the residual."""
    from scipy.special import chdtrc

    mean, covariance = moments.of_autocorrelations()
    correlations = sums / sums[0]
    correlations[1:] -= mean
    reflections = _reflections(correlations)[1]
    if len(reflections) < len(mean):
        return 0.0
    try:
        statistic = float(reflections @ np.linalg.solve(covariance, reflections))
    except np.linalg.LinAlgError:
        return None
    return float(chdtrc(len(mean), statistic)) if statistic >= 0.0 else None


def noise_model(sums: Array, moments: Moments) -> tuple[Array, float]:
    """Whitening filter 1 + a_1 z⁻¹ + … of the noise, and the variance of what it leaves."""
    weights = np.full(len(sums), 2.0)
    weights[0] = 1.0
    # E eᵀA_k e = Σ_j γ_j tr(MA_kM(A_j + A_jᵀ)): solved for γ, then weighted as in a periodogram, which is positive.
    covariances = np.linalg.solve(moments.second * weights, sums) * moments.pairs / moments.pairs[0]
    count = moments.pairs[0]
    plain = (np.ones(1), sums[0] / moments.first[0])
    if covariances[0] <= 0.0:
        return plain
    filters, reflections = _reflections(covariances[: MOST_NOISE_COEFFICIENTS + 1] / covariances[0])
    deviances = count * np.log(np.cumprod(1.0 - reflections**2)) + np.log(count) * np.arange(1, len(reflections) + 1)
    if deviances.size == 0 or np.min(deviances) >= 0.0:
        return plain
    order = 1 + int(np.argmin(deviances))
    return filters[order], float(covariances[0] * np.prod(1.0 - reflections[:order] ** 2))


def independence(rows: Rows, lags: int) -> float | None:
    """P-value of the hypothesis that the residual does not depend on the inputs of the last ``lags`` samples."""
    from scipy.special import fdtrc

    if not np.any(rows.signal):
        return None
    order = len(rows.whitening) - 1
    used = rows.used.copy()
    for k in range(1, order + 1):  # rows whose past the filter knows
        used[k:] &= rows.used[:-k]
        used[:k] = False
    known = _orthonormal(_filtered(rows.whitening, rows.basis)[used])
    changes = _filtered(rows.whitening, rows.others)[used]
    sizes = np.linalg.norm(changes, axis=0)
    changes = changes[:, sizes > 0.0] / sizes[sizes > 0.0]
    changes -= known @ (known.T @ changes)
    squared_sines, directions = np.linalg.eigh(changes.T @ changes)
    kept = squared_sines > SMALLEST_SINE**2
    changes = changes @ (directions[:, kept] / np.sqrt(squared_sines[kept]))
    residual = _filtered(rows.whitening, rows.residual)[used]
    residual -= known @ (known.T @ residual)
    projected = changes.T @ residual
    residual -= changes @ projected
    regressand = np.zeros((len(used), known.shape[1] + changes.shape[1] + 1))
    regressand[used] = np.column_stack([known, changes, residual])
    padded = np.concatenate([np.zeros(rows.first_lag + lags), _filtered(rows.whitening, rows.signal)])
    inputs = sliding_window_view(padded, lags + 1)
    square, products = np.zeros((lags + 1, lags + 1)), np.zeros((lags + 1, regressand.shape[1]))
    for start in range(0, len(used), BLOCK):
        part = slice(start, min(start + BLOCK, len(used)))
        lagged = inputs[part] * used[part, None]
        square += lagged.T @ lagged
        products += lagged.T @ regressand[part]
    rank, explained = _quadratic_form(square, products[:, :-1], products[:, -1])
    forms = [(changes.shape[1], float(projected @ projected)), (rank, explained)]
    freedom = len(residual) - known.shape[1] - order - changes.shape[1] - rank
    if freedom < 1:
        return None
    unexplained = max(float(residual @ residual) - explained, np.finfo(float).tiny) / freedom
    found = [float(fdtrc(rank, freedom, form / rank / unexplained)) for rank, form in forms if rank]
    smallest = min(found, default=np.nan)
    # The smallest of independent p-values.
    return None if np.isnan(smallest) else -float(np.expm1(len(found) * np.log1p(-min(smallest, 1.0 - 1e-15))))


def _quadratic_form(square: Array, overlap: Array, product: Array) -> tuple[int, float]:
    """Rank and value of gᵀ(G − BBᵀ)⁺g, of G and the difference the directions that are not too small."""
    sizes = np.sqrt(np.diag(square))
    if not np.any(sizes > 0.0):
        return 0, 0.0
    sizes[sizes == 0.0] = 1.0
    square, overlap, product = square / np.outer(sizes, sizes), overlap / sizes[:, None], product / sizes
    difference = square - overlap @ overlap.T
    try:
        factor = np.linalg.cholesky(difference)
        if np.min(np.diag(factor)) > SMALLEST_SINE:
            return len(product), float(np.sum(np.linalg.solve(factor, product) ** 2))
    except np.linalg.LinAlgError:
        pass
    # An input of few frequencies, say.
    values, vectors = np.linalg.eigh(square)
    kept = values > SMALLEST_INPUT**2 * values[-1]
    vectors = vectors[:, kept] / np.sqrt(values[kept])
    squared_sines, directions = np.linalg.eigh(vectors.T @ difference @ vectors)
    kept = squared_sines > SMALLEST_SINE**2
    parts = (directions.T @ (vectors.T @ product))[kept]
    return int(np.count_nonzero(kept)), float(np.sum(parts**2 / squared_sines[kept]))


def _filtered(whitening: Array, values: Array) -> Array:
    """Values after the filter 1 + a_1 z⁻¹ + …, along the first axis."""
    result = values.copy()
    for k in range(1, len(whitening)):
        result[k:] += whitening[k] * values[:-k]
    return result


def autocorrelations_with_bounds(rows: Rows, lags: int) -> Array:
    """Autocorrelations less their mean, and their 99 % bounds; shape (2, lags + 1)."""
    mean, covariance = Moments.of(rows, lags).of_autocorrelations()
    sums = sums_of_products(rows.residual, lags)
    values = sums / sums[0]
    values[1:] -= mean
    return np.array([values, np.append(np.nan, BOUND * np.sqrt(np.diag(covariance)))])


def crosscorrelations_with_bounds(rows: Rows, lags: NDArray[np.int_]) -> Array:
    """Correlations Σ e_t u_{t-k} / (|e| |u|) and their 99 % bounds; shape (2, len(lags))."""
    from scipy.fft import next_fast_len, rfft

    total = len(rows.signal)
    length = next_fast_len(2 * total, real=True)
    spectrum = 1.0 / np.abs(rfft(rows.whitening, length)) ** 2
    innovations = _filtered(rows.whitening, rows.residual)[rows.used]
    variance = float(innovations @ innovations) / max(len(innovations) - rows.basis.shape[1], 1)
    found = np.full((2, len(lags)), np.nan)
    for i, lag in enumerate(lags):
        shifted = np.zeros(total)
        if lag >= 0:
            shifted[lag:] = rows.signal[: total - lag]
        else:
            shifted[:lag] = rows.signal[-lag:]
        shifted[~rows.used] = 0.0
        size = float(np.linalg.norm(rows.residual) * np.linalg.norm(shifted))
        if size > 0.0:
            shifted -= rows.basis @ (rows.basis.T @ shifted)
            power = np.abs(rfft(shifted, length)) ** 2 * spectrum
            # Parseval: ũᵀRũ, with every frequency of a real signal but the first (and last) counted twice.
            doubled = 2.0 * float(np.sum(power)) - float(power[0]) - (float(power[-1]) if length % 2 == 0 else 0.0)
            found[:, i] = rows.residual @ shifted / size, BOUND * np.sqrt(variance * doubled / length) / size
    return found
