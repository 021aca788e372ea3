"""The check of a design: each rival is really fitted to what another would produce, not to first order only."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.experiment_design.hypothesis import Hypothesis, Played
from camid.experiment_design.prediction import FITTED_SHARE, NoiseModel
from camid.experiment_design.separation import Pair
from camid.fitting.fit import sensitivities
from camid.fitting.packing import Packing
from camid.fitting.problem import WORKERS

Array = NDArray[np.float64]

# Evaluations of one fit.
STEPS = 15
TOLERANCE = 1e-4


def refitted(hypotheses: Sequence[Hypothesis], played: Played, noise: NoiseModel, pairs: Sequence[Pair]) -> list[Pair]:
    """The same pairs with what each rival leaves after a fit; what a fit makes worse stays as it was."""
    truths = {}
    for i in {p.true for p in pairs}:
        problem, model = hypotheses[i].at(played)
        truths[i] = problem.pinned(model, finest=True).simulate_one(model, 0)

    def checked(pair: Pair) -> Pair:
        left = left_after_fit(hypotheses[pair.rival], truths[pair.true], played, noise)
        return replace(pair, left=min(left, pair.left) if np.isfinite(left) else pair.left)

    with ThreadPoolExecutor(WORKERS) as pool:
        return list(pool.map(checked, pairs))


def left_after_fit(rival: Hypothesis, truth: Array, played: Played, noise: NoiseModel) -> float:
    """What a rival leaves of an output, shape (N,), in variances of the noise, with its distance from what is known.

    Earlier recordings are there as a parabola around the rival's own parameters.
    """
    from scipy.optimize import least_squares

    problem, model = rival.at(played)
    problem = problem.pinned(model, finest=True)
    problem = replace(problem, experiments=[replace(problem.experiments[0], output=truth)])
    used = problem.experiments[0].used
    packing = Packing.of(problem, model)
    start = packing.pack(model)
    prior = rival.prior(packing) * np.outer(packing.units, packing.units)
    values, vectors = np.linalg.eigh(0.5 * (prior + prior.T))
    root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    share, recorded = np.sqrt(FITTED_SHARE), truth[used]
    worst = 1e3 * (float(np.ptp(recorded)) or 1.0)

    def simulated(vector: Array) -> Array:
        try:
            rows = problem.simulate_one(packing.unpack(vector), 0)[used]
        except (ValueError, ArithmeticError):
            return np.full(len(recorded), worst)
        return np.clip(np.nan_to_num(rows, nan=worst), -worst, worst)

    def residual(vector: Array) -> Array:
        rows = share * noise.whitened(recorded - simulated(vector))
        return np.concatenate([rows, root @ (vector - start)])

    def jacobian(vector: Array) -> Array:
        table = sensitivities(problem, packing, vector, simulated(vector))
        return np.vstack([-share * noise.whitened(table), root])

    begin = np.clip(start, packing.lower, packing.upper)
    found = least_squares(
        residual,
        begin,
        jac=jacobian,
        bounds=(packing.lower, packing.upper),
        x_scale="jac",
        ftol=TOLERANCE,
        max_nfev=STEPS,
    )
    return float(2.0 * found.cost)
