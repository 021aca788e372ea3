"""Noise of a measurement, and effects that act on the measured values alone."""

from typing import Any

import numpy as np
from scipy import signal

from .excitations import Generator
from .laws import Law

Array = np.ndarray[Any, np.dtype[np.float64]]
WHITE = ("white Gaussian", "white Gaussian", "white Gaussian", "uniform", "slightly heavy-tailed")


def draw_spectrum(rng: Generator) -> tuple[float, ...]:
    """Return the coefficients of a stable autoregression of order one or two."""
    if rng.random() < 0.5:
        return (float(rng.uniform(0.4, 0.9)),)
    radius, angle = float(rng.uniform(0.5, 0.9)), float(rng.uniform(0.2, 2.0))
    return (2.0 * radius * float(np.cos(angle)), -(radius**2))


def draw_noise(rng: Generator, kind: str, samples: int, deviation: float, spectrum: tuple[float, ...] = ()) -> Array:
    """Return noise of a standard deviation (the unit of what is measured), coloured where there is a spectrum."""
    count = samples + 500
    if kind == "uniform":
        noise = rng.uniform(-np.sqrt(3.0), np.sqrt(3.0), count)
    elif kind == "slightly heavy-tailed":
        noise = rng.standard_t(9.0, count) / np.sqrt(9.0 / 7.0)
    else:
        noise = rng.standard_normal(count)
    if spectrum:
        denominator = np.concatenate([[1.0], -np.array(spectrum)])
        noise = signal.lfilter([1.0], denominator, noise)
        response = signal.lfilter([1.0], denominator, np.eye(1, 2000)[0])
        noise = noise / np.sqrt(np.sum(response**2))
    return np.asarray(deviation * noise[500:])


def draw_noise_law(identifier: str, rng: Generator, deviation: float, velocity: float, period: float) -> Law:
    """Return an effect on the measured values.

    ``deviation`` (y) is that of the noise, ``velocity`` (y/s) the root mean square speed, ``period`` in s.
    """
    if identifier == "dropped-frames":
        return Law(identifier, "sensor", "catalogue", {"fraction": float(rng.uniform(0.01, 0.06))})
    if identifier == "outliers":
        return Law(identifier, "sensor", "catalogue", {"fraction": float(rng.uniform(0.005, 0.03))})
    if identifier == "quantisation":
        return Law(identifier, "sensor", "catalogue", {"step": float(deviation * rng.uniform(1.5, 8.0))})
    if identifier == "timestamp-jitter":
        std = deviation * float(rng.uniform(1.0, 4.0)) / velocity
        return Law(identifier, "sensor", "catalogue", {"std": min(std, 0.3 * period)})
    raise KeyError(identifier)


def spoil(values: Array, laws: list[Law], rng: Generator, deviation: float) -> Array:
    """Return noisy values after the effects on them: outliers, a lattice, repeated frames, in the order of a camera."""
    number = {law.identifier: law.parameters for law in laws}
    values = values.copy()
    if "outliers" in number:
        struck = rng.random(values.size) < float(number["outliers"]["fraction"])
        sizes = rng.uniform(8.0, 40.0, values.size) * deviation * rng.choice([-1.0, 1.0], values.size)
        values += struck * sizes
    if "quantisation" in number:
        step = float(number["quantisation"]["step"])
        values = step * np.round(values / step)
    if "dropped-frames" in number:
        lost = rng.random(values.size) < float(number["dropped-frames"]["fraction"])
        lost[0] = False
        values = values[np.maximum.accumulate(np.where(lost, 0, np.arange(values.size)))]
    return np.asarray(values)
