"""Excitation signals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def pseudo_random_binary_sequence(order: int, periods: int = 1, amplitude: float = 1.0) -> NDArray[np.float64]:
    """Pseudo-random binary sequence of maximal length.

    Parameters
    ----------
    order : int
        Number of stages of the shift register, 2 to 32; one period has ``2**order - 1`` samples (511 for the paper's
        order 9, section 3.2).
    periods : int
        How many periods follow each other.
    amplitude : float
        The two levels are ``-amplitude`` and ``+amplitude``, in the units of the input.

    Returns
    -------
    ndarray, shape ((2**order - 1) * periods,)

    Raises
    ------
    ValueError
        If the order is outside 2 to 32 or there is no period.

    Notes
    -----
    ``scipy.signal.max_len_seq`` supplies the register's taps and its starting state (all ones).
    """
    from scipy.signal import max_len_seq

    if periods < 1:
        raise ValueError(f"periods = {periods}: at least one period is needed")
    bits = max_len_seq(order)[0].astype(np.float64)
    return np.tile(amplitude * (2.0 * bits - 1.0), periods)
