"""The input that would have caused what a simulation leaves of a recording: a Wiener filter."""

from __future__ import annotations

from typing import Any

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
    response, power, regular = _response(plant, acquisition, len(residual))
    return _filtered(residual, np.conj(response) / (power + regular))


def force_through_filter(plant: TransferFunction, acquisition: Acquisition, force: Array) -> Array:
    """What :func:`equivalent_input` would make of the response to a force, shape (N,): the force, as far as it shows.

    A force that is drawn beside an equivalent input has to be smoothed as that is.
    """
    _, power, regular = _response(plant, acquisition, len(force))
    return _filtered(force, power / (power + regular))


def _filtered(values: Array, weights: NDArray[Any]) -> Array:
    return np.asarray(np.fft.irfft(np.fft.rfft(values, 2 * len(values)) * weights, 2 * len(values))[: len(values)])


def _response(
    plant: TransferFunction, acquisition: Acquisition, count: int
) -> tuple[NDArray[np.complex128], Array, float]:
    """Response of plant and camera at the frequencies of twice as many rows, its power, and what is added to that."""
    period = acquisition.period
    angular = 2.0 * np.pi * np.fft.rfftfreq(2 * count, period)
    exposure = 0.0 if acquisition.sensor == "instant" else float(acquisition.exposure or 0.0)
    lag = acquisition.latency + 0.5 * exposure
    response = plant.frequency_response(np.maximum(angular, 1e-6 / period))
    response = response * np.sinc(angular * exposure / (2.0 * np.pi)) * np.exp(-1j * angular * lag)
    power = np.abs(response) ** 2
    power = np.where(np.isfinite(power), power, 0.0)
    regular = REGULAR * float(np.max(power[1:], initial=0.0)) or 1.0
    return np.nan_to_num(response), power, regular
