"""Choice among the optima that different starts lead to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.identification.accuracy import LONGEST_REGRESSION, innovation_variance
from camid.identification.fit import Fit, is_stable
from camid.identification.predictor import Experiment, Predictor

Array = NDArray[np.float64]
Optimum = tuple[Predictor, Fit]

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
# Poles whose moduli agree within this share belong to one model.
SAME_MODEL = 0.02
# A believed mode this far past π/T says that the rig's mode is meant to be there.
CLEARLY_PAST_SHANNON = 1.1


@dataclass(frozen=True)
class Rival:
    """Another model that the data do not tell from the chosen one.

    Attributes
    ----------
    natural_frequencies : tuple of float
        Moduli of its poles in rad/s, ascending.
    weight : float
        Its likelihood among the chosen model and all rivals, which sum to one.
    """

    natural_frequencies: tuple[float, ...]
    weight: float


def _excess_variance(best: Optimum, experiments: list[Experiment]) -> float:
    """Residual variance over that of the unpredictable part, less one; minus one where what is left is rounding."""
    predictor, fit = best
    variance = fit.cost / max(len(predictor.target) - int(predictor.free.sum()), 1)
    if variance <= (EXACT * np.std(predictor.target)) ** 2:
        return -1.0
    unpredictable = float(np.mean([innovation_variance(e) for e in experiments]))
    return variance / unpredictable - 1.0 if unpredictable > 0.0 else np.inf


def conclusive(best: Optimum | None, experiments: list[Experiment]) -> bool:
    """Whether no other start can do better: what is left is exact zero or as small as the unpredictable part."""
    if best is None:
        return False
    spread = np.sqrt(2.0 * (2 * LONGEST_REGRESSION + 1)) / len(best[0].target)
    return _excess_variance(best, experiments) <= CONCLUSIVE_DEVIATIONS * spread


def adequate(best: Optimum) -> bool:
    """Whether an optimum explains its data down to the noise, with some allowance."""
    return _excess_variance(best, best[0].experiments) <= ADEQUATE - 1.0


def fastest(denominator: Array, time_unit: float) -> float:
    """Largest angular frequency of a mode in rad/s."""
    return float(np.max(np.abs(np.roots(denominator).imag), initial=0.0)) / time_unit


def past_shannon(optimum: Optimum) -> bool:
    """Whether a mode of the optimum lies past π/T."""
    predictor, fit = optimum
    limit = np.pi / predictor.experiments[0].acquisition.period
    return fastest(predictor.split(fit.parameters)[1], predictor.time_unit) > limit


def radii(optimum: Optimum) -> Array:
    """Moduli of the poles in rad/s, ascending."""
    predictor, fit = optimum
    return np.sort(np.abs(np.roots(predictor.split(fit.parameters)[1]))) / predictor.time_unit


def _deviances(optima: list[Optimum]) -> Array:
    """-2 log likelihood, up to a constant; everything below rounding counts alike."""
    rows = len(optima[0][0].target)
    floor = (EXACT * float(np.linalg.norm(optima[0][0].target))) ** 2
    return np.array([rows * np.log(max(f.cost, floor)) if floor > 0.0 else 0.0 for _, f in optima])


def _usable(optima: list[Optimum]) -> list[Optimum]:
    return [(p, f) for p, f in optima if np.isfinite(f.cost) and is_stable(p.split(f.parameters)[1])]


def rivals(chosen: Optimum, optima: list[Optimum]) -> list[Rival]:
    """Models of other frequencies that fit nearly as well as the chosen one, or better."""
    usable = _usable(optima)
    excess = _deviances(usable) - _deviances([chosen])[0]
    different: list[tuple[Array, float]] = []
    for optimum, difference in sorted(zip(usable, excess, strict=True), key=lambda pair: pair[1]):
        known = [radii(chosen), *(r for r, _ in different)]
        if difference <= SAME_LIKELIHOOD_WITH_PREFERENCE and not any(
            np.allclose(radii(optimum), r, rtol=SAME_MODEL) for r in known
        ):
            different.append((radii(optimum), float(np.exp(np.clip(-0.5 * difference, -50.0, 50.0)))))
    total = 1.0 + sum(w for _, w in different)
    return [Rival(tuple(float(v) for v in r), w / total) for r, w in different]


def select(optima: list[Optimum], believed: Array | None) -> Optimum | None:
    """The optimum of the highest likelihood; between equals the one nearest to the believed plant, else the slowest.

    A model and its alias can fit alike (a second-order plant with a zero, held input, instant sensor: exactly alike),
    so a difference in likelihood that noise explains decides nothing. Unless the believed plant lies clearly past the
    Shannon limit, a model past it is taken only where it explains the data down to the noise and no slower one does.
    """
    usable = _usable(optima)
    if not usable:
        return None
    deviance = _deviances(usable)
    excess = deviance - deviance.min()
    shannon = np.pi / usable[0][0].experiments[0].acquisition.period

    def distance(optimum: Optimum) -> float:
        if believed is None:
            return float(np.sum(radii(optimum)))
        return float(np.sum(np.abs(radii(optimum) - np.sort(np.abs(np.roots(believed))))))

    if believed is None or fastest(believed, 1.0) < CLEARLY_PAST_SHANNON * shannon:
        inside = [e for o, e in zip(usable, excess, strict=True) if not past_shannon(o)]
        # Where even the best optimum leaves structure behind, likelihoods of wrong models say nothing about aliases.
        best = usable[int(np.argmin(excess))]
        slower = SAME_LIKELIHOOD_WITH_PREFERENCE if believed is None else SAME_LIKELIHOOD
        if inside and (min(inside) <= slower or not adequate(best)):
            usable, excess = [o for o in usable if not past_shannon(o)], np.array(inside) - min(inside)
    margin = SAME_LIKELIHOOD if believed is None else SAME_LIKELIHOOD_WITH_PREFERENCE
    equals = [o for o, e in zip(usable, excess, strict=True) if e <= margin]
    nearest = min(distance(o) for o in equals)
    same = [o for o in equals if distance(o) <= nearest * (1.0 + 1e-2)]
    return min(same, key=lambda o: o[1].cost)
