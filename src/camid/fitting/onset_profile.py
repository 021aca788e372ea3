"""How well a recording determines when something set in: the likelihood over the whole of the onset.

What a force leaves behind when it sets in a turn of a resonance earlier or later is nearly the same, so that the
likelihood of an onset has several maxima, and where the start is hidden by other coefficients it is flat. Its curvature
at the highest of them says nothing of the others. The profile over the onset, with all else estimated beside it, does
(Bates & Watts 1988, Nonlinear Regression Analysis and Its Applications, section 6.1).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from camid.fitting.fit import Fitted

Array = NDArray[np.float64]

# Steps of the profile to a standard deviation of the curvature, and at most to either side.
STEPS_TO_A_DEVIATION, MOST_STEPS = 2, 400
# Twice the fall of the log likelihood from which on an onset and those beyond it are left out.
IMPOSSIBLE = 30.0


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
    table = np.delete(fitted.sensitivities, place, axis=1)
    lengths = np.linalg.norm(table, axis=0)
    whitening = fitted.noise.whitening if fitted.weighted else np.ones(1)
    whitened = fitted.problem.whitened(table[:, lengths > 0.0] / lengths[lengths > 0.0], whitening)
    basis = np.linalg.qr(whitened)[0]
    # What the noise's colour leaves of the information in this direction.
    inflation = 1.0 if fitted.weighted else fitted.inflation(fitted.sensitivities[:, place])
    effect = fitted.model.effects[index]
    onset, count = float(effect.values["time"]), len(fitted.residual)
    first, last = float(fitted.problem.times[0][0]), float(fitted.problem.times[0][-1])

    def size(time: float) -> float:
        moved = type(effect)(**{**effect.values, "time": time})
        effects = (*fitted.model.effects[:index], moved, *fitted.model.effects[index + 1 :])
        simulated = fitted.problem.simulate_fitted(replace(fitted.model, effects=effects))
        rows = fitted.problem.whitened(fitted.problem.output - simulated, whitening)
        rows = rows - basis @ (basis.T @ rows)
        return float(rows @ rows)

    least = size(onset)
    distances, falls = [0.0], [0.0]
    for side in (-1.0, 1.0):
        for turn in range(1, MOST_STEPS + 1):
            distance = side * turn * curvature / STEPS_TO_A_DEVIATION
            if not first <= onset + distance <= last:
                break
            fall = count * float(np.log(max(size(onset + distance), 1e-300) / max(least, 1e-300))) / inflation
            if not fall < IMPOSSIBLE:
                break
            distances.append(distance)
            falls.append(fall)
    weights = np.exp(-0.5 * (np.array(falls) - min(falls)))
    return float(np.sqrt(weights @ np.square(distances) / np.sum(weights)))
