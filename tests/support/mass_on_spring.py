"""Small recordings of a mass on a spring, with and without physics that its simulation leaves out."""

from __future__ import annotations

import numpy as np
import pandas as pd

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects import known_effects
from camid.engine.mechanics import Chain
from camid.engine.run import run

PERIOD, COUNT = 0.02, 700
PLANT = TransferFunction((100.0,), (1.0, 2.0, 100.0))
# What is believed of the plant: coefficients off by several per cent.
BELIEVED = {"numerator": [95.0], "denominator": [1.0, 2.3, 104.0]}
LEVELS = (-1.0, -0.4, 0.3, 0.9, 1.5)


def effect(identifier, **values):
    """An effect of the catalogue."""
    return known_effects()[identifier](**values)


def command(count=COUNT, seed=1):
    """Random levels held for eight frames, shape (count,)."""
    random = np.random.default_rng(np.random.SeedSequence(seed))
    return np.repeat(random.choice(LEVELS, count // 8 + 1), 8)[:count]


def record(*effects, count=COUNT, seed=1, noise=0.005, plant=PLANT, state=None, signal=None, **declared):
    """Recording of a chain, a DataFrame with the columns t, u and y.

    Parameters
    ----------
    *effects : Effect
    count, seed : int
    noise : float
        Standard deviation of white noise, in units of y.
    plant : TransferFunction
    state : ndarray, optional
        Companion state of the plant at the begin.
    signal : ndarray, optional
        Input, shape (count,).
    **declared
        Of the acquisition: hold, sensor, exposure, latency.
    """
    random = np.random.default_rng(np.random.SeedSequence((seed, 2)))
    signal = command(count, seed) if signal is None else signal
    time = PERIOD * np.arange(count)
    acquisition = Acquisition(PERIOD, **{"hold": "zoh", "sensor": "camera", "exposure": PERIOD, **declared})
    output = run(Chain(plant, acquisition, effects, state), signal, time)
    return pd.DataFrame({"t": time, "u": signal, "y": output + noise * random.standard_normal(count)})


def simulation(**changes):
    """What is believed of the rig: held input, camera open over the whole period, no effect."""
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": BELIEVED},
        "sensor": {"column": "y", "kind": "camera"},
        **changes,
    }
