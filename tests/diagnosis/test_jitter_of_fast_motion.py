"""Jitter of the time stamps where the motion turns round within a few frames."""

import numpy as np

import camid
from camid.chain.plant import TransferFunction
from tests.support.mass_on_spring import PERIOD, record, simulation

# A resonance of five frames a turn.
PLANT = TransferFunction((3900.0,), (1.0, 4.0, 3900.0))
COUNT, JITTER = 3000, 0.05 * PERIOD


def test_jitter_of_a_fast_motion_is_not_overestimated():
    step = 1e-3 * PERIOD
    recording, earlier = (
        record(count=COUNT, noise=0.0, plant=PLANT, latency=latency)["y"].to_numpy() for latency in (0.0, step)
    )
    rate = (recording - earlier) / step
    random = np.random.default_rng(11)
    output = recording + JITTER * random.standard_normal(COUNT) * rate + 0.01 * random.standard_normal(COUNT)
    table = record(count=COUNT, noise=0.0, plant=PLANT).assign(y=output)
    believed = {"transfer_function": {"numerator": [3900.0], "denominator": [1.0, 4.0, 3900.0]}}
    diagnosis = camid.diagnose(table, simulation(plant=believed))
    (found,) = (f.parameters["std"] for f in diagnosis.findings if f.identifier == "timestamp-jitter")
    assert abs(found.value - JITTER) < 2.5 * found.standard_deviation
