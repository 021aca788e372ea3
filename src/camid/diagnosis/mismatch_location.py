"""Locate what is left of a residual: at which place of the chain, when, at which frequencies, at which values.

For each place the residual is regressed on what a fault there could look like, whatever its law: functions of the input
at the actuator and of position and velocity at the plant (as forces, filtered through the plant and the camera), slow
functions of time as a disturbance, functions of the simulated output at the sensor. What the plant's coefficients can
imitate is projected off first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.diagnosis import Location
from camid.diagnosis.screening import Metric, metrics
from camid.effects.base import PLACES
from camid.fitting.fit import Fitted
from camid.fitting.problem import Problem

Array = NDArray[np.float64]

# Directions of a regression that are smaller than this share of the largest say nothing.
SMALLEST_DIRECTION = 1e-4
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


def regressors(problem: Problem, fitted: Fitted) -> dict[str, Array]:
    """Columns on the fitted rows for each place, shape (M, c)."""
    tables: dict[str, list[Array]] = {}
    respond = problem.kind.force_responses
    motions = problem.motion(fitted.model)
    for index, experiment in enumerate(problem.experiments):
        acquisition = problem.chain(fitted.model, index).declared()
        position, velocity = (_scaled(s) for s in motions[index])
        signal = experiment.signal / (float(np.max(np.abs(experiment.signal), initial=0.0)) or 1.0)
        count = len(signal)
        held = [*_hinges(signal, FEW_KNOTS), np.abs(signal), np.sign(signal), signal**3]
        earlier = np.concatenate([[0.0], signal[:-1]])
        held += [earlier, np.concatenate([[0.0, 0.0], signal[:-2]]), np.abs(signal) * earlier]
        y, v = position, velocity
        # A gain that depends on position or velocity: a motor's poles, its back electromotive force.
        held += [signal * f for f in (*_hinges(y, MANY_KNOTS), y**2, v, v**2, np.abs(v), np.abs(y))]
        moved = [y**2, y**3, v**2, v**3, y * v, y**2 * v, y * v**2, np.abs(v) * v, np.tanh(5.0 * v), np.tanh(30.0 * v)]
        moved += [*_hinges(y, MANY_KNOTS), *_hinges(v, MANY_KNOTS), np.abs(y) * v, np.abs(y), y**4 * v, np.sign(v) * y]
        moved += [f * g for f in _hinges(y, FEW_KNOTS) for g in _hinges(v, FEW_KNOTS)]
        slow = _polynomials(count, 10)
        output = _scaled(problem.kind.position_seen(problem, fitted.model, index, position))
        rate = np.gradient(output)
        rate = rate / (float(np.std(rate)) or 1.0)
        seen = [np.ones(count), output**2, output**3, *_hinges(output, MANY_KNOTS), output * rate, rate, rate**2]
        seen += [np.linspace(0.0, 1.0, count), np.linspace(0.0, 1.0, count) * rate, np.gradient(rate)]
        columns = {
            "actuator": respond(problem, fitted.model, index, held, acquisition.hold),
            "plant": respond(problem, fitted.model, index, moved, "foh"),
            "disturbance": respond(problem, fitted.model, index, slow, "foh"),
            "sensor": seen,
        }
        columns |= {place: [np.zeros(count)] for place in problem.kind.hidden_places}
        for place, found in columns.items():
            tables.setdefault(place, []).append(np.column_stack(found)[experiment.used])
    return {place: np.concatenate(parts) for place, parts in tables.items()}


def places(problem: Problem, fitted: Fitted) -> list[PlaceTest]:
    """Tests of every place, in the metric of the noise."""
    view = metrics(problem, fitted)[-1]
    energy = max(float(view.residual @ view.residual), 1e-300)
    tables = regressors(problem, fitted)
    return [_place_test(problem, view, place, table, energy) for place, table in tables.items()]


def _place_test(problem: Problem, view: Metric, place: str, table: Array, energy: float) -> PlaceTest:
    from scipy.special import fdtrc

    whitened = problem.whitened(table, view.whitening)
    lengths = np.linalg.norm(whitened, axis=0)
    if not np.any(lengths > 0.0):
        return PlaceTest(place, QUESTIONS[place], 1.0, 0.0, 0.0)
    whitened = whitened[:, lengths > 0.0] / lengths[lengths > 0.0]
    whitened = whitened - view.basis @ (view.basis.T @ whitened)
    left, singular, _ = np.linalg.svd(whitened, full_matrices=False)
    left = left[:, singular > SMALLEST_DIRECTION * max(float(singular[0]), 1e-300)]
    rank = left.shape[1]
    explained = float(np.sum((left.T @ view.residual) ** 2))
    freedom = max(len(view.residual) - view.basis.shape[1] - rank, 1)
    variance = max(energy - explained, 1e-300) / freedom
    p_value = float(fdtrc(rank, freedom, explained / rank / variance)) if rank else 1.0
    gain = max(explained - rank * variance, 0.0)
    return PlaceTest(place, QUESTIONS[place], p_value, gain / energy, gain / variance)


def shares(tests: list[PlaceTest]) -> dict[str, float]:
    """Share of the mismatch that each place explains, relative to what the best explains together."""
    largest = max((t.gain for t in tests), default=0.0)
    return {t.place: (t.gain / largest if largest > 0.0 else 0.0) for t in tests}


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
    from scipy.signal import welch

    length = min(len(residual), 256)
    frequency, density = welch(residual, 1.0 / period, nperseg=length)
    found = _shortest(np.maximum(density - np.median(density), 0.0))
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
