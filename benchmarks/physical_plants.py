"""Named constants beside coefficients: the same rig, recordings and machine, in turns.

``python -m benchmarks.physical_plants`` on idle cores prints how long ``identify`` and ``diagnose`` take with each.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pandas as pd

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.friction import CoulombFriction
from camid.engine.mechanics import Chain
from camid.engine.run import run

PERIOD, ROWS, SEEDS = 0.01, 1500, 9
NOISE = 0.01
PLANTS: dict[str, dict[str, Any]] = {
    "coefficients": {"transfer_function": {"numerator": [0.83], "denominator": [1.0, 1.25, 241.0]}},
    "named constants": {
        "physical": {
            "parameters": {"mass": 1.2, "damping": 1.5, "stiffness": 290.0},
            "transfer_function": {"numerator": ["1"], "denominator": ["mass", "damping", "stiffness"]},
        }
    },
    "equations": {
        "physical": {
            "parameters": {"mass": 1.2, "damping": 1.5, "stiffness": 290.0},
            "equations": {
                "states": {"position": "speed", "speed": "(u - damping*speed - stiffness*position)/mass"},
                "output": "position",
            },
        }
    },
}


def recording(seed: int) -> pd.DataFrame:
    """A mass on a spring with dry friction, under a held random force."""
    generator = np.random.default_rng(seed)
    signal = np.repeat(generator.choice([-1.0, 1.0], ROWS // 5), 5)
    time_column = PERIOD * np.arange(ROWS)
    acquisition = Acquisition(PERIOD, "zoh", "camera", PERIOD, 0.0)
    chain = Chain(TransferFunction((1.0,), (1.3, 2.0, 310.0)), acquisition, (CoulombFriction(force=0.15),))
    output = run(chain, signal, time_column)
    output = output + NOISE * np.std(output) * generator.standard_normal(ROWS)
    return pd.DataFrame({"t": time_column, "u": signal, "y": output})


def simulation(plant: dict[str, Any]) -> dict[str, Any]:
    """What is believed of it."""
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": plant,
        "sensor": {"column": "y", "kind": "camera", "exposure": PERIOD},
    }


def main() -> None:
    """Print medians and their ratios to the first plant."""
    seconds: dict[tuple[str, str], list[float]] = {}
    for seed in range(SEEDS + 1):
        table = recording(seed)
        for command, function in (("identify", camid.identify), ("diagnose", camid.diagnose)):
            for name, plant in PLANTS.items():
                started = time.perf_counter()
                function(table, simulation(plant))
                if seed:  # the first one compiles
                    seconds.setdefault((command, name), []).append(time.perf_counter() - started)
    for command in ("identify", "diagnose"):
        reference = float(np.median(seconds[command, "coefficients"]))
        for name in PLANTS:
            median = float(np.median(seconds[command, name]))
            print(f"{command:9} {name:16} {median:8.3f} s {median / reference:6.2f}")


if __name__ == "__main__":
    main()
