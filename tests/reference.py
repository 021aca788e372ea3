"""Plants and outputs computed without camid: dense numerical integration, nothing shared with the tool."""

import numpy as np
from scipy.integrate import solve_ivp


def integrate_chain(numerator, denominator, signal, period, *, hold, exposure=None, latency=0.0, rows=20):
    """Sensor output by an adaptive integrator in pieces between the samples; exposure None is an instant sensor.

    The state is the phase vector of z = u/A with the integral of y appended; y is strictly proper.
    """
    denominator = np.asarray(denominator, float) / denominator[0]
    numerator = np.asarray(numerator, float)
    order = len(denominator) - 1
    output = np.zeros(order)
    output[order - len(numerator) :] = numerator

    def value(k, share):
        if hold == "zoh":
            return signal[k]
        return signal[k] + share * (signal[min(k + 1, len(signal) - 1)] - signal[k])

    pieces = []
    state = np.zeros(order + 1)
    for k in range(rows):

        def slope(t, x, k=k):
            z = x[:order]
            top = value(k, t / period) - denominator[1:] @ z
            return np.concatenate([[top], z[:-1], [output @ z]])

        piece = solve_ivp(slope, (0.0, period), state, method="DOP853", rtol=1e-12, atol=1e-14, dense_output=True)
        pieces.append(piece.sol)
        state = piece.y[:, -1]

    def at(t):
        if t <= 0.0:
            return np.zeros(order + 1)
        k = min(int(np.floor(t / period + 1e-12)), rows - 1)
        return pieces[k](t - k * period)

    times = period * np.arange(rows)
    if exposure is None:
        return np.array([output @ at(t - latency)[:order] for t in times])
    return np.array([(at(t - latency)[order] - at(t - latency - exposure)[order]) / exposure for t in times])
