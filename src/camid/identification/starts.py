"""Starting values: from none to within reach of the safeguarded iteration.

Three sources, each strong where the others are weak: state-variable filters (fast sampling), a discrete-time model with
its aliases (clean data, slow sampling, several modes), and a grid of poles whose numerator is solved for (variable
projection). All are ranked by the output error through hold and sensor; nothing else decides.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from camid.chain import time_scale
from camid.identification.predictor import Experiment, Predictor, Structure
from camid.identification.srivc import least_squares_state_variable_filter, reflect

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

LONGEST_START_WINDOW = 4096
CUT_OFFS = 8
# How far past the Shannon frequency π/T a mode is looked for, in units of π/T: a held input leaves no alias.
HIGHEST_FREQUENCY = 2.6
MODE_DAMPING = (0.02, 0.1, 0.3, 0.6, 1.0, 3.0)
GRID_STEP = 1.25
MOST_ALIAS_COMBINATIONS = 64


@dataclass(frozen=True)
class Candidate:
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
    """The liveliest stretch of a long experiment, with a free initial state if it begins later."""
    count = len(experiment.output)
    if count <= LONGEST_START_WINDOW:
        return experiment
    begins = np.arange(0, count - LONGEST_START_WINDOW + 1, LONGEST_START_WINDOW // 4)
    activity = [np.var(experiment.output[b : b + LONGEST_START_WINDOW]) for b in begins]
    begin = int(begins[int(np.argmax(activity))])
    part = slice(begin, begin + LONGEST_START_WINDOW)
    used = experiment.used[part].copy()
    if begin > 0:
        used[: experiment.acquisition.window()[0]] = False
    return replace(
        experiment,
        signal=experiment.signal[part],
        output=experiment.output[part],
        used=used,
        estimate_initial_state=experiment.estimate_initial_state or begin > 0,
    )


def evaluate(structure: Structure, experiments: list[Experiment], denominator: Array) -> Candidate:
    """Output error of a monic denominator in SI units, numerator and initial states solved for."""
    predictor = Predictor.around(structure, experiments, denominator)
    scaled = denominator * predictor.time_unit ** np.arange(len(denominator))
    return Candidate(denominator, predictor.solve_numerator(scaled)[1])


# -- state-variable filters -------------------------------------------------------------------------------------------


def from_state_variable_filters(structure: Structure, experiments: list[Experiment]) -> list[Array]:
    """LSSVF denominators for cut-offs from the slowest to the fastest that the record can show."""
    period = experiments[0].acquisition.period
    count = max(len(e.output) for e in experiments)
    found = []
    for cut_off in np.geomspace(4.0 * np.pi / (count * period), 2.0 * np.pi / period, CUT_OFFS):
        predictor = Predictor(structure, experiments, 1.0 / cut_off)
        parameters = predictor.to_physical(least_squares_state_variable_filter(predictor, cut_off))
        denominator = np.concatenate([[1.0], parameters[structure.degree + 1 :]])
        if np.all(np.isfinite(denominator)):
            found.append(reflect(denominator))
    return found


# -- discrete-time model and its aliases ------------------------------------------------------------------------------


def discrete_time_poles(experiment: Experiment, order: int, iterations: int = 8) -> list[ComplexArray]:
    """Poles of discrete-time models: ARX (exact on clean data), then Steiglitz–McBride (consistent in white noise)."""
    from scipy.signal import lfilter

    delay, _, _, straddles = experiment.acquisition.window()
    lags = range(max(delay - 2, 0), delay + order + 1 + straddles)
    first = max(order, lags[-1])
    count = len(experiment.output)
    if count - first < 2 * (order + len(lags)):
        return []
    if not np.any(experiment.signal):
        lags = range(0)
    used = experiment.used[first:]
    denominator = np.eye(order + 1)[0]
    poles: list[ComplexArray] = []
    for _ in range(iterations):
        output = lfilter([1.0], denominator, experiment.output)
        signal = lfilter([1.0], denominator, experiment.signal)
        columns = [-output[first - i : count - i] for i in range(1, order + 1)]
        columns += [signal[first - i : count - i] for i in lags]
        solution = np.linalg.lstsq(np.column_stack(columns)[used], output[first:][used], rcond=None)[0]
        roots = np.roots(np.concatenate([[1.0], solution[:order]]))
        if len(roots) < order or not np.all(np.isfinite(roots)):
            break
        roots = np.where(np.abs(roots) > 1.0, 1.0 / np.conj(roots), roots)  # the filter must be stable
        denominator = np.real(np.poly(roots))
        poles.append(np.asarray(roots, dtype=complex))
    return [poles[0], poles[-1]] if poles else []


def continuous_denominators(poles: ComplexArray, period: float, *, aliases: bool) -> list[Array]:
    """Monic denominators in SI units whose sampled poles are the given ones.

    A complex pair at the angle φ may be a mode at φ/T, (2π − φ)/T, (2π + φ)/T, …; a negative real pole can only come
    from a mode at π/T.
    """
    choices: list[list[tuple[complex, ...]]] = []
    negative = [z for z in poles if abs(z.imag) < 1e-9 and z.real <= 0.0]
    for z in poles:
        if z.imag > 1e-9:
            real, angle = np.log(abs(z)), np.angle(z)
            angles = [angle, 2 * np.pi - angle, 2 * np.pi + angle] if aliases else [angle]
            choices.append([(complex(real, a) / period, complex(real, -a) / period) for a in angles])
        elif abs(z.imag) <= 1e-9 and z.real > 0.0:
            choices.append([(complex(np.log(max(z.real, 1e-12))) / period,)])
    while len(negative) >= 2:
        first, second = negative.pop(), negative.pop()
        real = 0.5 * np.log(max(abs(first * second), 1e-12))
        angles = [0.9 * np.pi, np.pi] if not aliases else list(np.arange(0.6, 2.5, 0.2) * np.pi)
        choices.append([(complex(real, a) / period, complex(real, -a) / period) for a in angles])
    if negative:
        choices.append([(complex(-3.0 / period),)])
    combinations = list(product(*choices))[:MOST_ALIAS_COMBINATIONS]
    return [np.real(np.poly(np.concatenate([np.array(p) for p in c]))) for c in combinations]


def folded_denominator(denominator: Array, period: float) -> Array:
    """Denominator with every mode past the Shannon frequency moved to the slower one with the same sampled poles."""
    roots = np.roots(denominator)
    turn = 2.0 * np.pi / period
    frequency = np.abs((roots.imag + 0.5 * turn) % turn - 0.5 * turn)
    return np.real(np.poly(roots.real + 1j * np.sign(roots.imag) * frequency))


# -- grid -------------------------------------------------------------------------------------------------------------


def mode_grid(period: float, count: int, *, aliases: bool) -> list[Array]:
    """Denominators of single modes that cover frequency and damping."""
    lowest, highest = np.pi / (count * period), (HIGHEST_FREQUENCY if aliases else 1.0) * np.pi / period
    steps = int(np.ceil(np.log(highest / lowest) / np.log(GRID_STEP))) + 1
    frequencies = np.geomspace(lowest, highest, steps)
    # Near and past the Shannon frequency the bands of one alias are narrower than a geometric step.
    frequencies = np.union1d(frequencies, np.arange(0.6, highest * period / np.pi, 0.08) * np.pi / period)
    return [np.array([1.0, 2.0 * d * w, w**2]) for d in MODE_DAMPING for w in frequencies]


def pole_grid(period: float, count: int) -> list[Array]:
    """Denominators of single real poles."""
    return [np.array([1.0, p]) for p in np.geomspace(1.0 / (count * period), 2.0 * np.pi / period, 16)]


def from_grid(structure: Structure, experiments: list[Experiment], kept: int = 3) -> list[Array]:
    """Grow the denominator by a mode (or a pole) at a time, keeping the best few."""
    period = experiments[0].acquisition.period
    count = max(len(e.output) for e in experiments)
    aliases = any(np.any(e.signal) for e in experiments)
    modes = mode_grid(period, count, aliases=aliases)
    grown = [np.ones(1)]
    while len(grown[0]) - 1 < structure.order:
        missing = structure.order - (len(grown[0]) - 1)
        parts = modes if missing >= 2 else pole_grid(period, count)
        polynomials = [np.asarray(np.polymul(base, part), dtype=np.float64) for base in grown for part in parts]
        size = len(polynomials[0]) - 1
        partial = structure if size == structure.order else Structure.of_order(size, size - 1)
        ranked = sorted((evaluate(partial, experiments, p) for p in polynomials), key=lambda c: c.cost)
        grown = [c.denominator for c in ranked[: kept if size < structure.order else 2 * kept]]
    return grown


# -- all together -----------------------------------------------------------------------------------------------------


def quick_candidates(structure: Structure, experiments: list[Experiment]) -> list[Candidate]:
    """Starts from filters and discrete-time models, best first."""
    denominators = from_state_variable_filters(structure, experiments)
    for experiment in experiments:
        aliases = bool(np.any(experiment.signal))
        for poles in discrete_time_poles(experiment, structure.order):
            denominators += continuous_denominators(poles, experiment.acquisition.period, aliases=aliases)
    return rank(structure, experiments, denominators)


def grid_candidates(structure: Structure, experiments: list[Experiment]) -> list[Candidate]:
    """Starts from the grid, best first."""
    return rank(structure, experiments, from_grid(structure, experiments))


def rank(structure: Structure, experiments: list[Experiment], denominators: list[Array]) -> list[Candidate]:
    """Candidates of the right order in ascending output error, near duplicates left out."""
    candidates = [
        evaluate(structure, experiments, d)
        for d in denominators
        if len(d) == structure.order + 1 and np.all(np.isfinite(d)) and np.isfinite(time_scale(d))
    ]
    distinct: list[Candidate] = []
    for candidate in sorted(candidates, key=lambda c: c.cost):
        same = any(np.allclose(candidate.denominator, other.denominator, rtol=1e-3, atol=0.0) for other in distinct)
        if np.isfinite(candidate.cost) and not same:
            distinct.append(candidate)
    return distinct
