"""How well a recording determines when something set in: the likelihood over the whole of the onset.

What a force leaves behind when it sets in a turn of a resonance earlier or later is nearly the same, so that the
likelihood of an onset has several maxima, and where the start is hidden by other coefficients it is flat. Its curvature
at the highest of them says nothing of the others. The profile over the onset does.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from camid.fitting.likelihood_profile import LikelihoodProfile, root_mean_square

if TYPE_CHECKING:
    from camid.fitting.fit import Fitted

# Steps of the profile to a standard deviation of the curvature, and at most to either side.
STEPS_TO_A_DEVIATION, MOST_STEPS = 2, 400


def onset_deviations(fitted: Fitted) -> dict[int, float]:
    """Root mean square distance from the estimate of the onsets that the profile leaves possible, in seconds.

    Parameters
    ----------
    fitted : Fitted

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
            found[place] = _deviation(fitted, i, place, curvature)
    return found


def _deviation(fitted: Fitted, index: int, place: int, curvature: float) -> float:
    """Of one onset, from the deviation that the curvature suggests."""
    profile = LikelihoodProfile(fitted, index, "time", fitted.sensitivities[:, place])
    first, last = float(fitted.problem.times[0][0]), float(fitted.problem.times[0][-1])
    steps = np.arange(1.0, MOST_STEPS + 1.0) * curvature / STEPS_TO_A_DEVIATION
    later = profile.falls(steps[profile.estimate + steps <= last].tolist())
    earlier = profile.falls((-steps[profile.estimate - steps >= first]).tolist())
    distances, falls = (np.concatenate([[0.0], a, b]) for a, b in zip(earlier, later, strict=True))
    return root_mean_square(distances, falls, np.ones(len(falls)))
