"""How well a recording determines when something set in: the likelihood over the whole of the onset.

What a force leaves behind when it sets in a turn of a resonance earlier or later is nearly the same, so that the
likelihood of an onset has several maxima, and where the start is hidden by other coefficients it is flat. Its curvature
at the highest of them says nothing of the others. The profile over the onset does as far as it reaches; beyond what is
impossible there may be another maximum, where the law knows of one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from camid.fitting.likelihood_profile import IMPOSSIBLE, LikelihoodProfile, root_mean_square
from camid.side_by_side import in_threads

if TYPE_CHECKING:
    from camid.effects.base import Effect
    from camid.fitting.fit import Fitted
    from camid.fitting.plant_with_effects import Model
    from camid.fitting.problem import Problem

# Steps of the profile to a standard deviation of the curvature, and at most to either side.
STEPS_TO_A_DEVIATION, MOST_STEPS = 2, 400
# Deviations of the curvature within which two fits have ended in the same maximum.
SAME = 3.0


def onset_deviations(fitted: Fitted, fit: Callable[[Problem, Model], Fitted]) -> dict[int, float]:
    """Root mean square distance from the estimate of the onsets that the profile leaves possible, in seconds.

    Parameters
    ----------
    fitted : Fitted
    fit : callable
        Fits a model from where it is.

    Returns
    -------
    dict of int to float
        By place among the packed parameters: of the onsets of forces of one recording.
    """
    if fitted.nuisance is not None or len(fitted.problem.fitted_runs) != 1:
        return {}
    found = {}
    for i, effect in enumerate(fitted.model.effects):
        name = f"{i} time"
        if name not in fitted.packing.names or not effect.of_one_recording:
            continue
        place = fitted.packing.names.index(name)
        curvature = float(np.sqrt(max(fitted.covariance[place, place], 0.0)))
        if 0.0 < curvature < np.inf:
            found[place] = _deviation(fitted, fit, i, place, curvature)
    return found


def _deviation(
    fitted: Fitted, fit: Callable[[Problem, Model], Fitted], index: int, place: int, curvature: float
) -> float:
    """Of one onset, from the deviation that the curvature suggests."""
    profile = LikelihoodProfile(fitted, index, "time", fitted.sensitivities[:, place])
    first, last = float(fitted.problem.times[0][0]), float(fitted.problem.times[0][-1])
    steps = np.arange(1.0, MOST_STEPS + 1.0) * curvature / STEPS_TO_A_DEVIATION
    later = profile.falls(steps[profile.estimate + steps <= last].tolist())
    earlier = profile.falls((-steps[profile.estimate - steps >= first]).tolist())
    distances, falls = (np.concatenate([[0.0], a, b]) for a, b in zip(earlier, later, strict=True))
    widths = np.ones(len(falls))
    reached = float(np.min(distances)) - curvature, float(np.max(distances)) + curvature
    others = _other_maxima(fitted, fit, index, curvature)
    beyond = [(d, fall) for d, fall in others if not reached[0] <= d <= reached[1]]
    if beyond:
        # Each is about as wide as the highest one, whose widths its own stands for.
        same = np.abs(distances) <= SAME * curvature
        wide = float(np.sum(np.exp(-0.5 * falls[same])))
        far, low = np.array(beyond).T
        distances, falls = np.concatenate([distances, far]), np.concatenate([falls, low])
        widths = np.concatenate([widths, np.full(len(far), wide)])
    return root_mean_square(distances, falls, widths)


def _other_maxima(
    fitted: Fitted, fit: Callable[[Problem, Model], Fitted], index: int, curvature: float
) -> list[tuple[float, float]]:
    """Distances of other maxima of the likelihood that are possible, and twice the falls of its logarithm there."""
    if fitted.weighted:
        return []
    effect, problem = fitted.model.effects[index], fitted.problem
    estimate = effect.values["time"]

    def ended(law: Effect) -> tuple[float, float] | None:
        try:
            other = fit(problem, fitted.model.replaced(index, law))
        except (ValueError, ArithmeticError):
            return None
        ratio = max(other.cost, 1e-300) / max(fitted.cost, 1e-300)
        fall = len(fitted.residual) * float(np.log(ratio)) / fitted.inflation(fitted.residual - other.residual)
        return float(other.model.effects[index].values["time"] - estimate), fall

    try:
        laws = effect.restarts(problem.situations(fitted.model).of(type(effect)))
    except (ValueError, ArithmeticError):  # an effect that has run away leads nowhere
        return []
    found: list[tuple[float, float]] = []
    for each in in_threads(ended, laws):
        if each is not None and each[1] < IMPOSSIBLE:
            known = [0.0, *(distance for distance, _ in found)]
            if all(abs(each[0] - distance) > SAME * curvature for distance in known):
                found.append(each)
    return found
