"""Spectra by Welch's method (1967, IEEE Trans. Audio Electroacoust. 15, 70–73).

:func:`scipy.signal.csd` says the same. Its package takes longer to load than a diagnosis of two thousand frames takes:
it brings all of scipy's statistics, of which a spectrum needs none.
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

Array = NDArray[np.float64]


def cross_spectrum(first: Array, second: Array, period: float, segment: int) -> tuple[Array, NDArray[np.complex128]]:
    """One-sided cross-spectral density, the mean over segments that overlap by half, without means, with a Hann window.

    Parameters
    ----------
    first, second : ndarray, shape (N,)
    period : float
        Seconds between the rows.
    segment : int
        Rows of a segment, at most N.

    Returns
    -------
    ndarray, shape (F,)
        Frequencies in Hz, zero and the Nyquist frequency among them where ``segment`` is even.
    ndarray of complex, shape (F,)
        Conjugate spectrum of ``first`` times that of ``second``, per Hz.
    """
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(segment) / segment)
    step = segment - segment // 2

    def transformed(rows: Array) -> NDArray[np.complex128]:
        parts = sliding_window_view(rows, segment)[::step]
        return np.fft.rfft(window * (parts - parts.mean(axis=1, keepdims=True)), axis=1)

    ours = transformed(first)
    theirs = ours if second is first else transformed(second)
    density = np.mean(np.conj(ours) * theirs, axis=0) * period / float(window @ window)
    density[1 : None if segment % 2 else -1] *= 2.0
    return np.arange(segment // 2 + 1) / (segment * period), density
