"""Times in another unit than seconds make coefficients that no rig has, by powers of its size."""

import pytest

from camid.diagnosis.diagnosis import Coefficient
from camid.diagnosis.time_unit import said_of_time_unit


def coefficients(factor, **given):
    """As re-estimated with times that are larger by a factor, and a tenth off beside that."""
    order = len(given) - 1
    powers = {"b0": order, **{f"a{k}": order - k for k in range(order)}}
    return [
        Coefficient(name, value, 1.1 * value / factor ** powers[name], 0.0, value, 0.0) for name, value in given.items()
    ]


@pytest.mark.parametrize(("factor", "unit"), [(1e3, "ms"), (1e6, "us"), (1.0 / 60.0, "min"), (1.0 / 3600.0, "h")])
def test_coefficients_that_are_off_by_powers_of_a_unit_say_it(factor, unit):
    (said,) = said_of_time_unit(coefficients(factor, b0=420.0, a1=9.0, a0=330.0), "t", declared=False)
    assert f"time: {{column: t, unit: {unit}}}" in said
    assert said_of_time_unit(coefficients(factor, b0=20.0, a1=9.0, a0=0.0), "t", declared=False) == [said]


def test_others_say_nothing():
    given = {"b0": 420.0, "a1": 9.0, "a0": 330.0}
    assert said_of_time_unit(coefficients(1.5, **given), "t", declared=False) == []
    assert said_of_time_unit(coefficients(1e3, **given), "t", declared=True) == []
    # One that is far off alone is another rig.
    odd = [*coefficients(1.0, **given)[:2], Coefficient("a0", 330.0, 3.3e-4, 0.0, 3.3e-4, 0.0)]
    assert said_of_time_unit(odd, "t", declared=False) == []
