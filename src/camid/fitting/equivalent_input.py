"""The input that would have caused what a simulation leaves of a recording: a Wiener filter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction

Array = NDArray[np.float64]

# Share of the largest power of the response that is added to all, where the plant lets the camera see little.
REGULAR = 1e-2


def equivalent_input(plant: TransferFunction, acquisition: Acquisition, residual: Array) -> Array:
    """Input whose response is a residual.

    Parameters
    ----------
    plant : TransferFunction
        From the input to what the sensor sees.
    acquisition : Acquisition
    residual : ndarray, shape (N,)

    Returns
    -------
    ndarray, shape (N,)
        Regularised where the plant lets the camera see little of it.
    """
    count, period = len(residual), acquisition.period
    size = 2 * count
    angular = 2.0 * np.pi * np.fft.rfftfreq(size, period)
    exposure = 0.0 if acquisition.sensor == "instant" else float(acquisition.exposure or 0.0)
    lag = acquisition.latency + 0.5 * exposure
    response = plant.frequency_response(np.maximum(angular, 1e-6 / period))
    response = response * np.sinc(angular * exposure / (2.0 * np.pi)) * np.exp(-1j * angular * lag)
    power = np.abs(response) ** 2
    power = np.where(np.isfinite(power), power, 0.0)
    regular = REGULAR * float(np.max(power[1:], initial=0.0)) or 1.0
    spectrum = np.fft.rfft(residual, size) * np.conj(np.nan_to_num(response)) / (power + regular)
    return np.asarray(np.fft.irfft(spectrum, size)[:count])
