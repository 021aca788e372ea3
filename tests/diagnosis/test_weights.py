"""Weights of the names that a recording cannot tell apart, and of physics outside the catalogue."""

from dataclasses import replace
from math import exp, log
from types import SimpleNamespace

import numpy as np
import pytest

from camid.diagnosis.verdict import different_inputs
from camid.diagnosis.weights import (
    LARGEST_CLASS,
    LEAST_WEIGHT,
    Comparison,
    Constants,
    Member,
    penalty_of_generality,
    weight_outside,
    weights,
)
from camid.effects import known_effects
from camid.effects.base import Effect

CONSTANTS = Constants(0.3, 0.05, 40.0, 0.0, 0.5, -0.5, 0.7, -2.0, 1.5)
LEAD = Member("coulomb-friction", 0.0, 0.0)
# Finely shown: a ten thousandth of it may be there without a test seeing it.
IMITATORS = [
    (name, known_effects()[name], values)
    for name, values in (
        ("input-hold", {"hold": "foh"}),
        ("actuator-lag", {"time_constant": 0.1}),
        ("coulomb-friction", {"force": 1.0}),
    )
]
ALONE = Comparison((LEAD,), share=0.9, left=0.0, gain=4e5)


def of(*members, **changes):
    """Names and their weights beside the likeliest."""
    names, unlisted = weights(replace(ALONE, members=(LEAD, *members), **changes), CONSTANTS)
    assert sum(weight for _, weight in names) + unlisted == pytest.approx(1.0)
    return dict(names)


def test_equal_fits_have_equal_weights():
    found = of(Member("quadratic-drag", 0.0, 0.0))
    assert found["coulomb-friction"] == pytest.approx(found["quadratic-drag"])


def test_a_name_that_is_there_twice_is_named_once_with_both_weights():
    """As a rival of its own, and as the sum of two effects that are found."""
    apart = of(Member("asymmetric-friction", 2.0, 0.0), Member("dead-zone", 7.0, 0.0))
    twice = of(Member("asymmetric-friction", 2.0, 0.0), Member("asymmetric-friction", 7.0, 0.0))
    assert twice["asymmetric-friction"] == pytest.approx(apart["asymmetric-friction"] + apart["dead-zone"])


def test_an_exact_law_that_the_criterion_rules_out_may_still_be_another_of_its_name():
    found = of(Member("near", 100.0, 0.01), Member("far", 100.0, 0.5))
    assert found["near"] / found["coulomb-friction"] == pytest.approx(0.3 * 2.718281828 ** (-0.2), rel=1e-6)
    assert "far" not in found


def test_a_special_case_counts_as_the_law_that_it_is_special_of():
    assert of(Member("special", 500.0, 0.9, special=True))["special"] == pytest.approx(
        0.3 * of(Member("special", 500.0, 0.9, special=True))["coulomb-friction"]
    )


def test_a_general_law_that_says_no_more_has_a_smaller_prior():
    found = of(Member("hysteresis", -3.0, -0.01, general=True))
    assert found["hysteresis"] == pytest.approx(3.0 / 7.0 * found["coulomb-friction"])


def test_a_general_law_that_does_nothing_more_is_not_there_whether_exact_or_not():
    found = of(Member("stribeck-friction", 4.0, 0.0, general=True))
    expected = exp(-2.0) * (0.7 + 0.3 * 3.0 / 7.0)
    assert found["stribeck-friction"] == pytest.approx(expected * found["coulomb-friction"])


@pytest.mark.parametrize(("gain", "asked"), [(4e5, 400.0), (200.0, 1.0)])
def test_what_makes_a_law_general_is_beforehand_as_large_as_the_effect(gain, asked):
    """The criterion takes it for as large as one of a thousand rows shows; a noisy recording says no more than that."""
    member = Member("stribeck-friction", 2.0, 0.0, general=True, more=2)
    comparison = replace(ALONE, gain=gain, rows=1000)
    added = penalty_of_generality(member, comparison)
    assert added == pytest.approx(2.0 * log(asked), abs=1e-5)
    assert penalty_of_generality(replace(member, general=False), comparison) == 0.0
    found = of(member, gain=gain, rows=1000)
    plain = of(replace(member, gap=2.0 + added, more=0), gain=gain, rows=1000)
    assert found == pytest.approx(plain)


def test_a_class_is_small_and_without_remote_names():
    found = of(*(Member(f"name-{i}", 2.0 * i, 1.0) for i in range(12)))
    assert len(found) == LARGEST_CLASS
    assert min(found.values()) > LEAST_WEIGHT / 2
    assert list(found) == ["coulomb-friction", "name-0", "name-1", "name-2"]


def test_what_is_left_speaks_for_physics_outside_the_catalogue():
    found = [weight_outside(replace(ALONE, left=left), CONSTANTS) for left in (0.0, 0.01, 0.3)]
    assert found == sorted(found)
    assert found[0] == pytest.approx(1e-4**0.5 / (1.0 + 1e-4**0.5))


def test_a_weak_effect_beside_a_strong_one_may_stand_for_its_law():
    alone, beside = (weight_outside(replace(ALONE, share=0.5, strongest=s), CONSTANTS) for s in (True, False))
    weak = weight_outside(replace(ALONE, share=0.01, strongest=False), CONSTANTS)
    assert alone < beside < weak


def test_what_is_linear_and_outside_the_catalogue_is_imitated_with_every_input():
    law, linear = (replace(ALONE, linear=linear) for linear in (False, True))
    assert weight_outside(linear, CONSTANTS) > weight_outside(law, CONSTANTS)
    twice = [weight_outside(replace(each, experiments=2), CONSTANTS) for each in (law, linear)]
    assert twice[0] < weight_outside(law, CONSTANTS)
    assert twice[1] == weight_outside(linear, CONSTANTS)


def test_an_effect_on_the_noise_may_be_the_shadow_of_another():
    alone, beside = (weight_outside(replace(ALONE, noise=True, strongest=s), CONSTANTS) for s in (True, False))
    assert alone == pytest.approx(1.0 / (1.0 + 2.718281828**2))
    assert beside == pytest.approx(1.0 / (1.0 + 2.718281828**0.5))


def test_a_rig_may_have_what_makes_two_laws_of_the_same_special_case_general():
    """LuGre friction is hysteresis while it sticks and Stribeck friction while it slides."""
    special = Member("dead-zone", 500.0, 0.9, special=True)
    near, far = (Member("stribeck-friction", 480.0, left, sibling=True) for left in (-0.01, 0.4))
    found = of(special, near)
    assert found["stribeck-friction"] == pytest.approx(3.0 / 7.0 * found["dead-zone"])
    assert "stribeck-friction" not in of(special, far)


def test_what_imitates_a_law_has_to_do_it_in_every_experiment():
    member = Member("near", 100.0, 0.01)
    once, twice = of(member), of(member, experiments=2)
    assert twice["near"] / twice["coulomb-friction"] == pytest.approx(0.3 * once["near"] / once["coulomb-friction"])


def test_another_experiment_that_leaves_nothing_speaks_against_physics_outside_the_catalogue():
    once, twice = (weight_outside(replace(ALONE, experiments=count), CONSTANTS) for count in (1, 2))
    assert twice / (1.0 - twice) == pytest.approx((once / (1.0 - once)) ** 2)
    # One that leaves much speaks for it.
    left = replace(ALONE, left=0.9)
    structured = Constants(**{**vars(CONSTANTS), "outside": 1.0})
    once, twice = (weight_outside(replace(left, experiments=count), structured) for count in (1, 2))
    assert twice > once > 0.5


def test_a_hold_has_no_number_that_could_imitate_other_linear_dynamics():
    imitates = {n: e(**values).imitates_linear_dynamics for n, e, values in IMITATORS}
    assert imitates == {"input-hold": False, "actuator-lag": True, "coulomb-friction": False}


def test_an_effect_with_a_transfer_function_is_linear_dynamics():
    hooks = ("before_plant", "beside_plant", "after_plant")
    own = {n for n, e in known_effects().items() if any(getattr(e, h) is not getattr(Effect, h) for h in hooks)}
    linear = {n for n, e in known_effects().items() if e.linear_dynamics}
    assert len(own) == 3
    assert own < linear


def test_a_repetition_is_no_other_experiment():
    def problem(*signals):
        experiments = [SimpleNamespace(signal=np.asarray(s, float)) for s in signals]
        return SimpleNamespace(experiments=experiments, fitted_runs=range(len(signals)))

    one = np.sin(np.arange(200.0))
    assert different_inputs(problem(one)) == 1
    assert different_inputs(problem(one, one + 1e-3)) == 1
    assert different_inputs(problem(one, one[:150])) == 1
    assert different_inputs(problem(one, 0.5 * one)) == 2
    assert different_inputs(problem(one, np.cos(np.arange(200.0)), one)) == 2


def test_a_law_that_is_shown_finely_leaves_less_room_for_another():
    """What no test sees of a weak effect may be much of it: of a strong one it is little."""
    weights_outside = [weight_outside(replace(ALONE, gain=gain), CONSTANTS) for gain in (40.0, 400.0, 4e4)]
    assert weights_outside == sorted(weights_outside, reverse=True)
    assert weight_outside(replace(ALONE, gain=20.0), CONSTANTS) == pytest.approx(weights_outside[0])


def test_what_is_left_adds_to_what_no_test_sees():
    seen = replace(ALONE, gain=400.0, left=0.09)
    assert seen.unexplained(40.0) == pytest.approx(0.2)
    assert weight_outside(seen, CONSTANTS) == pytest.approx(weight_outside(replace(ALONE, gain=200.0), CONSTANTS))


def test_a_weaker_effect_stands_for_the_law_of_a_stronger_one_in_every_experiment():
    strong, weak = (
        [weight_outside(replace(ALONE, strongest=s, experiments=n), CONSTANTS) for n in (1, 2)] for s in (True, False)
    )
    assert strong[1] < strong[0]
    assert weak[1] == weak[0]
