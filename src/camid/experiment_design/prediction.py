"""What hypotheses predict of an experiment, and what is left of their differences after each was fitted to another.

If the first hypothesis is right, the recording is its output f_h and noise of variance σ². The second, which would then
be fitted, leaves on average, with the first order of its output around its own parameters,

    D = min over δ of ‖W (f_h − f_g − S_g δ)‖² / σ² + δᵀ Λ_g δ

in addition to the noise: W whitens it, S_g are the sensitivities to all that is free, Λ_g is the Fisher information of
the earlier recordings, which have to be explained by the same parameters. Without the minimum a design would promise
what the fit then absorbs (Hunter & Reiner 1965, Technometrics 7, 307–323; Atkinson & Fedorov 1975, Biometrika 62,
57–70).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.residual.validation_rows import VALIDATION_SHARE
from camid.experiment_design.hypothesis import Hypothesis, Played
from camid.fitting.output_error import sensitivities
from camid.fitting.packing import Packing
from camid.side_by_side import in_threads

Array = NDArray[np.float64]

# Rows of an experiment whose simulation takes longer than handing it to a thread.
ROWS_WORTH_A_THREAD = 3000

# Rows of an experiment that a diagnosis fits; the others judge.
FITTED_SHARE = 1.0 - VALIDATION_SHARE
# Directions of the parameters that carry less information than this share of the largest say nothing.
SMALLEST_INFORMATION = 1e-12
# Times at which the growth of the evidence is known.
TIMES = 40


@dataclass(frozen=True)
class NoiseModel:
    """Noise of the sensor: standard deviation of its innovations in units of y, and the filter that whitens it."""

    deviation: float
    whitening: Array

    def whitened(self, rows: Array) -> Array:
        """Rows, shape (N,) or (N, p), in standard deviations of white noise."""
        if len(self.whitening) == 1:
            return np.asarray(rows / self.deviation)
        order = len(self.whitening) - 1
        filtered = np.zeros(np.shape(rows))
        for lag, share in enumerate(self.whitening):
            filtered[order:] += share * rows[order - lag : len(rows) - lag]
        return np.asarray(filtered / self.deviation)


@dataclass(frozen=True)
class Response:
    """What one hypothesis predicts of an experiment.

    Attributes
    ----------
    hypothesis : Hypothesis
    output : ndarray, shape (N,)
    table : ndarray, shape (N, p)
        Sensitivities in standard deviations of the noise, to parameters measured by ``packing.units``.
    prior : ndarray, shape (p, p)
        What is known of them before.
    packing : Packing
    pull : ndarray, shape (p,), optional
        Half of the derivative of the earlier recordings' sum of squares; none where the hypothesis fits them best.
    """

    hypothesis: Hypothesis
    output: Array
    table: Array
    prior: Array
    packing: Packing
    pull: Array | None = None

    @cached_property
    def information(self) -> Array:
        """Of both, shape (p, p)."""
        return self.prior + FITTED_SHARE * (self.table.T @ self.table)

    def left_of(self, difference: Array) -> float:
        """D of a whitened difference of outputs, shape (N,), on the rows that would be fitted."""
        along = FITTED_SHARE * (self.table.T @ difference) - (0.0 if self.pull is None else self.pull)
        left = FITTED_SHARE * float(difference @ difference) - float(along @ solved(self.information, along))
        return max(left + self.hypothesis.beyond, 0.0)

    def growth(self, difference: Array, rows: NDArray[np.int64]) -> Array:
        """The same if the experiment ended after so many rows, shape (K,)."""
        bounds = np.concatenate([[0], rows])
        found, products, along, square = [], self.prior.copy(), np.zeros(len(self.prior)), 0.0
        for first, last in pairwise(bounds):
            part = self.table[first:last]
            products += FITTED_SHARE * (part.T @ part)
            along += FITTED_SHARE * (part.T @ difference[first:last])
            square += FITTED_SHARE * float(difference[first:last] @ difference[first:last])
            found.append(max(square - float(along @ solved(products, along)), 0.0))
        return np.array(found)

    def deviations(self, *, with_experiment: bool) -> Array:
        """Standard deviations of the parameters in their own units, shape (p,), with or without the experiment.

        Infinite for what is not determined.
        """
        products = self.information if with_experiment else self.prior
        lengths = np.sqrt(np.maximum(np.diag(products), 0.0))
        result = np.full(len(lengths), np.inf)
        moving = lengths > 0.0
        if moving.any():
            scaled = products[np.ix_(moving, moving)] / np.outer(lengths[moving], lengths[moving])
            values, vectors = np.linalg.eigh(0.5 * (scaled + scaled.T))
            dead = values < SMALLEST_INFORMATION * values[-1]
            open_ = np.any(np.abs(vectors[:, dead]) > 1e-3, axis=1)
            variances = (vectors[:, ~dead] ** 2 / values[~dead]).sum(axis=1)
            result[moving] = np.where(open_, np.inf, np.sqrt(variances)) / lengths[moving]
        return np.asarray(result * self.packing.units)


def solved(products: Array, right: Array) -> Array:
    """Solution of normal equations, shape (p,), without what carries no information."""
    if not len(right):
        return right
    lengths = np.sqrt(np.maximum(np.diag(products), 0.0))
    lengths[lengths == 0.0] = 1.0
    values, vectors = np.linalg.eigh(products / np.outer(lengths, lengths))
    kept = values > SMALLEST_INFORMATION * max(values[-1], 1e-300)
    return np.asarray(vectors[:, kept] @ ((vectors[:, kept].T @ (right / lengths)) / values[kept]) / lengths)


def travelled(hypothesis: Hypothesis, played: Played) -> tuple[float, float]:
    """Least and largest reading of the position that a hypothesis predicts; infinite where it runs away."""
    problem, model = hypothesis.at(played)
    problem = problem.pinned(model, finest=False)
    with np.errstate(all="ignore"):
        ((position, _),) = problem.motion(model)
    offset = model.constants.get("offset", 0.0)
    if not np.all(np.isfinite(position)):
        return -np.inf, np.inf
    return float(position.min()) + offset, float(position.max()) + offset


def response(hypothesis: Hypothesis, played: Played, noise: NoiseModel) -> Response:
    """What a hypothesis predicts.

    Raises
    ------
    ValueError
        If its simulation runs away.
    """
    problem, model = hypothesis.at(played)
    problem = problem.pinned(model, finest=False)
    used = problem.experiments[0].used
    output = problem.simulate_one(model, 0)
    if not np.all(np.isfinite(output)):
        raise ValueError(f"the simulation of {hypothesis.identifier} runs away")
    # What parameters are measured by follows from the output.
    problem = replace(problem, experiments=[replace(problem.experiments[0], output=output)])
    packing = Packing.of(problem, model)
    vector = packing.pack(model)
    table = np.zeros((len(output), len(vector)))
    free = np.flatnonzero(hypothesis.free(packing))
    table[np.ix_(used, free)] = sensitivities(problem, packing, vector, output[used], free.tolist())
    prior = hypothesis.prior(packing) * np.outer(packing.units, packing.units)
    pull = None if hypothesis.slope is None else hypothesis.pull(packing) * packing.units
    return Response(hypothesis, output, noise.whitened(table), prior, packing, pull)


def responses(hypotheses: Sequence[Hypothesis], played: Played, noise: NoiseModel) -> list[Response]:
    """What all hypotheses predict."""
    short = len(played.signal) < ROWS_WORTH_A_THREAD
    respond = partial(response, played=played, noise=noise)
    return [respond(h) for h in hypotheses] if short else in_threads(respond, hypotheses)
