"""Starting values: from none to within reach of the safeguarded iteration.

Three sources, each strong where the others are weak: state-variable filters (fast sampling), a discrete-time model with
its aliases (clean data, slow sampling, several modes), and a grid of poles whose numerator is solved for (variable
projection). All are ranked by the output error through hold and sensor; nothing else decides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.companion_form import time_scale
from camid.identification.discrete_time_start import HIGHEST_FREQUENCY, continuous_denominators, discrete_time_poles
from camid.identification.experiment import Experiment
from camid.identification.predictor import Predictor
from camid.identification.records import Records
from camid.identification.srivc import least_squares_state_variable_filter, reflect
from camid.identification.structure import Structure
from camid.identification.variable_projection import output_error_costs

Array = NDArray[np.float64]

LONGEST_START_WINDOW = 4096
CUT_OFFS = 8
MODE_DAMPING = (0.02, 0.1, 0.3, 0.6, 1.0, 3.0)
GRID_STEP = 1.25


@dataclass(frozen=True)
class StartCandidate:
    """A start and its output error.

    Attributes
    ----------
    denominator : ndarray, shape (n + 1,)
        Monic, in SI units.
    cost : float
        Sum of squared residuals with the best numerator.
    """

    denominator: Array
    cost: float


def start_window(experiment: Experiment) -> Experiment:
    """The most active stretch of a long experiment, with a free initial state if it starts later."""
    count = len(experiment.output)
    if count <= LONGEST_START_WINDOW:
        return experiment
    first_rows = np.arange(0, count - LONGEST_START_WINDOW + 1, LONGEST_START_WINDOW // 4)
    # Rows that are not fitted may be as active as they like.
    activity = [_activity(experiment, slice(b, b + LONGEST_START_WINDOW)) for b in first_rows]
    first = int(first_rows[int(np.argmax(activity))])
    part = slice(first, first + LONGEST_START_WINDOW)
    used = experiment.used[part].copy()
    if first > 0:
        used[: experiment.acquisition.window()[0]] = False
    return replace(
        experiment,
        signal=experiment.signal[part],
        output=experiment.output[part],
        used=used,
        estimate_initial_state=experiment.estimate_initial_state or first > 0,
    )


def _activity(experiment: Experiment, part: slice) -> float:
    """Sum of squares about the mean of the fitted rows of a stretch."""
    output = experiment.output[part][experiment.used[part]]
    return float(len(output) * np.var(output)) if len(output) else 0.0


def output_errors_of(structure: Structure, records: Records, denominators: Sequence[Array]) -> list[StartCandidate]:
    """Output errors of monic denominators in SI units, numerator and initial states solved for."""
    if not denominators:
        return []
    costs = output_error_costs(
        np.ascontiguousarray(denominators, dtype=np.float64),
        np.ascontiguousarray(structure.numerator, dtype=np.float64),
        structure.free_numerator,
        records.linear_unknowns(structure.order),
        records,
    )
    return [StartCandidate(d, float(c)) for d, c in zip(denominators, costs, strict=True)]


# -- state-variable filters -------------------------------------------------------------------------------------------


def cut_offs(experiments: list[Experiment]) -> Array:
    """Cut-offs in rad/s from the slowest to the fastest that records can show."""
    period = experiments[0].acquisition.period
    count = max(len(e.output) for e in experiments)
    return np.geomspace(4.0 * np.pi / (count * period), 2.0 * np.pi / period, CUT_OFFS)


def from_state_variable_filters(structure: Structure, experiments: list[Experiment], records: Records) -> list[Array]:
    """LSSVF denominators for cut-offs from the slowest to the fastest that the record can show."""
    found = []
    for cut_off in cut_offs(experiments):
        predictor = Predictor(structure, experiments, 1.0 / cut_off, records)
        parameters = predictor.to_physical(least_squares_state_variable_filter(predictor, cut_off))
        denominator = np.concatenate([[1.0], parameters[structure.degree + 1 :]])
        if np.all(np.isfinite(denominator)):
            found.append(reflect(denominator))
    return found


# -- grid -------------------------------------------------------------------------------------------------------------


def mode_grid(period: float, count: int, *, aliases: bool) -> Array:
    """Denominators of single modes that cover frequency and damping, shape (frequencies, dampings, 3)."""
    lowest, highest = np.pi / (count * period), (HIGHEST_FREQUENCY if aliases else 1.0) * np.pi / period
    steps = int(np.ceil(np.log(highest / lowest) / np.log(GRID_STEP))) + 1
    frequencies = np.geomspace(lowest, highest, steps)
    # Near and past the Shannon frequency the bands of one alias are narrower than a geometric step.
    frequencies = np.union1d(frequencies, np.arange(0.6, highest * period / np.pi, 0.08) * np.pi / period)
    frequency, damping = np.meshgrid(frequencies, MODE_DAMPING, indexing="ij")
    return np.stack([np.ones_like(frequency), 2.0 * damping * frequency, frequency**2], axis=-1)


def pole_grid(period: float, count: int) -> Array:
    """Denominators of single real poles, shape (16, 2)."""
    poles = np.geomspace(1.0 / (count * period), 2.0 * np.pi / period, 16)
    return np.stack([np.ones_like(poles), poles], axis=-1)


def _products(polynomial: Array, factors: Array) -> Array:
    """Products of a polynomial with each of many of one degree, shape (factors, coefficients)."""
    products = np.zeros((len(factors), len(polynomial) + factors.shape[1] - 1))
    for i in range(factors.shape[1]):
        products[:, i : i + len(polynomial)] += np.outer(factors[:, i], polynomial)
    return products


def single_modes(structure: Structure, experiments: list[Experiment], records: Records) -> list[Array]:
    """Denominators of order two at the local minima of the output error over frequency, each with its best damping."""
    grid = _grid_for(experiments)
    costs = np.array([c.cost for c in output_errors_of(structure, records, list(grid.reshape(-1, 3)))]).reshape(
        grid.shape[:2]
    )
    over_frequency = np.concatenate([[np.inf], costs.min(axis=1), [np.inf]])
    lowest = np.flatnonzero(
        (over_frequency[1:-1] <= over_frequency[:-2]) & (over_frequency[1:-1] <= over_frequency[2:])
    )
    return [grid[i, int(np.argmin(costs[i]))] for i in lowest]


def _grid_for(experiments: list[Experiment]) -> Array:
    aliases = any(np.any(e.signal) for e in experiments)
    return mode_grid(experiments[0].acquisition.period, max(len(e.output) for e in experiments), aliases=aliases)


def from_grid(structure: Structure, experiments: list[Experiment], records: Records, kept: int = 3) -> list[Array]:
    """Grow the denominator by a mode (or a pole) at a time, keeping the best few."""
    if structure.order == 2:
        return single_modes(structure, experiments, records)
    period = experiments[0].acquisition.period
    count = max(len(e.output) for e in experiments)
    modes = _grid_for(experiments).reshape(-1, 3)
    grown = [np.ones(1)]
    while len(grown[0]) - 1 < structure.order:
        missing = structure.order - (len(grown[0]) - 1)
        parts = modes if missing >= 2 else pole_grid(period, count)
        polynomials = [product for base in grown for product in _products(base, parts)]
        size = len(polynomials[0]) - 1
        partial = structure if size == structure.order else Structure.of_order(size, size - 1)
        ranked = sorted(output_errors_of(partial, records, polynomials), key=lambda c: c.cost)
        grown = [c.denominator for c in ranked[: kept if size < structure.order else 2 * kept]]
    return grown


# -- all together -----------------------------------------------------------------------------------------------------


def discrete_time_candidates(
    structure: Structure, experiments: list[Experiment], records: Records
) -> list[StartCandidate]:
    """Starts from discrete-time models and their aliases, best first."""
    denominators: list[Array] = []
    for experiment in experiments:
        aliases = bool(np.any(experiment.signal))
        for poles in discrete_time_poles(experiment, structure.order):
            denominators += continuous_denominators(poles, experiment.acquisition.period, aliases=aliases)
    return rank(structure, records, denominators)


def filter_candidates(structure: Structure, experiments: list[Experiment], records: Records) -> list[StartCandidate]:
    """Starts from state-variable filters, best first."""
    return rank(structure, records, from_state_variable_filters(structure, experiments, records))


def grid_candidates(structure: Structure, experiments: list[Experiment], records: Records) -> list[StartCandidate]:
    """Starts from the grid, best first."""
    return rank(structure, records, from_grid(structure, experiments, records))


def rank(structure: Structure, records: Records, denominators: Sequence[Array]) -> list[StartCandidate]:
    """Candidates of the right order in ascending output error, near duplicates left out."""
    candidates = output_errors_of(
        structure,
        records,
        [
            d
            for d in denominators
            if len(d) == structure.order + 1 and np.all(np.isfinite(d)) and np.isfinite(time_scale(d))
        ],
    )
    distinct: list[StartCandidate] = []
    for candidate in sorted(candidates, key=lambda c: c.cost):
        same = any(
            np.all(np.abs(candidate.denominator - other.denominator) <= 1e-3 * np.abs(other.denominator))
            for other in distinct
        )
        if np.isfinite(candidate.cost) and not same:
            distinct.append(candidate)
    return distinct
