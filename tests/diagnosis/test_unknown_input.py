"""Recordings that begin in motion: what was before them is unknown, and no delay is to answer for it."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.diagnosis.residual.validation_rows import without_unknown_input
from camid.identification.from_recordings import experiments_of
from camid.simulation.file import load_simulation

PERIOD, COUNT, BEFORE = 1.0, 1200, 300
GAIN, RATE, DEAD_TIME = 0.0105, 1.0 / 85.0, 6.5


def heater(seed):
    """A first-order plant whose recording begins while it warms up, by steps of half a period, exactly."""
    random = np.random.default_rng([6, seed])
    power = np.repeat(random.uniform(10.0, 60.0, (BEFORE + COUNT) // 25 + 1), 25)[: BEFORE + COUNT]
    states = [0.0]
    decay = np.exp(-0.5 * RATE * PERIOD)
    for k in range(BEFORE + COUNT):
        for _ in range(2):
            states.append(decay * states[-1] + GAIN / RATE * (1.0 - decay) * power[k])
    late = np.asarray(states)[2 * BEFORE - 13 :][: 2 * COUNT : 2]
    temperature = 20.0 + late + 0.1 * random.standard_normal(COUNT)
    return pd.DataFrame({"t": PERIOD * np.arange(COUNT), "power": power[BEFORE:], "temperature": temperature})


def believed(**more):
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "power", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [0.0075], "denominator": [1.0, 1.0 / 120.0]}},
        "sensor": {"column": "temperature", "kind": "instant", "offset": "estimate"},
        "initial_state": "estimate",
        **more,
    }


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.slow
def test_the_dead_time_of_a_heater_that_is_warming_up(seed):
    found = camid.diagnose(heater(seed), believed())
    assert [f.identifier for f in found.findings] == ["delay"]
    delay = found.findings[0].parameters["delay"]
    assert abs(delay.value - DEAD_TIME) < 4.0 * delay.standard_deviation
    assert delay.standard_deviation < 0.1


@pytest.mark.parametrize(
    ("changes", "rows"),
    [({}, COUNT // 50), ({"sensor": {"column": "temperature", "kind": "instant", "latency": 3.0}}, 3 + COUNT // 50),
     ({"initial_state": "zero"}, 0)],
)  # fmt: skip
def test_the_first_rows_of_a_start_that_is_unknown_are_not_compared(changes, rows):
    simulation = load_simulation(believed(**changes))
    _, experiments, held_out = experiments_of(heater(0), simulation, None)
    (experiment,), _ = without_unknown_input(experiments, held_out, simulation)
    assert np.argmax(experiment.used) == rows


def test_a_short_recording_keeps_nearly_all_of_its_rows():
    simulation = load_simulation(believed())
    _, experiments, held_out = experiments_of(heater(0).head(120), simulation, None)
    (experiment,), _ = without_unknown_input(experiments, held_out, simulation)
    assert np.count_nonzero(~experiment.used) == 2
