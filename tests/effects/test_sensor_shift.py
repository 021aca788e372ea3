"""A camera that is knocked: from then on it reads all positions elsewhere."""

import numpy as np
import pytest

import camid
from camid.effects.sensor_shift import SensorShift
from tests.support.mass_on_spring import PERIOD, record, simulation


def test_it_adds_a_step_and_the_first_frame_after_it_says_when():
    time = PERIOD * np.arange(6)
    shift = SensorShift(size=2.0, time=2.0 * PERIOD)
    np.testing.assert_allclose(shift.observe(np.ones(6), time), [1.0, 1.0, 1.0, 3.0, 3.0, 3.0])
    later = SensorShift(size=2.0, time=2.25 * PERIOD)
    np.testing.assert_allclose(later.observe(np.ones(6), time), [1.0, 1.0, 1.0, 2.5, 3.0, 3.0])


@pytest.mark.parametrize("row", [60, 431])
def test_a_knock_is_found_and_told_from_a_force_that_sets_in(row):
    recording = record(count=900)
    recording.loc[recording.index >= row, "y"] += 0.06
    found = camid.diagnose(recording, simulation())
    assert [f.identifier for f in found.findings] == ["sensor-drift"]
    parameters = found.findings[0].parameters
    size = parameters["size"]
    assert abs(size.value - 0.06) < 4.0 * size.standard_deviation < 0.02
    # Any moment between the two frames leaves the same readings.
    time = parameters["time"]
    for moment in np.linspace(row - 0.99, row, 5) * PERIOD:
        assert abs(time.value - moment) < 2.0 * time.standard_deviation < 2.0 * PERIOD


def test_a_force_that_sets_in_is_told_from_a_knock():
    recording = record(camid.effects.disturbance.StepDisturbance(size=0.1, time=6.03), count=900)
    found = camid.diagnose(recording, simulation())
    assert [f.identifier for f in found.findings] == ["step-disturbance"]
