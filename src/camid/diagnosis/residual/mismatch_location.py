"""Locate what is left of a residual: at which place of the chain, when, at which frequencies, at which values.

For each place the residual is regressed on what a fault there could look like, whatever its law: functions of the input
at the actuator and of position and velocity at the plant (as forces, filtered through the plant and the camera), slow
functions of time as a disturbance, functions of the simulated output at the sensor. What the plant's coefficients can
imitate is projected off first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.diagnosis import Location
from camid.diagnosis.finding import Finding
from camid.diagnosis.learned_part import LearnedPart
from camid.diagnosis.search.screening import Metric, metrics
from camid.diagnosis.weights import UNLISTED
from camid.effects import known_effects
from camid.effects.base import PLACES
from camid.fitting.fit import Fitted
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.identification.welch import cross_spectrum

Array = NDArray[np.float64]

# Directions of a regression that are smaller than this share of the largest say nothing.
SMALLEST_DIRECTION = 1e-4
# Square of a direction of columns of length one that is rounding.
ROUNDING = 1e-12
# Knots of piecewise linear functions.
FEW_KNOTS, MANY_KNOTS = 5, 14
WINDOWS = 16
# Span of time or band of frequency that is worth naming: most of the energy in less than half of the range.
MOST_ENERGY = 0.8
SHARE_OF_RANGE = 0.5


@dataclass(frozen=True)
class PlaceTest:
    """Regression on what a fault at a place looks like.

    Attributes
    ----------
    place, question : str
    p_value : float
    share : float
        Of the residual's structured sum of squares that it explains, degrees of freedom counted.
    gain : float
        Explained sum of squares beyond chance, in noise variances.
    """

    place: str
    question: str
    p_value: float
    share: float
    gain: float


QUESTIONS = {
    "actuator": "Does the residual depend on the input, as the actuator would pass it on?",
    "plant": "Does the residual look like a force that depends on position and velocity?",
    "disturbance": "Does the residual look like a force that depends on time?",
    "sensor": "Does the residual depend on the position in the image?",
}


def _scaled(values: Array) -> Array:
    spread = float(np.std(values)) or 1.0
    return (values - float(np.mean(values))) / spread


def _hinges(values: Array, count: int) -> list[Array]:
    """Piecewise linear functions of a signal with this many knots at its quantiles."""
    knots = np.quantile(values, np.linspace(0.0, 1.0, count + 2)[1:-1])
    return [np.maximum(values - k, 0.0) for k in knots]


def _polynomials(count: int, degree: int) -> list[Array]:
    from numpy.polynomial.legendre import legvander

    return list(legvander(np.linspace(-1.0, 1.0, count), degree).T)


def _like_the_actuator(signal: Array, position: Array, velocity: Array) -> list[Array]:
    """Forces that depend on the input, or whose gain depends on position or velocity, as a motor's does."""
    y, v, earlier = position, velocity, np.concatenate([[0.0], signal[:-1]])
    held = [*_hinges(signal, FEW_KNOTS), np.abs(signal), np.sign(signal), signal**3]
    held += [earlier, np.concatenate([[0.0, 0.0], signal[:-2]]), np.abs(signal) * earlier]
    return held + [signal * f for f in (*_hinges(y, MANY_KNOTS), y**2, v, v**2, np.abs(v), np.abs(y))]


def _like_the_plant(signal: Array, position: Array, velocity: Array) -> list[Array]:
    """Forces that depend on position and velocity."""
    y, v = position, velocity
    moved = [y**2, y**3, v**2, v**3, y * v, y**2 * v, y * v**2, np.abs(v) * v, np.tanh(5.0 * v), np.tanh(30.0 * v)]
    moved += [*_hinges(y, MANY_KNOTS), *_hinges(v, MANY_KNOTS), np.abs(y) * v, np.abs(y), y**4 * v, np.sign(v) * y]
    return moved + [f * g for f in _hinges(y, FEW_KNOTS) for g in _hinges(v, FEW_KNOTS)]


def _like_a_disturbance(signal: Array, position: Array, velocity: Array) -> list[Array]:
    """Forces that depend on the time, slowly."""
    return _polynomials(len(signal), 10)


def _rate(values: Array) -> Array:
    """Change in a row, to second order, from it and the two before it."""
    earlier = np.concatenate([values[:1], values[:1], values])
    return 1.5 * earlier[2:] - 2.0 * earlier[1:-1] + 0.5 * earlier[:-2]


def _like_the_sensor(output: Array) -> list[Array]:
    """What depends on the position in the image, its rate and the time.

    Rates come from the rows before: where somebody else's controller answers the noise of a row, the motion after it
    does so, too, and would seem to explain that noise.
    """
    count, output = len(output), _scaled(output)
    rate = _rate(output)
    rate = rate / (float(np.std(rate)) or 1.0)
    time = np.linspace(0.0, 1.0, count)
    seen = [np.ones(count), output**2, output**3, *_hinges(output, MANY_KNOTS), output * rate, rate, rate**2]
    return [*seen, time, time * rate, _rate(rate)]


FORCES = {"actuator": _like_the_actuator, "plant": _like_the_plant, "disturbance": _like_a_disturbance}


def regressors(problem: Problem, fitted: Fitted, motions: Sequence[tuple[Array, Array]], place: str) -> Array:
    """What a fault at a place looks like on the fitted rows, shape (M, c).

    Parameters
    ----------
    problem : Problem
    fitted : Fitted
    motions : sequence of (ndarray, ndarray)
        Position and velocity of each recording.
    place : str
    """
    parts = []
    for index, experiment in enumerate(problem.experiments):
        if place in problem.kind.hidden_places:
            columns = [np.zeros(len(experiment.signal))]
        elif place == "sensor":
            columns = _like_the_sensor(problem.kind.position_seen(problem, fitted.model, index, motions[index][0]))
        else:
            signal = _input_without_noise(problem, fitted.model, index)
            signal = signal / (float(np.max(np.abs(signal), initial=0.0)) or 1.0)
            forces = FORCES[place](signal, *(_scaled(s) for s in motions[index]))
            hold = problem.chain(fitted.model, index).declared().hold if place == "actuator" else "foh"
            columns = problem.kind.force_responses(problem, fitted.model, index, forces, hold)
        parts.append(np.column_stack([column[experiment.used] for column in columns]))
    return problem.as_compared(np.concatenate(parts))


def _input_without_noise(problem: Problem, model: Model, index: int) -> Array:
    """Input of a recording, shape (N,), that owes nothing to the noise of its output.

    In a closed loop that is the simulated control: the recorded one answers the noise, and would seem to explain it.
    """
    signal, kind = problem.experiments[index].signal, problem.kind
    if kind.loop(index) is None:
        return signal
    control = kind.output_and_control(problem.chain(model, index), signal, problem.times[index])[1]
    return signal if control is None else control


def places(problem: Problem, fitted: Fitted, spread: Array | None = None) -> list[PlaceTest]:
    """Tests of every place, in the metric of the noise.

    Parameters
    ----------
    problem : Problem
    fitted : Fitted
    spread : ndarray, shape (M,), optional
        Relative standard deviation of the noise in each row, where it is uneven: a few rows in which it is large would
        look like a structure.
    """
    motions = problem.motion(fitted.model)
    if spread is None:
        view = metrics(problem, fitted)[-1]
    else:
        whitening = problem.noise(fitted.residual / spread, len(fitted.packing.names)).whitening
        view = Metric.of(problem, fitted, whitening, spread, _bend_of_the_reading(problem, fitted, motions))
    # One table at a time: each is as long as the recordings, and tens of columns wide.
    return [_place_test(problem, view, place, regressors(problem, fitted, motions, place)) for place in QUESTIONS]


def places_needed(problem: Problem, fitted: Fitted, tests: Sequence[PlaceTest], level: float) -> list[str]:
    """The place that explains most of the structure, and each further one that explains what those before it cannot.

    What a fault at one place does looks a little like one at the others.

    Parameters
    ----------
    problem : Problem
    fitted : Fitted
    tests : sequence of PlaceTest
        Of what the model leaves.
    level : float
        Probability below which a place explains more than chance.
    """
    found: list[str] = []
    tables: list[Array] = []
    motions = problem.motion(fitted.model)
    whitening = fitted.noise.whitening
    for test in sorted((t for t in tests if t.p_value < level), key=lambda t: -t.share):
        table = regressors(problem, fitted, motions, test.place)
        if tables:
            view = Metric.of(problem, fitted, whitening, beside=np.hstack(tables))
            if _place_test(problem, view, test.place, table).p_value >= level:
                continue
        found.append(test.place)
        tables.append(table)
    return found


def _bend_of_the_reading(problem: Problem, fitted: Fitted, motions: Sequence[tuple[Array, Array]]) -> Array:
    """Second derivative of the readings on the fitted rows, shape (M, 1): what times that scatter do to their mean."""
    bends = []
    for index, (position, _) in enumerate(motions):
        seen = problem.kind.position_seen(problem, fitted.model, index, position)
        bends.append(np.gradient(np.gradient(seen)))
    return problem.as_compared(problem.fitted(bends))[:, None]


def _place_test(problem: Problem, view: Metric, place: str, table: Array) -> PlaceTest:
    """F-test of whether the columns of a table, shape (M, c), explain a residual.

    Its matrix of products, shape (c, c), is decomposed, which does not grow with the recording.
    """
    from scipy.special import fdtrc

    whitened = problem.whitened(table if view.spread is None else table / view.spread[:, None], view.whitening)
    # What a model that runs away does is beyond all numbers, and nothing is asked of it.
    with np.errstate(over="ignore"):
        lengths = np.linalg.norm(whitened, axis=0)
    asked = (lengths > 0.0) & np.isfinite(lengths)
    if not np.any(asked):
        return PlaceTest(place, QUESTIONS[place], 1.0, 0.0, 0.0)
    whitened, scale = whitened[:, asked], lengths[asked]
    fitted = (view.basis.T @ whitened) / scale
    values, vectors = np.linalg.eigh((whitened.T @ whitened) / np.outer(scale, scale) - fitted.T @ fitted)
    kept = values > max(SMALLEST_DIRECTION**2 * float(values[-1]), ROUNDING)
    rank = int(np.count_nonzero(kept))
    # The residual has no part in what is fitted, so that the table needs none taken off.
    products = vectors[:, kept].T @ ((whitened.T @ view.residual) / scale)
    energy = max(float(view.residual @ view.residual), 1e-300)
    explained = min(float(np.sum(products**2 / values[kept])), energy)
    freedom = max(len(view.residual) - view.basis.shape[1] - rank, 1)
    variance = max(energy - explained, 1e-300) / freedom
    p_value = float(fdtrc(rank, freedom, explained / rank / variance)) if rank else 1.0
    gain = max(explained - rank * variance, 0.0)
    return PlaceTest(place, QUESTIONS[place], p_value, gain / energy, gain / variance)


def shares(tests: Sequence[PlaceTest]) -> dict[str, float]:
    """Shares of the places in what their descriptions explain of a residual; they add up to one, or are all zero."""
    total = sum(t.gain for t in tests)
    return {t.place: (t.gain / total if total > 0.0 else 0.0) for t in tests}


def shares_of(
    found: Sequence[Finding], left: dict[str, float], learned: Sequence[LearnedPart] = ()
) -> dict[str, float]:
    """Shares of the places in what findings explain: each finding's, divided by the weights of what it may be.

    Parameters
    ----------
    found : sequence of Finding
    left : dict of str to float
        Shares of the places in what the findings leave, where physics outside the catalogue sits.
    learned : sequence of LearnedPart, optional
        Laws without a name, which stand where a finding that the improved simulation does not hold only resembles them.
    """
    result = dict.fromkeys(PLACES, 0.0)
    replaced = any(not finding.simulated for finding in found)
    for part in learned if replaced else ():
        result[part.sits_at] += part.share
    for finding in found:
        if replaced and not finding.simulated:
            continue
        share = float(finding.evidence["share"])
        result[finding.place] += share * finding.weight
        for name, weight in finding.alternatives:
            if name != UNLISTED:
                result[known_effects()[name].place] += share * weight
                continue
            unknown = left if any(left.values()) else {finding.place: 1.0}
            for place, portion in unknown.items():
                result[place] += share * weight * portion
    total = sum(result.values())
    return {place: value / total if total > 0.0 else 0.0 for place, value in result.items()}


def locate(problem: Problem, fitted: Fitted, place: str | None, portions: dict[str, float]) -> Location:
    """Place, span of time, band of frequency and region of a signal in which a residual sits."""
    if place is None:
        return Location(None, dict.fromkeys(PLACES, 0.0))
    index = int(np.argmax([np.count_nonzero(e.used) for e in problem.experiments]))
    experiment, time = problem.experiments[index], problem.times[index]
    start = sum(int(np.count_nonzero(e.used)) for e in problem.experiments[:index])
    residual = fitted.residual[start : start + int(np.count_nonzero(experiment.used))]
    time = time[experiment.used]
    position, velocity = (s[experiment.used] for s in problem.motion(fitted.model)[index])
    signals = {"input": experiment.signal[experiment.used], "position": position, "velocity": velocity}
    complete = {p: portions.get(p, 0.0) for p in PLACES}
    return Location(
        place, complete, _span(time, residual), _band(residual, problem.acquisition.period), _region(signals, residual)
    )


def _shortest(energy: Array) -> tuple[int, int] | None:
    """Shortest run of cells with most of the energy, if it is short."""
    total = np.concatenate([[0.0], np.cumsum(energy)])
    if total[-1] <= 0.0:
        return None
    for length in range(1, int(SHARE_OF_RANGE * len(energy)) + 1):
        sums = total[length:] - total[:-length]
        first = int(np.argmax(sums))
        if sums[first] >= MOST_ENERGY * total[-1]:
            return first, first + length
    return None


def _span(time: Array, residual: Array) -> tuple[float, float] | None:
    parts = np.array_split(np.arange(len(time)), WINDOWS)
    energy = np.array([float(np.mean(residual[p] ** 2)) for p in parts])
    found = _shortest(np.maximum(energy - np.min(energy), 0.0))
    if found is None:
        return None
    return float(time[parts[found[0]][0]]), float(time[parts[found[1] - 1][-1]])


def _band(residual: Array, period: float) -> tuple[float, float] | None:
    length = min(len(residual), 256)
    frequency, density = cross_spectrum(residual, residual, period, length)
    found = _shortest(np.maximum(density.real - np.median(density.real), 0.0))
    return None if found is None else (float(frequency[found[0]]), float(frequency[found[1] - 1]))


def _region(signals: dict[str, Array], residual: Array) -> tuple[str, float, float] | None:
    """The signal whose values tell best where the residual is large, and the range of those values."""
    best: tuple[float, tuple[str, float, float]] | None = None
    for name, values in signals.items():
        edges = np.unique(np.quantile(values, np.linspace(0.0, 1.0, 13)))
        if len(edges) < 6:
            continue
        cells = np.clip(np.digitize(values, edges[1:-1]), 0, len(edges) - 2)
        counts = np.bincount(cells, minlength=len(edges) - 1)
        energy = np.bincount(cells, residual**2, minlength=len(edges) - 1) / np.maximum(counts, 1)
        found = _shortest(np.maximum(energy - np.min(energy), 0.0))
        contrast = float(np.max(energy) / max(float(np.median(energy)), 1e-300))
        if found is not None and contrast > 2.0 and (best is None or contrast > best[0]):
            best = contrast, (name, float(edges[found[0]]), float(edges[found[1]]))
    return None if best is None else best[1]
