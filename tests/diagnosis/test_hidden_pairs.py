"""Two effects that hide each other: neither explains much alone, and what resembles both together explains more."""

import numpy as np
import pandas as pd
import pytest

import camid

PERIOD, SUBSTEPS = 0.02, 40


def trolley(seed, count=1500):
    """A trolley with friction whose amplifier saturates, on a slope, in a loop that nobody declares: t, u and x."""
    random = np.random.default_rng([41, seed])
    sizes = random.uniform(0.3, 0.5, count // 150) * (-1.0) ** np.arange(count // 150)
    wanted = np.repeat(sizes, 150)
    wanted = np.convolve(np.pad(wanted, 20, mode="edge"), np.ones(41) / 41, mode="valid")
    place, speed, rows = 0.0, 0.0, np.zeros((count, 2))
    for k in range(count):
        command = float(np.clip(18.0 * (wanted[k] - place) - 5.0 * speed, -6.0, 6.0))
        rows[k] = command, place
        for _ in range(SUBSTEPS):
            force = np.clip(command, -2.3, 2.3) + 0.04 - 0.62 * np.tanh(speed / 0.004)
            speed += PERIOD / SUBSTEPS * (0.95 * force - 1.5 * speed)
            place += PERIOD / SUBSTEPS * speed
    noisy = rows[:, 1] + 0.317 + 6e-4 * random.standard_normal(count)
    return pd.DataFrame({"t": PERIOD * np.arange(count), "u": rows[:, 0], "x": noisy})


BELIEVED = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [0.7], "denominator": [1.0, 2.2, 0.0]}},
    "sensor": {"column": "x", "kind": "instant"},
    "initial_state": "zero",
}


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_friction_beside_a_saturation_in_a_loop(seed):
    diagnosis = camid.diagnose(trolley(seed), BELIEVED)
    found = {f.identifier: f for f in diagnosis.findings}
    assert "saturation" in found
    limit = found["saturation"].parameters["limit"]
    assert abs(limit.value - 2.3) < max(4.0 * limit.standard_deviation, 0.02)
    frictions = {"coulomb-friction", "stribeck-friction", "asymmetric-friction"}
    assert frictions & {*found, *(name for f in diagnosis.findings for name, _ in f.alternatives)}
