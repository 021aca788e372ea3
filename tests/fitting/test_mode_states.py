"""Modes beside and after the plant, and lags before it, may be in motion when the recording begins, as it may."""

import numpy as np
import pandas as pd
import pytest
from scipy.signal import cont2discrete

import camid

PERIOD, LEAD, COUNT = 0.01, 400, 900
FREQUENCY, DAMPING = 35.0, 0.02
LAG = 0.15
EFFECTS = {
    "series": {"id": "extra-mode", "parameters": {"natural_frequency": FREQUENCY, "damping": DAMPING}},
    "parallel": {
        "id": "parallel-mode",
        "parameters": {"gain": -0.3, "natural_frequency": FREQUENCY, "damping": DAMPING},
    },
    "before": {"id": "actuator-lag", "parameters": {"time_constant": LAG}},
}


def moving(kind):
    """A recording that begins while plant and mode are in motion: exact steps of the whole system, of held inputs."""
    plant, denominator = np.array([30.0]), np.array([1.0, 0.7, 30.0])
    mode, square = np.array([FREQUENCY**2]), np.array([1.0, 2.0 * DAMPING * FREQUENCY, FREQUENCY**2])
    if kind == "series":
        system = (np.polymul(plant, mode), np.polymul(denominator, square))
    elif kind == "before":
        system = (plant, np.polymul(denominator, [LAG, 1.0]))
    else:
        beside = -0.3 * np.polymul(mode, denominator)
        system = (np.polyadd(np.polymul(plant, square), beside), np.polymul(denominator, square))
    from scipy.signal import tf2ss

    matrix, entry, row, _, _ = cont2discrete(tf2ss(*system), PERIOD)
    random = np.random.default_rng(np.random.SeedSequence(3))
    signal = np.repeat(random.choice([-1.0, 1.0], (LEAD + COUNT) // 10), 10)
    state, output = np.zeros(len(matrix)), []
    for value in signal:
        output.append(float(row[0] @ state))
        state = matrix @ state + entry[:, 0] * value
    table = pd.DataFrame({"t": PERIOD * np.arange(LEAD + COUNT), "u": signal, "y": output})[LEAD:]
    return table.assign(t=table.t - table.t.iloc[0]).reset_index(drop=True)


def simulation(effects):
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [30.0], "denominator": [1.0, 0.7, 30.0]}},
        "sensor": {"column": "y", "kind": "instant"},
        "initial_state": "estimate",
        "effects": effects,
    }


@pytest.mark.parametrize("kind", EFFECTS)
def test_a_mode_in_motion_is_simulated_from_where_it_was(kind):
    table = moving(kind)
    simulated = camid.simulate(table, simulation([EFFECTS[kind]]))
    error = np.std(simulated["simulated"] - table["y"]) / np.std(table["y"])
    assert error < 1e-4


@pytest.mark.slow
def test_a_concealed_mode_in_motion_is_found():
    table = moving("series")
    random = np.random.default_rng(np.random.SeedSequence(4))
    noisy = table.assign(y=table.y + 0.01 * np.std(table.y) * random.standard_normal(len(table)))
    found = camid.diagnose(noisy, simulation([]))
    (effect,) = found.findings
    assert effect.identifier == "extra-mode"
    frequency = effect.parameters["natural_frequency"]
    assert abs(frequency.value - FREQUENCY) < 4.0 * frequency.standard_deviation


def test_a_thermometer_in_a_heater_that_is_warm_already_lags():
    """Without a state of the lag the recording would begin with another course than it has."""
    period, lag, rate, gain = 0.1, 2.5, 0.06, 2.2
    random = np.random.default_rng(np.random.SeedSequence(8))
    signal = np.repeat(random.choice([0.0, 0.4, 1.0], 20), 90)
    matrices = np.array([[-rate, 0.0], [1.0 / lag, -1.0 / lag]]), np.array([[gain], [0.0]])
    heater, entry, _, _, _ = cont2discrete((*matrices, np.array([[0.0, 1.0]]), np.zeros((1, 1))), period)
    state, output = np.array([20.0, 20.0]), []
    for value in signal:
        output.append(state[1])
        state = heater @ state + entry[:, 0] * value
    table = pd.DataFrame({"t": period * np.arange(len(signal)), "u": signal, "T": output})
    table["T"] += 0.05 * random.standard_normal(len(table))
    found = camid.diagnose(
        table,
        {
            "schema": 1,
            "time": {"column": "t"},
            "input": {"column": "u", "hold": "zoh"},
            "plant": {"transfer_function": {"numerator": [1.8], "denominator": [1.0, 0.07]}},
            "sensor": {"column": "T", "kind": "instant"},
            "initial_state": "estimate",
        },
    )
    (finding,) = found.findings
    assert (finding.identifier, found.verdict) == ("actuator-lag", "explained")
    estimate = finding.parameters["time_constant"]
    assert abs(estimate.value - lag) < 4.0 * estimate.standard_deviation < 0.05 * lag
