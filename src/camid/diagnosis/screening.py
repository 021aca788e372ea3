"""Screen the catalogue: how much of the residual each effect would explain, to first order, with one simulation each.

A candidate changes the simulated output by s. What the plant's coefficients (and the effects already found) can imitate
of it is projected out, and the remainder r is compared with the residual e: adding the effect at the size that fits
best lowers the sum of squares by (r·e)²/(r·r). It is a score test (Rao 1948) with a finite step for the derivative.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.effects import known_effects
from camid.effects.base import Effect
from camid.effects.situation import Situation
from camid.fitting.fit import Fitted
from camid.fitting.problem import WORKERS, Problem

Array = NDArray[np.float64]

# A change of the output of which less than this share is left beside the plant's coefficients is a change of them.
IMITATED = 1e-4
# The same where phases add up.
IMITATED_OVER_TIME = 5e-3
# Change of the output, as a share of its standard deviation, that is rounding.
ROUNDING = 1e-7


@dataclass(frozen=True)
class ScreenedEffect:
    """An effect of one shape, and what the residual says about it.

    Attributes
    ----------
    effect : Effect
    gain : float
        By how much the sum of squares falls, in noise variances, in the metric that favours it more: chi-square
        with one degree of freedom if the effect is not there.
    factor : float
        Multiple of the effect's size that fits best, to first order.
    visible : float
        Size of what the coefficients cannot imitate, in standard deviations of the noise: the root of the gain to be
        expected if the effect were there at this size.
    imitated : float
        Share of the change of the output that the coefficients imitate.
    """

    effect: Effect
    gain: float
    factor: float
    visible: float
    imitated: float


def trials(effect: type[Effect], problem: Problem) -> float:
    """How many different effects a search for this one amounts to."""
    rows = len(problem.output)
    return {"shapes": 1.0, "frames": float(rows), "frequencies": 0.5 * rows}[effect.trials]


def candidates(problem: Problem, base: Fitted, only: set[str] | None = None) -> Iterator[Effect]:
    """All first guesses of the catalogue that are not in the model already."""
    views = problem.situations(base.model)
    present = {e.identifier for e in base.model.effects}
    for identifier, effect in sorted(known_effects().items()):
        if effect.noise_like or identifier in present or (only is not None and identifier not in only):
            continue
        view = views.of(effect)
        if problem.kind.unseen(effect) is None and effect.invisible(view) is None:
            yield from _possible(effect, view)


def _possible(effect: type[Effect], view: Situation) -> Iterator[Effect]:
    """First guesses of an effect that its bounds allow."""
    guesses = effect.candidates(view)
    while True:
        try:
            yield next(guesses)
        except StopIteration:
            return
        except ValueError:  # the generator ends with it
            return


def signature(problem: Problem, base: Fitted, effect: Effect) -> Array | None:
    """Change of the simulated output on the fitted rows, shape (M,); None where the effect has no meaning here."""
    try:
        model = base.model.plus(effect)
        simulated = problem.rough().simulate_fitted(model)
    except (ValueError, ArithmeticError):
        return None
    change = simulated - (problem.output - base.residual)
    return change if np.all(np.isfinite(change)) else None


def projector(table: Array) -> Array:
    """Orthonormal basis of the columns, shape (M, r)."""
    lengths = np.linalg.norm(table, axis=0)
    table = table[:, lengths > 0.0] / lengths[lengths > 0.0]
    left, triangle = np.linalg.qr(table)
    return left[:, np.abs(np.diag(triangle)) > 1e-9]


@dataclass(frozen=True)
class Metric:
    """Residual and the basis of what is fitted, white or after the whitening filter of the noise."""

    whitening: Array
    basis: Array
    residual: Array
    variance: float

    @classmethod
    def of(cls, problem: Problem, base: Fitted, whitening: Array) -> Metric:
        """Metric of a fitted model."""
        basis = projector(problem.whitened(base.sensitivities, whitening))
        residual = problem.whitened(base.residual, whitening)
        residual = residual - basis @ (basis.T @ residual)
        freedom = max(len(residual) - basis.shape[1], 1)
        return cls(whitening, basis, residual, float(residual @ residual) / freedom)

    def left(self, problem: Problem, change: Array) -> tuple[Array, float]:
        """What the coefficients cannot imitate of a change of the output, and the size of the whole."""
        whitened = problem.whitened(change, self.whitening)
        return whitened - self.basis @ (self.basis.T @ whitened), float(np.linalg.norm(whitened))


def metrics(problem: Problem, base: Fitted) -> list[Metric]:
    """White metric, and that of the noise if it is coloured."""
    found = [Metric.of(problem, base, np.ones(1))]
    if len(base.noise.whitening) > 1:
        found.append(Metric.of(problem, base, base.noise.whitening))
    return found


def screen(problem: Problem, base: Fitted, only: set[str] | None = None) -> list[ScreenedEffect]:
    """Every first guess with its gain, the highest first."""
    views = metrics(problem, base)
    spread = float(np.std(problem.output)) or 1.0
    imitated = IMITATED_OVER_TIME if problem.kind.phases_add_up else IMITATED

    def judge(effect: Effect) -> ScreenedEffect | None:
        change = signature(problem, base, effect)
        if change is None:
            return None
        if float(np.max(np.abs(change), initial=0.0)) <= ROUNDING * spread:
            return ScreenedEffect(effect, 0.0, 0.0, 0.0, 1.0)
        best = ScreenedEffect(effect, 0.0, 0.0, 0.0, 1.0)
        for view in views:
            rest, whole = view.left(problem, change)
            size = float(np.linalg.norm(rest))
            if size <= imitated * whole or view.variance <= 0.0:
                continue
            product = float(rest @ view.residual)
            factor = product / size**2
            gain = product**2 / size**2
            remaining = max(float(view.residual @ view.residual) - gain, 1e-300) / max(len(rest) - 1, 1)
            if effect.one_sided and factor <= 0.0:
                gain = 0.0
            noise = max(view.variance - gain / len(rest), 1e-300)
            if gain / remaining >= best.gain:
                best = ScreenedEffect(
                    effect, gain / remaining, factor, size / float(np.sqrt(noise)), 1.0 - (size / whole) ** 2
                )
        return best

    with ThreadPoolExecutor(WORKERS) as pool:
        judged = [c for c in pool.map(judge, candidates(problem, base, only)) if c is not None]
    return sorted(judged, key=lambda c: -c.gain)
