"""Output error by a general optimiser, as a second opinion on SRIVC."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.identification.iteration_result import IterationResult
from camid.identification.predictor import Predictor


def output_error(predictor: Predictor, start: NDArray[np.float64]) -> IterationResult:
    """Minimise the sum of squared output errors with ``scipy.optimize.least_squares``.

    Parameters
    ----------
    predictor : Predictor
    start : ndarray
        Parameter vector in scaled units; only its free entries move.
    """
    from scipy.optimize import least_squares

    free = predictor.free

    def complete(values: NDArray[np.float64]) -> NDArray[np.float64]:
        parameters = start.copy()
        parameters[free] = values
        return parameters

    def residual(values: NDArray[np.float64]) -> NDArray[np.float64]:
        difference = predictor.linearise(complete(values))[0]
        # The optimiser stops at the first number that is not finite; a huge one makes it turn back.
        return np.nan_to_num(difference, nan=1e150, posinf=1e150, neginf=-1e150)

    def jacobian(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return -np.nan_to_num(predictor.linearise(complete(values))[1][:, free])

    solution = least_squares(
        residual, start[free], jac=jacobian, method="trf", x_scale="jac", xtol=1e-14, ftol=1e-14, gtol=1e-14
    )
    return IterationResult(complete(solution.x), float(2.0 * solution.cost), bool(solution.success), int(solution.nfev))
