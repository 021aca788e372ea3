"""What white noise becomes by an autoregression, the inverse of a whitening filter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def coloured(rows: Array, whitening: Array) -> Array:
    """Rows, shape (N,) or (N, c), through 1/A(z) with the whitening filter A, whose first number is one.

    It is the solution of a triangular banded system. :func:`scipy.signal.lfilter` says the same, but loading its
    package takes longer than a diagnosis of two thousand frames.
    """
    from scipy.linalg.blas import dtbsv

    count, order = len(rows), min(len(whitening), len(rows)) - 1
    if order < 1:
        return np.array(rows, dtype=float)
    band = np.repeat(np.asarray(whitening[: order + 1], dtype=float)[:, None], count, axis=1)
    columns = np.reshape(rows, (count, -1)).T
    solved = [dtbsv(order, band, column, lower=1, diag=1) for column in columns]
    return np.reshape(np.transpose(solved), np.shape(rows))
