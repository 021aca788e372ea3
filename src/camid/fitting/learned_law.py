"""Fit a law without a name together with the plant's coefficients, through the whole chain.

The law is values at knots (:mod:`camid.effects.learned`) with a prior for smooth ones
(:mod:`camid.fitting.smoothness`); how smooth is chosen for the chain linearised about the last estimate, again and
again. The law holds nothing that the plant's coefficients can do: it is zero at zero, and its slope, weighted by how
often the motion is where, is zero wherever a free coefficient stands for it. Nor does it hold, to first order, what the
parameters of effects do to the output, which so keep their meaning (Plumlee 2017, J. Am. Stat. Assoc. 112, 1274–1285).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.effects.learned import LearnedEffect
from camid.fitting.beginning import Beginning
from camid.fitting.fit import Fitted, evaluate
from camid.fitting.law_columns import law_columns
from camid.fitting.output_error import sensitivities
from camid.fitting.packing import Packing
from camid.fitting.plant_with_effects import Model
from camid.fitting.possible_laws import PossibleLaws, laws_on_knots, null_space
from camid.fitting.problem import Problem
from camid.fitting.smoothness import SmoothCurve, smooth_curve

Array = NDArray[np.float64]

# Rounds of smoothing and least squares, evaluations in each, and the fall of the sum of squares, as a share, and the
# gain of log evidence that end them; of all that was gained the share by which a round is one of a fit that is still
# far off, and more of them follow.
ROUNDS, MOST_ROUNDS = 2, 6
MOST_STEPS = 4
SETTLED = 1e-5
LEAST_GAIN, STILL_FAR = 0.1, 0.02
# Sum of squares of what a law changes, as a share of what there is without it, up to which it does nothing.
LEAST_CHANGE = 1e-9
# Residual of a simulation that diverged.
RUNAWAY = 1e12
# Step of the differences by the law's values, in what they are measured by.
DIFFERENCE = 1e-4
# Weights that a law keeps where other parameters take some away; with fewer, it shares with them.
FEWEST_WEIGHTS = 5


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

    def gain_on(self, fitted: Fitted) -> float:
        """Logarithm of the evidence for the law against a model without it that was fitted itself.

        Where the noise has a colour, or more than this law is missing, a direction in which it varies more says less.
        None of a law that a fit has left doing nothing.
        """
        change = fitted.residual - self.fitted.residual
        if float(change @ change) <= LEAST_CHANGE * fitted.cost:
            return 0.0
        freedom = len(fitted.residual) - len(fitted.packing.names)
        gain = self.log_evidence + 0.5 * freedom * float(np.log(max(fitted.cost, 1e-300)))
        return gain / self.fitted.inflation(change)


def judged_to_first_order(
    problem: Problem, fitted: Fitted, laws: Mapping[str, LearnedEffect], *, coefficients: bool = False
) -> dict[str, float]:
    """Logarithms of the evidence for laws against none, of the chain linearised about the model without them.

    Parameters
    ----------
    problem : Problem
    fitted : Fitted
    laws : dict of str to LearnedEffect
        As :func:`blank_laws` gives them.
    coefficients : bool
        See :func:`learn`.
    """
    table: Array | None = None
    found = {}
    for name, law in laws.items():
        curve = laws_on_knots(problem, fitted, law)
        try:
            start = np.zeros(curve.directions.shape[1])
            step = _Step.about(problem, fitted.model.plus(law), start, curve, fitted.residual, table, finest=False)
            step = step.apart(coefficients)
        except (ValueError, ArithmeticError):
            continue
        # A law that does nothing changes nothing of the other derivatives.
        table = step.table if law.place == "plant" else table
        found[name] = step.smooth.log_evidence - step.smooth.without
    return found


def learn(
    problem: Problem,
    fitted: Fitted,
    law: LearnedEffect,
    *,
    coefficients: bool = False,
    coarser: LearnedLaw | None = None,
) -> LearnedLaw:
    """Fit a law and everything that the model holds beside it.

    Parameters
    ----------
    problem : Problem
    fitted : Fitted
        The model without the law.
    law : LearnedEffect
        As :func:`blank_laws` gives it.
    coefficients : bool
        Whether the law holds, to first order, nothing that the coefficients do to the output, so that these stay what
        they are; else that holds for the parameters of effects alone.
    coarser : LearnedLaw, optional
        The same on fewer knots, where the fit begins: a narrow curve is many steps from none.

    Raises
    ------
    ValueError
        If the chain diverges with the law.
    """
    curve = laws_on_knots(problem, fitted, law)
    start = np.zeros(curve.directions.shape[1])
    step = _Step.about(problem, fitted.model.plus(law), start, curve, fitted.residual).apart(coefficients)
    curve = step.curve
    if coarser is not None:
        heights = np.interp(law.knots, coarser.law.knots, coarser.law.heights)
        weights = curve.directions.T @ (heights - curve.origin)
        model = _with_weights(coarser.fitted.model, curve, weights, law)
        step = _Step.about(problem, model, weights, curve, coarser.fitted.residual)
    for done in range(1, MOST_ROUNDS + 1):
        following = step.fitted()
        gained = following.smooth.log_evidence - step.smooth.log_evidence
        step = following
        if gained < (LEAST_GAIN if done < ROUNDS else STILL_FAR * (step.smooth.log_evidence - step.smooth.without)):
            break
    deviations = np.sqrt(np.maximum(np.diag(curve.directions @ step.smooth.covariance @ curve.directions.T), 0.0))
    # An earlier law was fitted beside the packed numbers, too.
    beside = [step.nuisance()] if fitted.nuisance is None else [fitted.nuisance, step.nuisance()]
    result = replace(evaluate(step.pinned, step.model), nuisance=np.hstack(beside))
    return LearnedLaw(result, deviations, step.smooth.log_evidence, step.smooth.without)


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
    curve: PossibleLaws
    packing: Packing
    residual: Array
    table: Array
    columns: Array
    smooth: SmoothCurve

    @classmethod
    def about(
        cls,
        problem: Problem,
        model: Model,
        weights: Array,
        curve: PossibleLaws,
        left: Array,
        table: Array | None = None,
        *,
        finest: bool = True,
    ) -> _Step:
        """With the derivatives by the packed numbers, where they are known.

        An error of the simulation with the ``finest`` steps is negligible beside what is ``left``, shape (M,). Others
        do for a law that does nothing.
        """
        pinned = problem.pinned(model, finest=finest, negligible=problem.negligible(left))
        packing = Packing.of(pinned, model)
        simulated = pinned.simulate_fitted(model)
        if not np.all(np.isfinite(simulated)):
            raise ValueError("the simulation diverges with this law")
        if table is None:
            table = sensitivities(pinned, packing, packing.pack(model), simulated)
        columns = _derivatives(pinned, model, curve, simulated)
        # Of a law that does nothing what is left is known, and coarser steps are good enough for derivatives.
        residual = problem.output - simulated if finest else left
        smooth = _smoothed(residual, table, columns, weights, curve)
        return cls(problem, pinned, model, weights, curve, packing, residual, table, columns, smooth)

    def apart(self, coefficients: bool) -> _Step:
        """The same with laws that do nothing, to first order, that the effects' parameters (and coefficients) do.

        Where that would leave too few laws, the effects' parameters alone keep their meaning, or none does.
        """
        named = [i for i, name in enumerate(self.packing.names) if not name.startswith("initial")]
        effects = [i for i in named if self.packing.names[i][0].isdigit()]
        for kept_apart in (named, effects) if coefficients else (effects,):
            basis = orthonormal(self.table[:, kept_apart]) if kept_apart else np.zeros((len(self.residual), 0))
            if 0 < basis.shape[1] <= len(self.weights) - FEWEST_WEIGHTS:
                break
        else:
            return self
        kept = null_space(basis.T @ self.columns)
        roughness = kept.T @ self.curve.roughness @ kept
        curve = replace(self.curve, directions=self.curve.directions @ kept, roughness=roughness)
        columns, weights = self.columns @ kept, self.weights @ kept
        smooth = _smoothed(self.residual, self.table, columns, weights, curve)
        return replace(self, curve=curve, columns=columns, weights=weights, smooth=smooth)

    def fitted(self) -> _Step:
        """The chain linearised about the least squares with this smoothing."""
        from scipy.optimize import least_squares

        # The prior is one more residual for each weight; weights are measured so that it has the variance of the noise.
        factor = np.linalg.cholesky(self.curve.roughness)
        to_weights = np.sqrt(self.smooth.ratio) * np.linalg.inv(factor.T)
        beginning = Beginning.about(self.pinned, self.packing, self.model, self.residual)
        known: dict[bytes, tuple[Model, Array, Array]] = {}

        def at(vector: Array) -> tuple[Model, Array, Array]:
            """Model and weights at a point, and what it simulates with the steps of the integrator of the begin."""
            key = vector.tobytes()
            if key not in known:
                others, weights = np.split(vector, [len(vector) - len(self.weights)])
                model = _with_weights(self.packing.unpack(others), self.curve, to_weights @ weights)
                known[key] = model, to_weights @ weights, self.pinned.simulate_fitted(model)
            return known[key]

        def residual(vector: Array) -> Array:
            rows = self.problem.output - at(vector)[2]
            rows = np.nan_to_num(rows, nan=RUNAWAY, posinf=RUNAWAY, neginf=-RUNAWAY)
            others, prior = np.split(vector, [len(vector) - len(self.weights)])
            return np.concatenate([rows, prior, beginning.error(others)])

        def derivative(vector: Array) -> Array:
            model, _, simulated = at(vector)
            packing = self.packing
            table = sensitivities(self.pinned, packing, packing.pack(model), simulated)
            columns = _derivatives(self.pinned, model, self.curve, simulated) @ to_weights
            count = columns.shape[1]
            prior = np.hstack([np.zeros((count, table.shape[1])), np.eye(count)])
            first = np.hstack([beginning.table, np.zeros((len(beginning.errors), count))])
            return np.vstack([-np.hstack([table, columns]), prior, -first])

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
        best, weights, simulated = at(found.x)
        return _Step.about(self.problem, best, weights, self.curve, self.problem.output - simulated)

    def nuisance(self) -> Array:
        """Derivatives by the law, measured so that its prior has the precision one, shape (M, m)."""
        factor = np.linalg.cholesky(self.curve.roughness)
        return np.asarray(np.linalg.solve(factor, self.columns.T).T * np.sqrt(self.smooth.ratio))


def _smoothed(residual: Array, table: Array, columns: Array, weights: Array, curve: PossibleLaws) -> SmoothCurve:
    """The curve of most evidence, of the chain linearised about weights."""
    basis = orthonormal(table)
    left, target = (rows - basis @ (basis.T @ rows) for rows in (columns, residual + columns @ weights))
    return smooth_curve(left, target, curve.roughness, len(residual) - basis.shape[1])


def _derivatives(pinned: Problem, model: Model, curve: PossibleLaws, simulated: Array) -> Array:
    """Derivatives of the simulated output by the law's weights, shape (M, m)."""
    size = DIFFERENCE * curve.unit
    return law_columns(pinned, model, len(model.effects) - 1, curve.directions, size, simulated)


def _with_weights(model: Model, curve: PossibleLaws, weights: Array, law: LearnedEffect | None = None) -> Model:
    """The model whose last effect is the law of these weights, on its knots or those of another."""
    on = law or model.effects[-1]
    assert isinstance(on, LearnedEffect)
    learned = on.with_heights(curve.origin + curve.directions @ weights)
    return replace(model, effects=(*model.effects[:-1], learned))


def orthonormal(table: Array) -> Array:
    """Orthonormal basis of the columns, shape (M, r)."""
    lengths = np.linalg.norm(table, axis=0)
    left, triangle = np.linalg.qr(table[:, lengths > 0.0] / lengths[lengths > 0.0])
    return np.asarray(left[:, np.abs(np.diag(triangle)) > 1e-9])
