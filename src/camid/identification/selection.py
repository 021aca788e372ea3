"""Choice among the optima that different starts lead to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.identification.accuracy import innovation_variance
from camid.identification.predictor import Experiment, Predictor
from camid.identification.srivc import Fit, is_stable

Array = NDArray[np.float64]
Optimum = tuple[Predictor, Fit]

# A fit whose residual is at most this share above the one-step prediction error of a long ARX model has left nothing
# over that another start could find.
CONCLUSIVE = 1.15
# Residual, relative to the output, that counts as exact.
EXACT = 1e-9
# Optima whose deviances (-2 log likelihood) differ by less cannot be told apart.
SAME_LIKELIHOOD = 0.5
SAME_LIKELIHOOD_NEAR_BELIEVED = 6.0
# A believed mode this far past π/T says that the rig's mode is meant to be there.
CLEARLY_PAST_SHANNON = 1.1


def conclusive(best: Optimum | None, experiments: list[Experiment]) -> bool:
    """Whether no other start can do better: what is left is exact zero or as small as the unpredictable part."""
    if best is None:
        return False
    predictor, fit = best
    rows = len(predictor.target)
    variance = fit.cost / max(rows - int(predictor.free.sum()), 1)
    if variance <= (EXACT * np.std(predictor.target)) ** 2:
        return True
    return variance <= CONCLUSIVE * float(np.mean([innovation_variance(e) for e in experiments]))


def select(optima: list[Optimum], believed: Array | None) -> Optimum | None:
    """The optimum of the highest likelihood; between equals the one nearest to the believed plant, else the slowest.

    A model and its alias can fit alike (a second-order plant with a zero, held input, instant sensor: exactly alike),
    so a difference in likelihood that noise explains decides nothing. Unless the believed plant lies clearly past the
    Shannon limit, a model past it is taken only where it explains the data down to the noise and no slower one does.
    """
    usable = [(p, f) for p, f in optima if np.isfinite(f.cost) and is_stable(p.split(f.parameters)[1])]
    if not usable:
        return None
    rows = len(usable[0][0].target)
    floor = (EXACT * float(np.linalg.norm(usable[0][0].target))) ** 2
    deviance = np.array([rows * np.log(max(f.cost, floor)) if floor > 0.0 else 0.0 for _, f in usable])
    excess = deviance - deviance.min()
    shannon = np.pi / usable[0][0].experiments[0].acquisition.period

    def fastest(denominator: Array, unit: float) -> float:
        return float(np.max(np.abs(np.roots(denominator).imag), initial=0.0)) / unit

    def distance(optimum: Optimum) -> float:
        radius = np.sort(np.abs(np.roots(optimum[0].split(optimum[1].parameters)[1]))) / optimum[0].time_unit
        if believed is None:
            return float(np.sum(radius))
        return float(np.sum(np.abs(radius - np.sort(np.abs(np.roots(believed))))))

    def within_shannon(optimum: Optimum) -> bool:
        return fastest(optimum[0].split(optimum[1].parameters)[1], optimum[0].time_unit) <= shannon

    if believed is None or fastest(believed, 1.0) < CLEARLY_PAST_SHANNON * shannon:
        inside = [e for o, e in zip(usable, excess, strict=True) if within_shannon(o)]
        # Where even the best optimum leaves structure behind, likelihoods of wrong models say nothing about aliases.
        best = usable[int(np.argmin(excess))]
        if inside and (min(inside) <= SAME_LIKELIHOOD or not conclusive(best, best[0].experiments)):
            usable, excess = [o for o in usable if within_shannon(o)], np.array(inside) - min(inside)
    margin = SAME_LIKELIHOOD if believed is None else SAME_LIKELIHOOD_NEAR_BELIEVED
    equals = [o for o, e in zip(usable, excess, strict=True) if e <= margin]
    nearest = min(distance(o) for o in equals)
    same = [o for o in equals if distance(o) <= nearest * (1.0 + 1e-2)]
    return min(same, key=lambda o: o[1].cost)
