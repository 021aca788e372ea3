"""Discrete-time identification with a given delay, as section 3.1 of the paper has it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class DiscreteTimeModel:
    """z^-delay (β0 + … + βm z^-m) / (1 + a_1 z^-1 + … + a_n z^-n).

    Attributes
    ----------
    numerator, denominator : ndarray, shapes (m + 1,) and (n + 1,)
        Ascending powers of z^-1.
    delay : int
    standard_deviations : ndarray, shape (n + m + 1,)
        Of [a_1 … a_n, β0 … βm]; least squares, so meant for an equation error that is white.
    """

    numerator: Array
    denominator: Array
    delay: int
    standard_deviations: Array


def least_squares(signal: Array, output: Array, poles: int, zeros: int, delay: int) -> DiscreteTimeModel:
    """Discrete-time model by least squares on the difference equation (ARX): exact on data without noise.

    Parameters
    ----------
    signal, output : ndarray, shape (N,)
        u_k and w_k, at rest before the first sample.
    poles, zeros, delay : int
        Orders below and above, and the delay in samples; the paper takes 2, 2 and 1.

    Raises
    ------
    ValueError
        If there are fewer samples than parameters.
    """
    count = len(output)
    if count <= poles + zeros + 1:
        raise ValueError(f"{count} samples are too few for {poles + zeros + 1} parameters")

    def delayed(values: Array, lag: int) -> Array:
        return np.concatenate([np.zeros(lag), values[: count - lag]])

    columns = [-delayed(output, i) for i in range(1, poles + 1)]
    columns += [delayed(signal, delay + i) for i in range(zeros + 1)]
    table = np.column_stack(columns)
    # Columns of one length: in units in which the output is tiny beside the input its square would be lost in rounding.
    lengths = np.linalg.norm(table, axis=0)
    lengths[lengths == 0.0] = 1.0
    scaled = table / lengths
    solution = np.asarray(np.linalg.lstsq(scaled, output, rcond=None)[0], dtype=np.float64) / lengths
    residual = output - table @ solution
    variance = float(residual @ residual) / (count - table.shape[1])
    deviations: Array = np.sqrt(variance * np.diag(np.linalg.pinv(scaled.T @ scaled))) / lengths
    return DiscreteTimeModel(solution[poles:], np.concatenate([[1.0], solution[:poles]]), delay, deviations)
