"""A share of the command in the reading: of a sensor's wire, and of a camera whose mount yields to the drive."""

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.rows_of_the_log import InputPickup, InputPickupOfRowBefore
from camid.effects.situation import Situation

ROWS = 400


@pytest.mark.parametrize("sensor", ["camera", "instant"])
def test_it_is_looked_for_whatever_reads_the_motion(sensor):
    signal = np.repeat(np.random.default_rng(1).choice([-1.0, 1.0], ROWS // 8), 8)
    moved = np.cumsum(signal) * 0.01
    acquisition = Acquisition(0.01, sensor=sensor, exposure=0.005 if sensor == "camera" else None)
    plant, used = TransferFunction((1.0,), (1.0, 1.0, 1.0)), np.ones(ROWS, bool)
    situation = Situation(
        0.01 * np.arange(ROWS), signal, moved, moved, np.gradient(moved, 0.01), 0.0 * moved, plant, acquisition, used
    )
    assert InputPickup.invisible(situation) is None
    assert [type(law) for law in InputPickup.candidates(situation)] == [InputPickup, InputPickupOfRowBefore]


def test_the_row_before_is_picked_up_where_the_reading_comes_first():
    signal = np.array([1.0, -2.0, 3.0])
    np.testing.assert_array_equal(InputPickup(coefficient=0.5).picked_up(signal), [0.5, -1.0, 1.5])
    before = InputPickupOfRowBefore(coefficient=0.5, row="before").picked_up(signal)
    np.testing.assert_array_equal(before, [0.0, 0.5, -1.0])
