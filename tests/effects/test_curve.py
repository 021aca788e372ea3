"""A curve through points, in Python and in compiled code."""

import numpy as np
import pytest

from camid.effects import Curve, on_curve

KNOTS, HEIGHTS = (-2.0, -1.0, 0.5, 3.0), (1.0, -3.0, -3.0, 2.0)


@pytest.mark.parametrize("first", [0, 3])
def test_compiled_and_not_compiled_are_the_same(first):
    curve = Curve(KNOTS, HEIGHTS)
    at = np.linspace(-4.0, 5.0, 181)
    values = np.array([9.0] * first + curve.numbers)
    compiled = [on_curve(x, values, first) for x in at]
    assert compiled == pytest.approx(curve(at), abs=1e-14)
    assert curve(np.array([-9.0, -1.5, 1.75, 9.0])) == pytest.approx([1.0, -1.0, -0.5, 2.0])


@pytest.mark.parametrize(
    ("knots", "heights", "says"),
    [((0.0, 0.0), (1.0, 2.0), "increasing"), ((1.0,), (1.0,), "at least 2"), ((0.0, 1.0), (1.0,), "2 knots, but 1")],
)
def test_impossible_curves_are_refused(knots, heights, says):
    with pytest.raises(ValueError, match=says):
        Curve(knots, heights)
