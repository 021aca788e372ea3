"""From what rivals would leave to the weights that a diagnosis would state."""

from types import SimpleNamespace

import pytest

from camid.diagnosis.weights import Comparison, calibrated, weight_outside
from camid.effects.friction import CoulombFriction
from camid.effects.sensor import Delay
from camid.experiment_design.hypothesis import GIVEN
from camid.experiment_design.separation import Judge, Pair


def name(identifier, effect, question="friction"):
    return SimpleNamespace(
        identifier=identifier, effect=effect, question=question, count=3, criterion=0.0, misfit=0.0, weight=0.5
    )


def weight(first, rival, left=1e4, experiments=2):
    judge = Judge([first, rival], rows_before=500, experiments=experiments)
    return judge.weight(0, [Pair(0, 1, left, 1e4)], 500)


def stated(experiments):
    return 1.0 - weight_outside(Comparison((), 1.0, 0.0, experiments=experiments), calibrated())


FRICTION, DELAY = CoulombFriction(force=1.0), Delay(delay=0.01)


def test_what_is_promised_is_what_a_diagnosis_states_where_nothing_is_left():
    """Physics outside the catalogue keeps its weight however far the rivals are behind."""
    found = weight(name("coulomb-friction", FRICTION), name("delay", DELAY))
    assert found == pytest.approx(stated(2), abs=1e-6)
    assert 0.95 < found < 0.99


def test_another_input_says_nothing_of_what_imitates_linear_dynamics():
    found = weight(name("delay", DELAY), name("coulomb-friction", FRICTION))
    assert found == pytest.approx(stated(1), abs=1e-6)


def test_one_of_two_simulations_is_right():
    found = weight(name("one.yaml", None, GIVEN), name("other.yaml", None, GIVEN))
    assert found == pytest.approx(1.0, abs=1e-6)


def test_equal_rivals_share_the_weight():
    found = weight(name("coulomb-friction", FRICTION), name("delay", DELAY), left=0.0)
    assert found == pytest.approx(0.5 * stated(2), rel=1e-6)
