"""From what rivals would leave to the weights that a diagnosis would state."""

from math import exp
from types import SimpleNamespace

import pytest

from camid.diagnosis.weights import Comparison, calibrated, weight_outside
from camid.effects.friction import CoulombFriction
from camid.effects.sensor import Delay
from camid.experiment_design.general_laws import GeneralLaw
from camid.experiment_design.hypothesis import GIVEN
from camid.experiment_design.separation import Judge, Pair


def name(identifier, effect, question="friction"):
    return SimpleNamespace(
        identifier=identifier, effect=effect, question=question, count=3, criterion=0.0, misfit=0.0, weight=0.5
    )


def judge(*weights, **changes):
    """Of names with these weights, none of them friction."""
    names = [name(f"name {i}", None) for i in range(len(weights))]
    for one, its in zip(names, weights, strict=True):
        one.weight = its
    return Judge(names, rows_before=500, **changes)


def weight(first, rival, left=1e4, experiments=2):
    judge = Judge([first, rival], rows_before=500, experiments=experiments)
    return judge.weight(0, [Pair(0, 1, left, 1e4)], 500)


def stated(**changes):
    """Of a law that removes ten thousand variances of the noise."""
    return 1.0 - weight_outside(Comparison((), 1.0, 0.0, gain=1e4, experiments=2, **changes), calibrated())


FRICTION, DELAY = CoulombFriction(force=1.0), Delay(delay=0.01)


def test_what_is_promised_is_what_a_diagnosis_states_where_nothing_is_left():
    """Physics outside the catalogue keeps its weight however far the rivals are behind."""
    found = weight(name("coulomb-friction", FRICTION), name("delay", DELAY))
    assert found == pytest.approx(stated(), abs=1e-6)
    assert 0.95 < found < 1.0


def test_another_input_says_nothing_of_what_imitates_linear_dynamics():
    found = weight(name("delay", DELAY), name("coulomb-friction", FRICTION))
    assert found == pytest.approx(stated(linear=True), abs=1e-6)


def test_one_of_two_simulations_is_right():
    found = weight(name("one.yaml", None, GIVEN), name("other.yaml", None, GIVEN))
    assert found == pytest.approx(1.0, abs=1e-6)


def test_equal_rivals_share_the_weight():
    found = weight(name("coulomb-friction", FRICTION), name("delay", DELAY), left=0.0)
    assert found == pytest.approx(0.5 * stated(), rel=1e-6)


def test_a_weight_is_expected_over_the_noise_of_the_next_recording():
    """Evidence of sixteen would decide if it came as it is; as often as not it is half of that, or less."""
    two = judge(0.5, 0.5)
    expected = [two.weight(0, [Pair(0, 1, left, 1e4)], 500) for left in (4.0, 16.0, 64.0, 256.0)]
    assert expected == sorted(expected)
    certain = stated() / (1.0 + exp(-8.0))
    assert expected[1] < certain - 0.02
    assert expected[3] == pytest.approx(stated(), abs=1e-3)


def test_two_names_decided_are_worth_more_than_one_beyond_doubt():
    two = judge(0.5, 0.5)

    def score(one, other):
        # Of a mismatch of which a rival leaves more than an inexact law does.
        return two.score([Pair(0, 1, one, 1e3), Pair(1, 0, other, 1e3)], 500)

    assert score(40.0, 40.0) > score(4000.0, 4.0)
    assert score(60.0, 60.0) > score(40.0, 40.0)  # more in reserve


def test_an_effect_has_to_show_and_not_only_that_it_is_no_rival():
    """Physics outside the catalogue keeps what the effect does not show: a hundred variances of noise are 96 %."""
    two = judge(0.5, 0.5)

    def found(left, mismatch):
        pairs = [Pair(0, 1, left, mismatch), Pair(1, 0, left, mismatch)]
        return two.score(pairs, 500), two.weight(0, pairs, 500)

    (beyond_doubt, one), (shown, other) = found(100.0, 100.0), found(24.0, 400.0)
    assert 0.95 < one < other
    assert shown > beyond_doubt


def test_simulations_held_against_each_other_have_nothing_outside():
    pairs = [Pair(0, 1, 60.0, 60.0)]
    given, named = (
        Judge([name("one", None, question), name("other", None, question)], 500).separation(0, pairs, 500)
        for question in (GIVEN, "friction")
    )
    assert given > named + 0.3


def test_all_rivals_count_and_not_the_nearest_alone():
    few, many = judge(0.5, 0.5), judge(0.5, 0.2, 0.2, 0.1)
    one = few.weight(0, [Pair(0, 1, 12.0, 1e4)], 500)
    three = many.weight(0, [Pair(0, i, 12.0, 1e4) for i in (1, 2, 3)], 500)
    assert three < one - 0.02


def test_an_effect_that_is_hardly_known_promises_less():
    """Evidence goes with the square of its size: of a weak effect that may be half as much."""
    names = [*judge(0.5, 0.5).hypotheses, name("", None)]
    pairs = [Pair(0, 1, 25.0, 1e4)]
    found = []
    for misfit in (9.0, 900.0):
        names[2].misfit = misfit
        found.append(Judge(names, 500).weight(0, pairs, 500))
    assert found[0] < found[1] - 0.01


def test_general_laws_that_are_not_listed_take_their_share():
    law = GeneralLaw("a general law", "name 0", 1, 1.7)
    with_it, without = judge(0.5, 0.5, general=[law]), judge(0.5, 0.5)

    def taken(true, mismatch):
        pairs = [Pair(0, 1, 1e3, mismatch), Pair(1, 0, 1e3, mismatch)]
        return without.weight(true, pairs, 500) - with_it.weight(true, pairs, 500)

    assert taken(0, 1e3) > 0.01
    assert taken(1, 1e3) == 0.0
    assert taken(0, 1e5) < 0.2 * taken(0, 1e3)  # beforehand as large as the effect, and nothing of it shows
