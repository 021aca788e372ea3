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


def turning(seed, count=1600):
    """A robot turned by a valve with a dead zone, behind which a rate and a lag limit the flow: t, u and heading."""
    random = np.random.default_rng([43, seed])
    commands = np.repeat(random.integers(-4, 5, count // 14 + 1) * 0.6, 14)[:count]
    flow, heading, rows = 0.0, 0.0, np.zeros(count)
    for k, command in enumerate(commands):
        rows[k] = heading
        beyond = np.sign(command) * max(abs(command) - 0.4, 0.0)
        for _ in range(SUBSTEPS):
            flow += PERIOD / SUBSTEPS * np.clip((beyond - flow) / 0.12, -5.0, 5.0)
            heading += PERIOD / SUBSTEPS * 0.73 * flow
    noisy = rows + 2e-3 * random.standard_normal(count)
    return pd.DataFrame({"t": PERIOD * np.arange(count), "u": commands, "x": noisy})


TURNS = BELIEVED | {
    "plant": {"transfer_function": {"numerator": [0.5], "denominator": [0.2, 1.0, 0.0]}},
    "initial_state": "estimate",
}


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.slow
def test_a_dead_zone_acts_before_the_limit_of_the_rate_that_was_found_first(seed):
    recording = turning(seed)
    diagnosis = camid.diagnose(recording, TURNS)
    found = {f.identifier: f for f in diagnosis.findings}
    assert {"dead-zone", "rate-limit"} <= set(found)
    numbers = {**found["dead-zone"].parameters, **found["rate-limit"].parameters}
    for name, value in {"half_width": 0.4, "rate": 5.0, "time_constant": 0.12}.items():
        assert abs(numbers[name].value - value) < max(4.0 * numbers[name].standard_deviation, 0.02 * value), name
    # In the file effects act in the order in which they stand.
    written = diagnosis.improved.to_mapping()["effects"]
    assert [effect["id"] for effect in written][:2] == ["dead-zone", "rate-limit"]
    simulated = camid.simulate(recording, diagnosis.improved)
    assert np.std(simulated["x"].to_numpy() - recording["x"].to_numpy()) < 2.2e-3
