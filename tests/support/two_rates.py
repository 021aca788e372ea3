"""A recording whose frames lie between the samples of the drive, by an exact discretisation of its own."""

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline
from scipy.linalg import expm

PLANT = {"frequency": 9.0, "damping": 0.15, "gain": 1.3}
SIMULATION = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [105.3], "denominator": [1.0, 2.7, 81.0]}},
    "sensor": {"column": "y", "time": "frame", "kind": "camera", "exposure": 0.008, "latency": 0.004},
}


def two_rates(seed=1, *, rate=173.0, frames=47.3, seconds=12.0, noise=0.002, curve=None, first=0.3):
    """Table with t, u, frame and y; ``curve`` bends the input at the actuator."""
    generator = np.random.default_rng(seed)
    w, z, gain = PLANT["frequency"], PLANT["damping"], PLANT["gain"]
    step, count, parts = 1.0 / rate, int(seconds * rate), 24
    held = generator.integers(1, 6, count)
    u = np.repeat(generator.uniform(-1.0, 1.0, count), held)[:count]
    a = np.array([[0.0, 1.0, 0.0, 0.0], [-(w**2), -2.0 * z * w, 0.0, gain * w**2], [1.0, 0.0, 0.0, 0.0], [0.0] * 4])
    transition = expm(a * step / parts)[:3]
    state = np.zeros((count * parts + 1, 4))
    for k, level in enumerate(np.repeat(u if curve is None else curve(u), parts)):
        state[k, 3] = level
        state[k + 1, :3] = transition @ state[k]
    integral = CubicSpline(step / parts * np.arange(count * parts + 1), state[:, 2])
    delivered = first + np.arange(int((seconds - first) * frames)) / frames
    end = delivered - 0.004
    y = (integral(end) - integral(end - 0.008)) / 0.008 + noise * generator.standard_normal(len(end))
    rows = int(np.ceil(1.05 * frames / rate))  # so that a row holds one frame
    table = pd.DataFrame({"t": step / rows * np.arange(rows * count), "u": np.repeat(u, rows)})
    table = table.assign(frame=np.nan, y=np.nan)
    rows = np.searchsorted(table["t"], delivered, side="right") - 1
    table.loc[rows, "frame"], table.loc[rows, "y"] = delivered, y
    return table
