"""Which part of a recording judges."""

from types import SimpleNamespace

import numpy as np
import pytest

from camid.diagnosis.residual.validation_rows import _quiet_part

ROWS = 1000
NOISE = np.random.default_rng(1).standard_normal(ROWS)
MOTION = np.sin(0.3 * np.arange(ROWS))


def judging(residual, motion=MOTION, first_used=0, integrates=False):
    """Which fifth judges."""
    experiment = SimpleNamespace(output=motion, used=np.arange(ROWS) >= first_used)
    (rows,) = np.nonzero(_quiet_part(experiment, residual, integrates))
    assert len(rows) == ROWS // 5
    return rows[0] // (ROWS // 5)


@pytest.fixture
def blow():
    """What a blow in the last fifth leaves."""
    residual = NOISE.copy()
    residual[850:900] += 20.0
    return residual


def test_the_last_fifth_judges_that_moves():
    assert judging(NOISE) == 4
    assert judging(NOISE, np.where(np.arange(ROWS) < 700, MOTION, 0.0)) == 3


def test_an_event_is_fitted_and_does_not_judge(blow):
    assert judging(blow) != 4


def test_rows_that_are_not_fitted_hide_no_event(blow):
    """The first rows of a recording that begins in motion may be anywhere."""
    blow[:15] = 1e6
    assert judging(blow) == 4  # beside them the event is nothing
    assert judging(blow, first_used=20) != 4


def test_an_event_is_fitted_where_the_rig_rests_in_the_end(blow):
    residual = np.roll(blow, -200)
    rests = np.where(np.arange(ROWS) < 800, MOTION, 0.0)
    assert judging(residual, rests) in (1, 2)


def test_beside_a_pendulum_that_turns_over_in_the_end_other_parts_do_not_rest(blow):
    turns = np.where(np.arange(ROWS) < 850, MOTION, 200.0)
    assert judging(blow, turns) in (1, 2, 3)


@pytest.mark.parametrize(("farther", "part"), [(1.05, 4), (1.3, 3)])
def test_a_part_that_goes_farther_than_all_others_does_not_judge_them(farther, part):
    """A stop that is reached there alone would speak against all that is right before it."""
    goes_farther = np.where(np.arange(ROWS) < 800, MOTION, farther * MOTION)
    assert judging(NOISE, goes_farther, integrates=True) == part
    assert judging(NOISE, goes_farther) == 4  # whose way a spring bounds


def test_a_recording_that_goes_on_and_on_is_judged_between_others():
    assert judging(NOISE, MOTION + 0.02 * np.arange(ROWS), integrates=True) == 3
