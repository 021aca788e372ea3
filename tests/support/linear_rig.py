"""Recordings made by scipy alone: nothing in here knows camid's equations."""

from pathlib import Path

import numpy as np
import pandas as pd
from ruamel.yaml import YAML
from scipy.integrate import simpson
from scipy.signal import lsim

PERIOD = 0.05
NUMERATOR = [300.0]
DENOMINATOR = [2.0, 6.0, 200.0]  # 10 rad/s, damping ratio 0.15, static gain 1.5; the leading coefficient is not one
FINE_STEPS = 100  # a period


def steps(count, seed=1, length=4):
    """An input that changes level every few samples."""
    levels = np.random.default_rng(seed).uniform(-1.0, 1.0, count // length + 1)
    return np.repeat(levels, length)[:count]


def film(signal, hold="zoh", exposure=1.0, latency=0.0, *, before=0, initial_state=None):
    """Sensor samples by a dense ``lsim`` and Simpson's rule.

    Exposure (0: instant) and latency count in periods; the rig is at rest before the first sample, or in
    ``initial_state`` there. The first ``before`` samples are cut off: the rig then moves when the recording starts.
    """
    count = len(signal)
    time = np.arange((count - 1) * FINE_STEPS + 1) / FINE_STEPS
    held, joined = signal[np.floor(time + 1e-9).astype(int)], np.interp(time, np.arange(count), signal)
    driven = held if hold == "zoh" else joined
    moved = lsim((NUMERATOR, DENOMINATOR), driven, time * PERIOD, X0=initial_state, interp=hold == "foh")[1]
    lead = 3 * FINE_STEPS
    moved = np.concatenate([np.zeros(lead), moved])
    open_for, back = round(exposure * FINE_STEPS), round((exposure + latency) * FINE_STEPS)
    output = np.zeros(count)
    for k in range(count):
        begin = lead + k * FINE_STEPS - back
        window = moved[begin : begin + open_for + 1]
        output[k] = window[0] if open_for == 0 else simpson(window) / open_for
    return output[before:]


def recording(count=400, noise=0.1, before=0, start=0.0, seed=1, **options):
    """Table with columns t, u and y; ``noise`` is its share of the output's standard deviation (0.1: 20 dB)."""
    signal = steps(count + before, seed)
    output = film(signal, before=before, **options)
    output = output + noise * np.std(output) * np.random.default_rng(seed + 1).standard_normal(count)
    return pd.DataFrame({"t": start + PERIOD * np.arange(count), "u": signal[before:], "y": output})


def simulation(**changes):
    """Content of a simulation file; a change of ``None`` is written, a change of ``...`` takes the key out."""
    content = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [*NUMERATOR], "denominator": [*DENOMINATOR]}},
        "sensor": {"column": "y", "kind": "camera"},
    }
    content.update(changes)
    return {key: value for key, value in content.items() if value is not ...}


def plant(numerator, denominator, **more):
    return {"transfer_function": {"numerator": numerator, "denominator": denominator}, **more}


def write_yaml(content, path: Path):
    with path.open("w", encoding="utf-8") as stream:
        YAML(typ="safe", pure=True).dump(content, stream)
    return path
