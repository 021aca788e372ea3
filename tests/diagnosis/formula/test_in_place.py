"""A formula in the place of a curve: the points that carry it."""

import numpy as np
import pytest

from camid.diagnosis.laws.formula.in_place import enough_points


@pytest.mark.parametrize("law", [np.sin, np.abs, np.tanh, lambda x: np.clip(x, -0.5, 0.7)])
def test_straight_lines_between_the_points_miss_no_other_one(law):
    at = np.linspace(-3.0, 3.0, 601)
    heights = law(at)
    few = enough_points(at, heights, 1e-3)
    assert few[0] == 0
    assert few[-1] == 600
    assert len(few) < 100
    assert np.max(np.abs(np.interp(at, at[few], heights[few]) - heights)) <= 1e-3


def test_a_kink_needs_one_point():
    at = np.linspace(-1.0, 1.0, 201)
    assert enough_points(at, np.abs(at), 1e-9).tolist() == [0, 100, 200]
