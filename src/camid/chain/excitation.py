"""Excitation signals.

References
----------
Nelles (2001), *Nonlinear System Identification*, Springer, ch. 17 (amplitude-modulated PRBS).
Pintelon and Schoukens (2012), *System Identification: A Frequency Domain Approach*, 2nd ed., Wiley, ch. 5 (multisines).
Schroeder (1970), Synthesis of low-peak-factor signals and binary sequences with low autocorrelation, IEEE Transactions
on Information Theory 16(1), 85–89.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Taps of shift registers of maximal length, by the number of stages; the same as in scipy.signal.max_len_seq.
TAPS = {
    2: (1,), 3: (2,), 4: (3,), 5: (3,), 6: (5,), 7: (6,), 8: (7, 6, 1), 9: (5,), 10: (7,), 11: (9,), 12: (11, 10, 4),
    13: (12, 11, 8), 14: (13, 12, 2), 15: (14,), 16: (15, 13, 4), 17: (14,), 18: (11,), 19: (18, 17, 14), 20: (17,),
    21: (19,), 22: (21,), 23: (18,), 24: (23, 22, 17), 25: (22,), 26: (25, 24, 20), 27: (26, 25, 22), 28: (25,),
    29: (27,), 30: (29, 28, 7), 31: (28,), 32: (31, 30, 10),
}  # fmt: skip


def pseudo_random_binary_sequence(order: int, periods: int = 1, amplitude: float = 1.0) -> Array:
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
    The register starts with ones. The sequence is that of ``scipy.signal.max_len_seq`` (a test compares them), whose
    package takes a second to import: a tenth of what the whole workflow computes.
    """
    _check_periods(periods)
    if order not in TAPS:
        raise ValueError(f"the order of a pseudo-random binary sequence is 2 to 32, not {order}")
    return np.tile(amplitude * (2.0 * _shift_register(order, TAPS[order]) - 1.0), periods)


def _shift_register(order: int, taps: tuple[int, ...]) -> NDArray[np.uint8]:
    """One period of what a shift register of ones puts out, shape (2^order − 1,).

    The recurrence s[i + n] = s[i] ⊕ s[i + t] ⊕ … holds with n and every t doubled, too (squares of polynomials modulo
    two), so that ever longer parts follow from what is known.
    """
    length = 2**order - 1
    bits = np.ones(length, np.uint8)
    known, stride = min(order, length), 1
    while known < length:
        if 2 * stride * order <= known:
            stride *= 2
        first = known - stride * order
        count = min(stride * (order - max(taps)), length - known)
        part = bits[first : first + count].copy()
        for tap in taps:
            part ^= bits[first + stride * tap : first + stride * tap + count]
        bits[known : known + count] = part
        known += count
    return bits


def two_level_amplitudes(order: int, low: float, high: float, periods: int = 1) -> Array:
    """Pseudo-random binary sequence at one amplitude, then the same at another.

    A linear plant answers both parts alike; one whose gain or stiffness depends on the amplitude does not.

    Parameters
    ----------
    order : int
        Number of stages of the shift register, 2 to 32.
    low, high : float
        Amplitudes of the first and of the second part, in the units of the input.
    periods : int
        Periods of the sequence in each part.

    Returns
    -------
    ndarray, shape (2 * (2**order - 1) * periods,)

    Raises
    ------
    ValueError
        If the order is outside 2 to 32 or there is no period.
    """
    sequence = pseudo_random_binary_sequence(order, periods)
    return np.concatenate([low * sequence, high * sequence])


def multilevel(
    order: int, levels: int, generator: np.random.Generator, periods: int = 1, amplitude: float = 1.0
) -> Array:
    """Amplitude-modulated pseudo-random binary sequence (APRBS, Nelles 2001).

    Every run of equal bits of a pseudo-random binary sequence gets one of several levels, so that the times of the
    changes are the sequence's and the whole range of the input is visited.

    Parameters
    ----------
    order : int
        Number of stages of the shift register, 2 to 32.
    levels : int
        Equally spaced from ``-amplitude`` to ``+amplitude``, each given to equally many runs (except one), in random
        order.
    generator : numpy.random.Generator
        Draws the order.
    periods : int
        How many times the period is repeated.
    amplitude : float
        In the units of the input.

    Returns
    -------
    ndarray, shape ((2**order - 1) * periods,)

    Raises
    ------
    ValueError
        If the order is outside 2 to 32, there are fewer than two levels or there is no period.
    """
    _check_periods(periods)
    if levels < 2:
        raise ValueError(f"levels = {levels}: at least two levels are needed")
    sequence = pseudo_random_binary_sequence(order)
    run = np.concatenate([[0], np.cumsum(sequence[1:] != sequence[:-1])])
    values = np.resize(np.linspace(-amplitude, amplitude, levels), int(run[-1]) + 1)
    return np.tile(generator.permutation(values)[run], periods)


def multisine(
    length: int,
    lines: Sequence[int],
    periods: int = 1,
    root_mean_square: float = 1.0,
    *,
    phases: str = "schroeder",
    generator: np.random.Generator | None = None,
) -> Array:
    """Sum of sines of equal amplitude on given lines of the discrete Fourier transform of one period.

    Parameters
    ----------
    length : int
        Samples in a period; line l has the frequency l/length in cycles per sample.
    lines : sequence of int
        Excited lines, each between 1 and (length - 1)/2.
    periods : int
        How many periods follow each other.
    root_mean_square : float
        In the units of the input.
    phases : {"schroeder", "random"}
        Schroeder's (1970) phases -πk(k - 1)/F for the k-th of F lines, which keep the peak low; or random ones, which
        make the signal asymptotically Gaussian (Pintelon & Schoukens 2012).
    generator : numpy.random.Generator, optional
        Draws random phases; needed for them.

    Returns
    -------
    ndarray, shape (length * periods,)

    Raises
    ------
    ValueError
        If there is no line or period, a line repeats or lies outside its range, or the phases are unknown or random
        without a generator.
    """
    _check_periods(periods)
    excited = np.asarray(lines, dtype=np.int64)
    if excited.size == 0:
        raise ValueError("lines is empty: at least one line must be excited")
    if len(np.unique(excited)) < excited.size:
        raise ValueError("lines has repeated entries")
    if excited.min() < 1 or 2 * excited.max() >= length:
        raise ValueError(f"lines must lie between 1 and {(length - 1) // 2}, half of the {length} samples of a period")
    number = np.arange(1, excited.size + 1)
    if phases == "schroeder":
        angles = -np.pi * number * (number - 1) / excited.size
    elif phases == "random":
        if generator is None:
            raise ValueError("random phases need a generator")
        angles = generator.uniform(0.0, 2.0 * np.pi, excited.size)
    else:
        raise ValueError(f"phases = {phases!r}: they must be schroeder or random")
    # The inverse transform of the half spectrum sums the sines at the price of one.
    spectrum = np.zeros(length // 2 + 1, dtype=np.complex128)
    spectrum[excited] = 0.5 * length * np.sqrt(2.0 / excited.size) * root_mean_square * np.exp(1j * angles)
    return np.tile(np.fft.irfft(spectrum, length), periods)


def _check_periods(periods: int) -> None:
    if periods < 1:
        raise ValueError(f"periods = {periods}: at least one period is needed")
