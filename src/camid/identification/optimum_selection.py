"""Choice among the optima that different starts lead to."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import polynomial_roots
from camid.identification.accuracy import LONGEST_REGRESSION
from camid.identification.iteration_result import IterationResult, has_stable
from camid.identification.predictor import Predictor

Array = NDArray[np.float64]

# A fit whose residual variance is at most this share above the one-step prediction error of a long ARX model explains
# the data down to the noise. To end the search, it must be as near as the ARX model's own number of parameters lets it
# be: this many standard deviations of a chi-square variable.
ADEQUATE = 1.15
CONCLUSIVE_DEVIATIONS = 3.0
# Residual, relative to the output, that counts as exact.
EXACT = 1e-9
# Optima whose deviances (-2 log likelihood) differ by less cannot be told apart.
SAME_LIKELIHOOD = 0.5
SAME_LIKELIHOOD_WITH_PREFERENCE = 6.0
# Two models that data hardly tell apart differ in deviance by −d² ± 2d for some d, so the wrong one leads by more than
# this margin in at most one of 30,000 recordings.
RIVAL_MARGIN = 16.0
# An alias whose output error before refinement is more times that of the optimum is not a rival after it.
PLAUSIBLE_RATIO = 3.0
# A pole this many times beyond π/T that still moves is on its way to infinity.
RUNAWAY = 10.0
# Poles that agree within this share of their moduli belong to one model.
SAME_MODEL = 0.02
# A believed mode this far past π/T says that the rig's mode is meant to be there.
CLEARLY_PAST_SHANNON = 1.1


@dataclass(frozen=True)
class Optimum:
    """Where an iteration ended, with the predictor in whose units its parameters are."""

    predictor: Predictor
    fit: IterationResult

    @cached_property
    def denominator(self) -> Array:
        """Monic, in SI units, shape (n + 1,)."""
        predictor = self.predictor
        return predictor.split(self.fit.parameters)[1] / predictor.time_unit ** np.arange(predictor.structure.order + 1)

    @cached_property
    def poles(self) -> NDArray[np.complex128]:
        """In rad/s, shape (n,)."""
        return polynomial_roots(self.denominator)

    @cached_property
    def poles_by_radius(self) -> NDArray[np.complex128]:
        """The poles, smallest modulus first, of a pair the one with the positive imaginary part first."""
        return self.poles[np.lexsort((-self.poles.imag, np.round(np.abs(self.poles), 9 - _digits(self.poles))))]

    @cached_property
    def radii(self) -> Array:
        """Moduli of the poles in rad/s, ascending."""
        return np.sort(np.abs(self.poles))

    @cached_property
    def usable(self) -> bool:
        """Whether the iteration ended at a stable model."""
        return bool(np.isfinite(self.fit.cost)) and has_stable(self.poles)

    @property
    def past_shannon(self) -> bool:
        """Whether a mode lies past π/T."""
        return fastest(self.poles) > np.pi / self.predictor.experiments[0].acquisition.period


def _digits(poles: NDArray[np.complex128]) -> int:
    """Digits before the point of the largest modulus, so that two moduli of a pair round to one number."""
    return int(np.ceil(np.log10(max(float(np.max(np.abs(poles), initial=0.0)), 1e-30))))


def fastest(poles: NDArray[np.complex128]) -> float:
    """Largest angular frequency of a mode in rad/s."""
    return float(np.max(np.abs(poles.imag), initial=0.0))


@dataclass(frozen=True)
class Rival:
    """Another model that the data do not tell from the chosen one.

    Attributes
    ----------
    natural_frequencies : tuple of float
        Moduli of its poles in rad/s, ascending.
    damping_ratios : tuple of float
        Of the same poles; one for a real pole.
    weight : float
        Its likelihood among the chosen model and all rivals, which sum to one.
    """

    natural_frequencies: tuple[float, ...]
    damping_ratios: tuple[float, ...]
    weight: float


def _excess_variance(best: Optimum, unpredictable: float) -> float:
    """Residual variance over that of the unpredictable part, less one; minus one where what is left is rounding."""
    predictor = best.predictor
    variance = best.fit.cost / max(len(predictor.target) - int(predictor.free.sum()), 1)
    if variance <= _exact_cost(best) / len(predictor.target):
        return -1.0
    return variance / unpredictable - 1.0 if unpredictable > 0.0 else np.inf


def _exact_cost(best: Optimum) -> float:
    """Sum of squares that counts as rounding."""
    return (EXACT * best.predictor.target_norm) ** 2


def conclusive(best: Optimum, unpredictable: float) -> bool:
    """Whether no other start can do better: what is left is exact zero or as small as the unpredictable part."""
    spread = np.sqrt(2.0 * (2 * LONGEST_REGRESSION + 1)) / len(best.predictor.target)
    return _excess_variance(best, unpredictable) <= CONCLUSIVE_DEVIATIONS * spread


def plausible_cost(best: Optimum) -> float:
    """Sum of squares before refinement above which a start cannot become a rival of an optimum."""
    return PLAUSIBLE_RATIO * max(best.fit.cost, _exact_cost(best))


def adequate(best: Optimum, unpredictable: float) -> bool:
    """Whether an optimum explains its data down to the noise, with some allowance."""
    return _excess_variance(best, unpredictable) <= ADEQUATE - 1.0


def _deviances(optima: list[Optimum]) -> Array:
    """-2 log likelihood, up to a constant; everything below rounding counts alike."""
    rows = len(optima[0].predictor.target)
    floor = _exact_cost(optima[0])
    return np.array([rows * np.log(max(o.fit.cost, floor)) if floor > 0.0 else 0.0 for o in optima])


def rivals(chosen: Optimum, optima: list[Optimum]) -> list[Rival]:
    """Models of other poles that fit nearly as well as the chosen one, or better."""
    usable = [o for o in optima if o.usable and o is not chosen]
    if not usable:
        return []
    excess = _deviances(usable) - _deviances([chosen])[0]
    different: list[tuple[Optimum, float]] = []
    for optimum, difference in sorted(zip(usable, excess, strict=True), key=lambda pair: pair[1]):
        known = [chosen, *(o for o, _ in different)]
        if difference <= RIVAL_MARGIN and not any(_same_model(optimum, o) for o in known):
            different.append((optimum, float(np.exp(np.clip(-0.5 * difference, -50.0, 50.0)))))
    total = 1.0 + sum(w for _, w in different)
    return [_rival(o, w / total) for o, w in different]


def _same_model(one: Optimum, other: Optimum) -> bool:
    poles = other.poles_by_radius
    return bool(np.all(np.abs(one.poles_by_radius - poles) <= SAME_MODEL * np.abs(poles)))


def _rival(optimum: Optimum, weight: float) -> Rival:
    poles = optimum.poles_by_radius
    radii = np.abs(poles)
    with np.errstate(invalid="ignore"):
        dampings = np.where(radii > 0.0, -poles.real / radii, 0.0)
    return Rival(tuple(map(float, radii)), tuple(map(float, dampings)), weight)


def select(optima: list[Optimum], believed: NDArray[np.complex128] | None, unpredictable: float) -> Optimum | None:
    """The optimum of the highest likelihood; between equals the one nearest to the believed plant, else the slowest.

    A model and its alias can fit alike (a second-order plant with a zero, held input, instant sensor: exactly alike),
    so a difference in likelihood that noise explains decides nothing. Unless the believed plant lies clearly past the
    Shannon limit, a model past it is taken only where it explains the data down to the noise and no slower one does.

    Parameters
    ----------
    optima : list of Optimum
    believed : ndarray, shape (n,), optional
        Poles of the believed plant in rad/s.
    unpredictable : float
        From :func:`camid.identification.accuracy.innovation_variance`.
    """
    usable = [o for o in optima if o.usable]
    if len(usable) <= 1:
        return usable[0] if usable else None
    deviance = _deviances(usable)
    shannon = np.pi / usable[0].predictor.experiments[0].acquisition.period
    # An iteration that runs to infinity along a valley fits as well as a model with fewer poles: no optimum at all, and
    # no alias either.
    ended = np.array([o.fit.converged or o.radii[-1] <= RUNAWAY * shannon for o in usable])
    excess = deviance - deviance.min()

    def distance(optimum: Optimum) -> float:
        if believed is None:
            return float(np.sum(optimum.radii))
        return float(np.sum(np.abs(optimum.radii - np.sort(np.abs(believed)))))

    if believed is None or fastest(believed) < CLEARLY_PAST_SHANNON * shannon:
        inside = np.array([not o.past_shannon for o in usable])
        # Where even the best optimum leaves structure behind, likelihoods of wrong models say nothing about aliases.
        best = usable[int(np.argmin(excess))]
        slower = SAME_LIKELIHOOD_WITH_PREFERENCE if believed is None else SAME_LIKELIHOOD
        if inside.any() and (excess[inside].min() <= slower or not adequate(best, unpredictable)):
            kept = inside | ~ended
            usable, excess, ended = [o for o, k in zip(usable, kept, strict=True) if k], excess[kept], ended[kept]
            excess = excess - excess.min()
    if ended.any() and excess[ended].min() <= RIVAL_MARGIN:
        usable, excess = [o for o, e in zip(usable, ended, strict=True) if e], excess[ended]
        excess = excess - excess.min()
    margin = SAME_LIKELIHOOD if believed is None else SAME_LIKELIHOOD_WITH_PREFERENCE
    equals = [o for o, e in zip(usable, excess, strict=True) if e <= margin]
    nearest = min(distance(o) for o in equals)
    same = [o for o in equals if distance(o) <= nearest * (1.0 + 1e-2)]
    return min(same, key=lambda o: o.fit.cost)
