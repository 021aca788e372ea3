"""Motion under a held input by the classical Runge-Kutta method: another program than the engine's."""

import numpy as np


def motion(rate, signal, period, parts, states=2):
    """All states at the beginning of each period, shape (N, states), from rest.

    Parameters
    ----------
    rate : callable
        Of a state, shape (states,), and an input: its derivative by the time in seconds.
    signal : ndarray, shape (N,)
        Input, held over each period.
    period : float
        In seconds.
    parts : int
        Steps of the method in a period.
    states : int
    """
    state, step, seen = np.zeros(states), period / parts, np.empty((len(signal), states))
    for row, drive in enumerate(signal):
        seen[row] = state
        for _ in range(parts):
            first = rate(state, drive)
            second = rate(state + 0.5 * step * first, drive)
            third = rate(state + 0.5 * step * second, drive)
            last = rate(state + step * third, drive)
            state = state + step / 6.0 * (first + 2.0 * second + 2.0 * third + last)
    return seen


def positions(rate, signal, period, parts, states=2):
    """First state of :func:`motion`, shape (N,)."""
    return motion(rate, signal, period, parts, states)[:, 0]
