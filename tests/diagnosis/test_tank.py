"""A tank that empties by Torricelli's law, whose pump has an end, read off a scale of two millimetres."""

import numpy as np
import pandas as pd
import pytest

import camid

PERIOD, SUBSTEPS, STEP = 1.0 / 30.0, 4, 0.002
GAIN, LINEAR, OUTFLOW, LIMIT = 0.004, 0.03, 8.0, 6.5


def filled(seed, count=3600):
    """Levels in m, rounded, of a tank whose level follows a pump with levels of its own."""
    random = np.random.default_rng([12, seed])
    pump = np.repeat(random.permutation(np.linspace(1.0, 8.5, count // 240)), 240)
    level, seen = 0.12, np.zeros(count)
    for k in range(count):
        seen[k] = level
        for _ in range(SUBSTEPS):
            rate = GAIN * (min(pump[k], LIMIT) - OUTFLOW * np.sqrt(max(level, 0.0))) - LINEAR * level
            level += PERIOD / SUBSTEPS * rate
    noisy = seen + 8e-4 * random.standard_normal(count)
    return pd.DataFrame({"t": PERIOD * np.arange(count), "pump": pump, "level": STEP * np.round(noisy / STEP)})


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_the_law_of_torricelli_beside_a_saturation(seed):
    """Springs that soften are nearly as good: where the levels hardly tell, both are said."""
    believed = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "pump", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [0.003], "denominator": [1.0, 0.12]}},
        "sensor": {"column": "level", "kind": "instant"},
        "initial_state": "estimate",
    }
    diagnosis = camid.diagnose(filled(seed), believed)
    saturation, outflow, quantisation = diagnosis.findings
    assert [saturation.identifier, quantisation.identifier] == ["saturation", "quantisation"]
    names = [outflow.identifier, *(name for name, _ in outflow.alternatives)]
    assert "square-root-outflow" in names
    estimates = [(saturation.parameters["limit"], LIMIT)]
    if names[0] == "square-root-outflow":
        estimates.append((outflow.parameters["coefficient"], OUTFLOW))
    for value, truth in estimates:
        assert abs(value.value - truth) < 4.0 * value.standard_deviation < 0.2 * truth


@pytest.mark.slow
def test_a_tank_that_is_believed_to_fill_alone_runs_empty_at_times():
    """Nothing leaves it in proportion to its level, and its scale counts from elsewhere."""
    random = np.random.default_rng(31)
    pump = np.repeat(random.choice([0.0, 2.0, 3.5, 5.0], 40), 60)
    rate, outflow, zero = 0.005, 7.7, 0.0125
    level, seen = 0.04, np.zeros(len(pump))
    for k, given in enumerate(pump):
        seen[k] = level
        for _ in range(50):
            change = rate * (given - outflow * np.sqrt(max(level, 0.0)))
            level = max(level + 0.1 / 50 * change, 0.0)
    reading = seen + zero + 3e-4 * random.standard_normal(len(pump))
    table = pd.DataFrame({"t": 0.1 * np.arange(len(pump)), "pump": pump, "level": reading})
    believed = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "pump", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [0.0035], "denominator": [1.0, 0.0]}},
        "sensor": {"column": "level", "kind": "instant"},
        "initial_state": "estimate",
    }
    diagnosis = camid.diagnose(table, believed)
    outflows = [f for f in diagnosis.findings if f.identifier == "square-root-outflow"]
    assert outflows
    assert outflows[0].weight > 0.5
    found = outflows[0].parameters["coefficient"]
    assert abs(found.value - outflow) < 4.0 * found.standard_deviation < 0.1 * outflow
