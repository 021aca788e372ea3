"""The check of a design: each rival is really fitted to what another would produce, not to first order only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from camid.experiment_design.hypothesis import Hypothesis, Played
from camid.experiment_design.other_values import around
from camid.experiment_design.prediction import FITTED_SHARE, NoiseModel, Response
from camid.experiment_design.separation import Pair, most_left, values_of
from camid.experiment_design.together import REFRESHES, Earlier, Together
from camid.fitting.output_error import sensitivities
from camid.fitting.packing import Packing
from camid.fitting.updated_derivative import LatestOutputs, UpdatedDerivative
from camid.side_by_side import side_by_side

Array = NDArray[np.float64]

# Evaluations of one fit.
STEPS = 15
# Share of what was expected below which what a rival leaves after a fit is news to a search.
NEWS = 0.8
TOLERANCE = 1e-4
# Values from which a fit to all recordings starts, evaluations of each with few steps of the integrator, and of the
# best one.
STARTS, FIRST_STEPS, LAST_STEPS = 3, 6, 10


@dataclass(frozen=True)
class Past:
    """Earlier recordings, and what each hypothesis leaves of them in variances of the noise."""

    earlier: Earlier
    sums: Sequence[float]


def refitted_together(
    hypotheses: Sequence[Hypothesis],
    played: Played,
    noise: NoiseModel,
    pairs: Sequence[Pair],
    found: Sequence[Response],
    past: Past,
) -> tuple[list[Pair], list[Hypothesis]]:
    """The same with rivals that are fitted to the earlier recordings and the experiment, from several values.

    Parameters
    ----------
    hypotheses : sequence of Hypothesis
    played : Played
    noise : NoiseModel
    pairs : sequence of Pair
    found : sequence of Response
        Of the hypotheses, and behind them of their other values.
    past : Past

    Returns
    -------
    list of Pair, list of Hypothesis
        The second are rivals with the values that leave less than was expected.
    """
    truths = {}
    for i in {p.true for p in pairs}:
        problem, model = hypotheses[i].at(played)
        truths[i] = problem.pinned(model, finest=True).simulate_one(model, 0)

    every = side_by_side(partial(_refitted_together, hypotheses, found, played, noise, past, truths), pairs)
    return [pair for pair, _ in every], [moved for _, moved in every if moved is not None]


def _refitted_together(
    hypotheses: Sequence[Hypothesis],
    found: Sequence[Response],
    played: Played,
    noise: NoiseModel,
    past: Past,
    truths: Mapping[int, Array],
    pair: Pair,
) -> tuple[Pair, Hypothesis | None]:
    rival, true = hypotheses[pair.rival], hypotheses[pair.true]
    starts = _starts(found, pair, noise)
    whole, vector, cost = _least(rival, starts, past.earlier, (played, truths[pair.true], noise))
    left = max(cost - past.sums[pair.rival], 0.0)
    if not np.isfinite(left) or left >= pair.left:
        return pair, None
    alone = Together(rival, past.earlier)
    model = replace(whole.packing.unpack(vector), initial=alone.packing.template.initial)
    moved = around(alone, alone.packing.pack(model), past.sums[pair.rival])
    return replace(pair, left=min(left, most_left(true, rival))), moved if left < NEWS * pair.left else None


def _starts(found: Sequence[Response], pair: Pair, noise: NoiseModel) -> list[Hypothesis]:
    """A rival's own values, and the others that leave least of a difference to first order."""
    truth = noise.whitened(found[pair.true].output)
    others = [k for k in values_of(found, found[pair.rival].hypothesis) if k != pair.rival]
    others.sort(key=lambda k: found[k].left_of(truth - noise.whitened(found[k].output)))
    return [found[k].hypothesis for k in (pair.rival, *others[: STARTS - 1])]


def _least(
    rival: Hypothesis, starts: Sequence[Hypothesis], earlier: Earlier, experiment: tuple[Played, Array, NoiseModel]
) -> tuple[Together, Array, float]:
    """The fit of a rival to all recordings that leaves least, its values, and its sum of squares."""
    rough, fine = Together(rival, earlier, *experiment), Together(rival, earlier, *experiment, finest=True)
    initial = rough.packing.template.initial
    begins = [rough.packing.pack(replace(s.model, initial=initial)) for s in starts]
    if len(begins) > 1:
        tried = [rough.least(begin, FIRST_STEPS) for begin in begins]
        begins = [min(tried, key=lambda one: one[1])[0]]
    vector, cost = fine.least(begins[0], LAST_STEPS)
    return fine, vector, cost


def refitted(hypotheses: Sequence[Hypothesis], played: Played, noise: NoiseModel, pairs: Sequence[Pair]) -> list[Pair]:
    """The same pairs with what each rival leaves after a fit; what a fit makes worse stays as it was.

    Earlier recordings are there to second order; see :func:`refitted_together`.
    """
    truths = {}
    for i in {p.true for p in pairs}:
        problem, model = hypotheses[i].at(played)
        truths[i] = problem.pinned(model, finest=True).simulate_one(model, 0)

    return side_by_side(partial(_refitted, hypotheses, played, noise, truths), pairs)


def _refitted(
    hypotheses: Sequence[Hypothesis], played: Played, noise: NoiseModel, truths: Mapping[int, Array], pair: Pair
) -> Pair:
    left = left_after_fit(hypotheses[pair.rival], truths[pair.true], played, noise)
    return replace(pair, left=min(left, pair.left) if np.isfinite(left) else pair.left)


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

    def simulate(vector: Array) -> Array:
        try:
            rows = problem.simulate_one(packing.unpack(vector), 0)[used]
        except (ValueError, ArithmeticError):
            return np.full(len(recorded), worst)
        return np.clip(np.nan_to_num(rows, nan=worst), -worst, worst)

    simulated = LatestOutputs(simulate)

    def residual(vector: Array) -> Array:
        rows = share * noise.whitened(recorded - simulated(vector))
        return np.concatenate([rows, root @ (vector - start)])

    derivative = UpdatedDerivative(partial(sensitivities, problem, packing), REFRESHES)

    def jacobian(vector: Array) -> Array:
        table = derivative.at(vector, simulated(vector))
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
