"""Forces along the way of rigs that simulators of their own make: a guide worn amid, poles of a motor in a loop."""

import numpy as np
import pandas as pd
import pytest

import camid

PERIOD, SUBSTEPS = 0.01, 40


def slider(seed, count=2500):
    """A slider between springs on a guide that is worn amid: t, u and x."""
    random = np.random.default_rng([51, seed])
    commands = np.repeat(random.choice([-2.0, 0.0, 2.0], count // 17 + 1), 17)[:count]
    place, speed, rows = 0.0, 0.0, np.zeros(count)
    for k, command in enumerate(commands):
        rows[k] = place
        for _ in range(SUBSTEPS):
            friction = (0.25 + 12.0 * place + 7.5e3 * place**2) * np.tanh(speed / 1e-4)
            speed += PERIOD / SUBSTEPS * (0.288 * (command - friction) - 3.0 * speed - 144.0 * place)
            place += PERIOD / SUBSTEPS * speed
    return pd.DataFrame(
        {"t": PERIOD * np.arange(count), "u": commands, "x": rows + 6e-5 * random.standard_normal(count)}
    )


@pytest.mark.slow
def test_a_guide_that_is_worn_amid():
    believed = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [0.25], "denominator": [1.0, 4.0, 160.0]}},
        "sensor": {"column": "x", "kind": "instant"},
        "initial_state": "estimate",
    }
    diagnosis = camid.diagnose(slider(0), believed)
    assert [f.identifier for f in diagnosis.findings] == ["position-dependent-friction"]
    found = diagnosis.findings[0]
    assert found.weight > 0.9
    for name, value in {"force": 0.25, "gradient": 12.0, "curvature": 7.5e3}.items():
        number = found.parameters[name]
        assert abs(number.value - value) < max(4.0 * number.standard_deviation, 0.02 * value), name


def linear_motor(seed, count=2500):
    """A linear motor in a loop that nobody declares: t, u and x. Its poles pull with a harmonic half as large."""
    random = np.random.default_rng([52, seed])
    time = PERIOD * np.arange(count)
    turns = random.uniform(0.8, 1.2, 3) * np.array([0.6, 1.1, 1.7])
    wanted = np.sin(np.outer(time, turns) + random.uniform(0.0, 6.0, 3)) @ np.array([0.05, 0.03, 0.02])
    place, speed, rows = wanted[0], 0.0, np.zeros((count, 2))
    for k in range(count):
        command = 60.0 * (wanted[k] - place - 6e-5 * random.standard_normal()) - 8.0 * speed
        rows[k] = command, place
        for _ in range(SUBSTEPS):
            angle = 2.0 * np.pi * place / 0.024
            detent = 0.4 * np.sin(angle + 0.7) + 0.2 * np.sin(2.0 * angle - 1.1)
            speed += PERIOD / SUBSTEPS * (0.8 * (command - detent) - 5.0 * speed)
            place += PERIOD / SUBSTEPS * speed
    noisy = rows[:, 1] + 6e-5 * random.standard_normal(count)
    return pd.DataFrame({"t": time, "u": rows[:, 0], "x": noisy})


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.slow
def test_poles_of_a_motor_in_a_loop_that_is_not_declared(seed):
    believed = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [1.0], "denominator": [1.0, 3.5, 0.0]}},
        "sensor": {"column": "x", "kind": "instant"},
        "initial_state": "estimate",
    }
    diagnosis = camid.diagnose(linear_motor(seed), believed)
    found = {f.identifier: f for f in diagnosis.findings}["cogging"]
    assert found.weight > 0.9
    for name, value in {"amplitude": 0.4, "period": 0.024, "harmonic_amplitude": 0.2}.items():
        number = found.parameters[name]
        assert abs(number.value - value) < max(4.0 * number.standard_deviation, 0.01 * value), name
