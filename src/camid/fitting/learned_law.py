"""Fit a law without a name together with the plant's coefficients, through the whole chain.

The law is values at knots (:mod:`camid.effects.learned`) with a prior for smooth ones
(:mod:`camid.fitting.smoothness`); how smooth is chosen for the chain linearised about the last estimate, again and
again. The law holds nothing that the plant's coefficients can do: it is zero at zero, and its slope, weighted by how
often the motion is where, is zero wherever a free coefficient stands for it (Plumlee 2017, J. Am. Stat. Assoc. 112,
1274–1285).
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.effects.learned import LearnedCurve, LearnedEffect, LearnedForce
from camid.fitting.fit import Fitted, evaluate, sensitivities
from camid.fitting.packing import Packing
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import WORKERS, Problem
from camid.fitting.smoothness import SmoothCurve, smooth_curve

Array = NDArray[np.float64]

KNOTS = 21
# Rounds of smoothing and least squares, evaluations in each, and the fall of the sum of squares, as a share, and the
# gain of log evidence that end them.
ROUNDS = 3
MOST_STEPS = 6
SETTLED = 1e-5
LEAST_GAIN = 0.1
# Residual of a simulation that diverged.
RUNAWAY = 1e12
# Step of the differences by the law's values, in what they are measured by.
DIFFERENCE = 1e-4
# Prior precision of a slope that no free coefficient stands for, beside that of a curve.
LEAST_ROUGHNESS = 1e-6


@dataclass(frozen=True)
class LearnedLaw:
    """A learned law in its place.

    Attributes
    ----------
    fitted : Fitted
        The law is the last effect of its model.
    deviations : ndarray, shape (k,)
        Standard deviations of the law's values.
    log_evidence, without : float
        With the law and without it, of the chain linearised about the estimate.
    """

    fitted: Fitted
    deviations: Array
    log_evidence: float
    without: float

    @property
    def law(self) -> LearnedEffect:
        """The law itself."""
        law = self.fitted.model.effects[-1]
        assert isinstance(law, LearnedEffect)
        return law


@dataclass(frozen=True)
class _Curve:
    """Which laws are possible: heights = origin + directions · c."""

    directions: Array
    roughness: Array
    origin: Array
    unit: float


def blank_laws(problem: Problem, fitted: Fitted) -> dict[str, LearnedEffect]:
    """Laws that do nothing, on knots over what the recordings visit, by what they depend on."""
    motions = problem.motion(fitted.model)
    used = [e.used for e in problem.experiments]
    position, velocity = (np.concatenate([m[i][u] for m, u in zip(motions, used, strict=True)]) for i in (0, 1))
    signal = problem.fitted([e.signal for e in problem.experiments])
    reading = problem.output - fitted.residual
    found: dict[str, LearnedEffect] = {}
    hidden = problem.kind.hidden_places
    for name, values in {"position": position, "velocity": velocity, "input": signal, "reading": reading}.items():
        low, high = float(np.min(values)), float(np.max(values))
        if not np.isfinite(high - low) or high <= low or len(np.unique(values[:1000])) < 4:
            continue  # a curve through fewer values than this says nothing that a straight line does not
        knots = np.linspace(low, high, KNOTS).tolist()
        law: LearnedEffect
        if name in ("position", "velocity"):
            law = LearnedForce(variables=name, knots=knots, values=[0.0] * KNOTS)
        else:
            law = LearnedCurve(variables=name, knots=knots, values=knots)
        if law.place not in hidden:
            found[name] = law
    return found


def learn(problem: Problem, fitted: Fitted, law: LearnedEffect, rounds: int = ROUNDS) -> LearnedLaw:
    """Fit a law and everything that the model holds beside it.

    Parameters
    ----------
    problem : Problem
    fitted : Fitted
        The model without the law.
    law : LearnedEffect
        As :func:`blank_laws` gives it.
    rounds : int
        How often the smoothing is chosen and the law fitted with it; after none it is judged to first order.

    Raises
    ------
    ValueError
        If the chain diverges with the law.
    """
    curve = _curve(problem, fitted, law)
    step = _Step.about(problem, fitted.model.plus(law), np.zeros(curve.directions.shape[1]), curve)
    for _ in range(rounds):
        following = step.fitted()
        settled = following.smooth.log_evidence < step.smooth.log_evidence + LEAST_GAIN
        step = following
        if settled:
            break
    deviations = np.sqrt(np.maximum(np.diag(curve.directions @ step.smooth.covariance @ curve.directions.T), 0.0))
    result = replace(evaluate(problem, step.model), nuisance=step.nuisance())
    return LearnedLaw(result, deviations, step.smooth.log_evidence, step.smooth.without)


def _curve(problem: Problem, fitted: Fitted, law: LearnedEffect) -> _Curve:
    """Laws on the same knots that no coefficient can imitate."""
    name, knots = str(law.values["variables"]), law.knots
    visits = np.concatenate(
        [_visited(problem, fitted, name, i)[e.used] for i, e in enumerate(problem.experiments) if e.used.any()]
    )
    counts = np.histogram(visits, np.concatenate([[-np.inf], 0.5 * (knots[1:] + knots[:-1]), [np.inf]]))[0]
    middle = np.array([np.interp(0.0, knots, row) for row in np.eye(len(knots))])
    constraints = [middle] if knots[0] < 0.0 < knots[-1] else [counts / counts.sum()]
    if _slope_is_free(problem, name):
        mean = float(counts @ knots) / counts.sum()
        constraints.append(counts * (knots - mean) / max(float(counts @ (knots - mean) ** 2), 1e-300))
    directions = _null_space(np.array(constraints))
    second = np.diff(np.eye(len(knots)), 2, axis=0) @ directions
    roughness = second.T @ second
    roughness += LEAST_ROUGHNESS * float(np.trace(roughness)) / len(roughness) * np.eye(len(roughness))
    origin = law.heights
    unit = float(np.ptp(knots)) if isinstance(law, LearnedCurve) else problem.situation(fitted.model).largest("signal")
    return _Curve(directions, roughness, origin, unit)


def _visited(problem: Problem, fitted: Fitted, name: str, index: int) -> Array:
    """Values that a law depends on, all rows of a recording, shape (N,)."""
    if name == "input":
        return problem.experiments[index].signal
    if name == "reading":
        return problem.simulate_one(fitted.model, index)
    return problem.motion(fitted.model)[index][0 if name == "position" else 1]


def _slope_is_free(problem: Problem, name: str) -> bool:
    """Whether a free coefficient does what a straight line in the law's place would."""
    free, structure = problem.structure.free, problem.structure
    if name in ("input", "reading"):
        return bool(np.any(free[: structure.degree + 1]))
    return bool(free[-1] if name == "position" else len(free) > structure.degree + 2 and free[-2])


def _null_space(rows: Array) -> Array:
    """Orthonormal columns that all rows send to zero."""
    _, sizes, vectors = np.linalg.svd(rows)
    return np.asarray(vectors[int(np.count_nonzero(sizes > 1e-12 * sizes[0])) :].T)


@dataclass(frozen=True)
class _Step:
    """The chain linearised about a model with a law.

    ``table`` holds the derivatives by the packed numbers, ``columns`` those by the law's weights; ``pinned`` is the
    problem with the steps of the integrator that suit the model.
    """

    problem: Problem
    pinned: Problem
    model: Model
    weights: Array
    curve: _Curve
    packing: Packing
    residual: Array
    table: Array
    columns: Array
    smooth: SmoothCurve

    @classmethod
    def about(cls, problem: Problem, model: Model, weights: Array, curve: _Curve) -> _Step:
        pinned = problem.pinned(model, finest=True)
        packing = Packing.of(pinned, model)
        simulated = pinned.simulate_fitted(model)
        if not np.all(np.isfinite(simulated)):
            raise ValueError("the simulation diverges with this law")
        table = sensitivities(pinned, packing, packing.pack(model), simulated)
        columns = _derivatives(pinned, model, curve, weights, simulated)
        residual = problem.output - simulated
        basis = _orthonormal(table)
        target = residual + columns @ weights
        left, target = (rows - basis @ (basis.T @ rows) for rows in (columns, target))
        smooth = smooth_curve(left, target, curve.roughness, len(residual) - basis.shape[1])
        return cls(problem, pinned, model, weights, curve, packing, residual, table, columns, smooth)

    def fitted(self) -> _Step:
        """The chain linearised about the least squares with this smoothing."""
        from scipy.optimize import least_squares

        # The prior is one more residual for each weight; weights are measured so that it has the variance of the noise.
        factor = np.linalg.cholesky(self.curve.roughness)
        to_weights = np.sqrt(self.smooth.ratio) * np.linalg.inv(factor.T)
        known: dict[bytes, _Step] = {}

        def at(vector: Array) -> _Step:
            """The chain linearised about a point, with the steps of the integrator that suit the begin."""
            others, weights = np.split(vector, [len(vector) - len(self.weights)])
            model = _with_weights(self.packing.unpack(others), self.curve, to_weights @ weights)
            return known.setdefault(vector.tobytes(), replace(self, model=model, weights=to_weights @ weights))

        def residual(vector: Array) -> Array:
            simulated = self.pinned.simulate_fitted(at(vector).model)
            rows = np.nan_to_num(self.problem.output - simulated, nan=RUNAWAY, posinf=RUNAWAY, neginf=-RUNAWAY)
            return np.concatenate([rows, vector[len(vector) - len(self.weights) :]])

        def derivative(vector: Array) -> Array:
            model = at(vector).model
            packing, simulated = self.packing, self.pinned.simulate_fitted(model)
            table = sensitivities(self.pinned, packing, packing.pack(model), simulated)
            columns = _derivatives(self.pinned, model, self.curve, at(vector).weights, simulated) @ to_weights
            count = columns.shape[1]
            prior = np.hstack([np.zeros((count, table.shape[1])), np.eye(count)])
            return np.vstack([-np.hstack([table, columns]), prior])

        count = len(self.weights)
        start = np.clip(self.packing.pack(self.model), self.packing.lower, self.packing.upper)
        lower, upper = np.full(count, -np.inf), np.full(count, np.inf)
        found = least_squares(
            residual,
            np.concatenate([start, np.linalg.solve(to_weights, self.weights)]),
            jac=derivative,
            bounds=(np.concatenate([self.packing.lower, lower]), np.concatenate([self.packing.upper, upper])),
            x_scale="jac",
            ftol=SETTLED,
            max_nfev=MOST_STEPS,
        )
        best = at(found.x)
        return _Step.about(self.problem, best.model, best.weights, self.curve)

    def nuisance(self) -> Array:
        """Derivatives by the law, measured so that its prior has the precision one, shape (M, m)."""
        factor = np.linalg.cholesky(self.curve.roughness)
        return np.asarray(np.linalg.solve(factor, self.columns.T).T * np.sqrt(self.smooth.ratio))


def _derivatives(pinned: Problem, model: Model, curve: _Curve, weights: Array, simulated: Array) -> Array:
    """Derivatives of the simulated output by the law's weights, shape (M, m), by one-sided differences."""
    size = DIFFERENCE * curve.unit

    def derivative(way: Array) -> Array:
        moved = pinned.simulate_fitted(_with_weights(model, curve, weights + size * way))
        return (moved - simulated) / size

    with ThreadPoolExecutor(WORKERS) as pool:
        columns = np.column_stack(list(pool.map(derivative, np.eye(len(weights)))))
    columns[~np.isfinite(columns)] = 0.0
    return columns


def _with_weights(model: Model, curve: _Curve, weights: Array) -> Model:
    """The model whose last effect is the law of these weights."""
    law = model.effects[-1]
    assert isinstance(law, LearnedEffect)
    learned = law.with_heights(curve.origin + curve.directions @ weights)
    return replace(model, effects=(*model.effects[:-1], learned))


def _orthonormal(table: Array) -> Array:
    """Orthonormal basis of the columns, shape (M, r)."""
    lengths = np.linalg.norm(table, axis=0)
    left, triangle = np.linalg.qr(table[:, lengths > 0.0] / lengths[lengths > 0.0])
    return np.asarray(left[:, np.abs(np.diag(triangle)) > 1e-9])
