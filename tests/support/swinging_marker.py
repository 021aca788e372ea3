"""A marker on a string that swings in a tilted plane, seen in two columns: by scipy's integrator alone."""

import numpy as np
import pandas as pd
from scipy.integrate import solve_ivp

TRUTH = {"stiffness": 5.7, "damping": 0.06, "x_rest": 320.0, "y_rest": 258.0, "oblique": -0.3, "lift": 40.0}
LENGTH = 900.0
PLANT = {
    "physical": {
        "parameters": {
            "stiffness": 6.0,
            "damping": 0.1,
            "x_rest": 300.0,
            "y_rest": 250.0,
            "oblique": 0.0,
            "lift": 30.0,
            "length": LENGTH,
        },
        "fixed": ["length"],
        "equations": {
            "states": {"angle": "rate", "rate": "u - stiffness*sin(angle) - damping*rate"},
            "output": "angle",
            "start": {"angle": 0.3},
        },
    }
}
COLUMNS = {
    "x": "x_rest + length*sin(angle)/(1 + oblique*sin(angle))",
    "y": "y_rest + length*(cos(angle) - 1)/(1 + oblique*sin(angle)) + lift*sin(angle)",
}
SIMULATION = {
    "schema": 1,
    "time": {"column": "t"},
    "input": None,
    "plant": PLANT,
    "sensor": {"columns": COLUMNS, "kind": "camera", "exposure": 0.01},
    "initial_state": "estimate",
}


def swinging_marker(seed=0, *, friction=0.0, noise=(0.1, 0.3), seconds=12.0, push=None):
    """Table with t, x, y and, where something pushes, u."""
    generator = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 1.0 / 30.0)
    u = np.zeros(len(t)) if push is None else push * np.repeat(generator.choice([-1.0, 1.0], len(t)), 12)[: len(t)]

    def rates(time, state):
        held = u[min(max(int(np.floor(time * 30.0 + 1e-9)), 0), len(u) - 1)]
        drag = friction * np.tanh(state[1] / 1e-3)
        swing = held - TRUTH["stiffness"] * np.sin(state[0]) - TRUTH["damping"] * state[1] - drag
        depth = 1.0 + TRUTH["oblique"] * np.sin(state[0])
        x = TRUTH["x_rest"] + LENGTH * np.sin(state[0]) / depth
        y = TRUTH["y_rest"] + LENGTH * (np.cos(state[0]) - 1.0) / depth + TRUTH["lift"] * np.sin(state[0])
        return [state[1], swing, x, y]

    edges = np.unique(np.round(np.concatenate([t, t[1:] - 0.01]), 9))
    start = [0.35, 0.0, 0.0, 0.0] if push is None else [0.0, 0.0, 0.0, 0.0]
    solved = solve_ivp(rates, (0.0, edges[-1]), start, t_eval=edges, rtol=1e-9, atol=1e-9, max_step=1.0 / 120.0)
    seen = [(np.interp(t, edges, s) - np.interp(t - 0.01, edges, s)) / 0.01 for s in solved.y[2:]]
    columns = {
        name: v[1:] + n * generator.standard_normal(len(t) - 1) for name, v, n in zip("xy", seen, noise, strict=True)
    }
    return pd.DataFrame({"t": t[1:], **({} if push is None else {"u": u[1:]}), **columns})
