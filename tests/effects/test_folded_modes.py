"""Modes beyond the Shannon limit, which a camera shows folded about that."""

import numpy as np
import pytest

import camid
from tests.support.mass_on_spring import PERIOD, effect, record, simulation

LIMIT = np.pi / PERIOD


@pytest.mark.parametrize("frequency", [1.3 * LIMIT, 1.62 * LIMIT])
def test_a_mode_beside_the_plant_is_found_where_it_is(frequency):
    """Its line in the residual lies at twice the limit less that, where a mode explains most of it, and not all."""
    hidden = effect("parallel-mode", gain=0.02, natural_frequency=frequency, damping=0.01)
    table = record(hidden, count=2000, exposure=0.2 * PERIOD)
    diagnosis = camid.diagnose(table, simulation(sensor={"column": "y", "kind": "camera", "exposure": 0.2 * PERIOD}))
    (found,) = diagnosis.findings
    assert found.identifier == "parallel-mode"
    estimate = found.parameters["natural_frequency"]
    assert abs(estimate.value - frequency) < 3.0 * estimate.standard_deviation < 0.01 * frequency
