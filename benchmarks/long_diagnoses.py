"""Time and memory of whole diagnoses of long recordings with nothing missing, report included.

``python -m benchmarks.long_diagnoses`` in the ordinary environment, on idle cores. The recordings are a second-order
plant under random levels, exact by its zero-order hold, in white noise of 1 %; the simulation's coefficients are 10 to
25 % off.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.signal import cont2discrete, lfilter

LENGTHS = (20_000, 1_000_000)
PERIOD, HELD, SEED, NOISE = 0.02, 5, 5, 0.01
SIMULATION = """schema: 1
time: {column: t}
input: {column: u, hold: zoh}
plant:
  transfer_function: {numerator: [90.0], denominator: [1.0, 5.0, 110.0]}
sensor: {column: y, kind: instant}
initial_state: zero
"""


def recording(length: int) -> pd.DataFrame:
    """Time in s, input and output."""
    generator = np.random.default_rng(SEED)
    drive = np.repeat(generator.choice([-1.0, 1.0], length // HELD + 1), HELD)[:length]
    numerator, denominator, _ = cont2discrete(([100.0], [1.0, 4.0, 100.0]), PERIOD, method="zoh")
    output = lfilter(np.ravel(numerator), denominator, drive)
    output += NOISE * np.std(output) * generator.normal(size=length)
    return pd.DataFrame({"t": PERIOD * np.arange(length), "u": drive, "y": output})


def main() -> None:
    """Print a line for each length."""
    for length in LENGTHS:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            recording(length).to_csv(folder / "recording.csv", index=False, float_format="%.8g")
            (folder / "simulation.yaml").write_text(SIMULATION, encoding="utf-8")
            command = [sys.executable, "-m", "camid", "diagnose", "recording.csv", "--simulation", "simulation.yaml"]
            start = time.perf_counter()
            subprocess.run([*command, "--output", "out"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
            seconds = time.perf_counter() - start
        # Of the largest child so far, which the longest recording is.
        gigabytes = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e6
        print(f"{length:,} frames: {seconds:.1f} s, {gigabytes:.2f} GB")


if __name__ == "__main__":
    main()
