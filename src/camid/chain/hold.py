"""What a hold makes of the samples of an input."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def straight_line_corners(signal: Array) -> Array:
    """Corners of straight lines that hold the same below π/T as the band-limited signal through the given samples.

    Straight lines between samples attenuate by sinc²(ωT/2), so that the samples are amplified by the inverse of it, in
    the cosine transform of the record (mirrored at its ends). What is left to be wrong are the images of the input
    above π/T, of the relative size (ω/(2π/T - ω))², which a plant with more poles than zeros attenuates further.

    Parameters
    ----------
    signal : ndarray, shape (N,)

    Returns
    -------
    ndarray, shape (N,)
    """
    from scipy.fft import dct, idct

    values = np.asarray(signal, dtype=float)
    # np.sinc(x) is sin(πx)/(πx); the k-th cosine has ωT/2 = πk/(2N).
    loss = np.sinc(0.5 * np.arange(len(values)) / len(values)) ** 2
    return np.asarray(idct(dct(values) / loss), dtype=np.float64)


def driven(signal: Array, hold: str) -> tuple[Array, bool]:
    """Samples as the compiled code takes them, and whether straight lines join them.

    Parameters
    ----------
    signal : ndarray, shape (N,)
    hold : {"zoh", "foh", "band-limited"}
    """
    if hold == "band-limited":
        return straight_line_corners(signal), True
    return signal, hold == "foh"
