"""Which of the optima that starts lead to is taken."""

from types import SimpleNamespace

import numpy as np
import pytest

from camid.identification.optimum_selection import Optimum, select

PERIOD, ROWS = 0.025, 3200


def optimum(denominator, cost, *, converged):
    """Where an iteration ended, with the poles of a denominator in rad/s."""
    predictor = SimpleNamespace(
        target=np.ones(ROWS),
        target_norm=np.sqrt(ROWS),
        free=np.ones(3, bool),
        time_unit=1.0,
        structure=SimpleNamespace(order=2),
        experiments=[SimpleNamespace(acquisition=SimpleNamespace(period=PERIOD))],
        split=lambda parameters: (np.ones(1), parameters),
    )
    fit = SimpleNamespace(parameters=np.array(denominator), cost=cost, converged=converged, iterations=9)
    return Optimum(predictor, fit)


RUNAWAY = optimum((1.0, 1.4e6, 2.0e6), 22.5, converged=False)
ALIAS = optimum((1.0, 0.3, 6.3e4), 17.5, converged=True)
SLOW = optimum((1.0, 0.03, 0.17), 191.0, converged=True)
BELIEVED = np.roots([1.0, 9.0, 170.0])


@pytest.mark.parametrize("believed", [None, BELIEVED])
def test_a_pole_that_runs_to_infinity_is_no_alias_and_better_than_an_optimum_that_explains_hardly_anything(believed):
    """Hysteresis makes a magnet look like a plant with one pole, and neither an alias nor a slow mode explains that."""
    assert select([RUNAWAY, ALIAS, SLOW], believed, 0.001) is RUNAWAY
    assert select([RUNAWAY, SLOW], believed, 0.001) is RUNAWAY


@pytest.mark.parametrize("believed", [None, BELIEVED])
def test_an_optimum_that_explains_as_much_is_better_than_a_pole_that_runs_to_infinity(believed):
    near = optimum((1.0, 80.0, 120.0), 22.55, converged=True)
    assert select([RUNAWAY, ALIAS, SLOW, near], believed, 0.001) is near


def test_an_alias_that_explains_all_is_taken_where_nothing_slower_does():
    assert select([RUNAWAY, ALIAS, SLOW], None, 17.5 / ROWS) is ALIAS
