"""Names that an effect may have."""

from types import SimpleNamespace

import pytest

from camid.diagnosis.search.hypothesis import Hypothesis, general_law_penalty, members_of, prior_penalty
from camid.diagnosis.weights import GENERAL_ODDS
from camid.effects import bristle_friction, known_effects
from camid.effects.gradual_friction import GradualCoulombFriction, GradualStribeckFriction


def hypothesis(effect, cost):
    """A hypothesis whose criterion is its cost."""
    model = SimpleNamespace(effects=(effect,))
    names = [p.name for p in effect.numeric()]
    fitted = SimpleNamespace(
        model=model, cost=cost, penalised_names=names, criterion_beyond=lambda other: cost - other.cost
    )
    return Hypothesis(effect.identifier, fitted)


COULOMB = known_effects()["coulomb-friction"](force=1.0)
STRIBECK = known_effects()["stribeck-friction"](coulomb=1.0, breakaway=2.0, velocity=3.0)
HYSTERESIS = known_effects()["hysteresis"](strength=1.0, shape=2.0)
LOAD = known_effects()["load-dependent-friction"](force=1.0, coefficient=0.1)
DRAG = known_effects()["quadratic-drag"](coefficient=1.0)
DAHL = bristle_friction.CoulombBristleFriction(force=1.0, presliding=0.5)
LUGRE = bristle_friction.StribeckBristleFriction(coulomb=1.0, breakaway=2.0, velocity=3.0, presliding=0.5)
GRADUAL = GradualCoulombFriction(force=1.0, transition=0.1)
WITHOUT = SimpleNamespace(cost=110.0)


def test_another_law_of_the_same_special_case_is_compared_with_that():
    laws = ((HYSTERESIS, 10.0), (STRIBECK, 50.0), (LOAD, 55.0), (COULOMB, 60.0), (DRAG, 70.0))
    lead, stribeck, load, coulomb, drag = members_of([hypothesis(e, c) for e, c in laws], WITHOUT)
    assert (lead.special, lead.general, lead.sibling) == (False, False, False)
    assert stribeck.sibling
    assert stribeck.left == 0.0
    assert load.sibling
    assert load.left == pytest.approx(0.05)
    assert coulomb.special
    assert not coulomb.sibling
    assert coulomb.left == pytest.approx(0.5)
    assert not drag.sibling
    assert drag.left == pytest.approx(0.6)
    assert [law.more for law in (stribeck, load, coulomb)] == [1, 0, -1]


def test_coulomb_friction_and_a_bias_may_be_asymmetric_friction():
    ranked = [hypothesis(COULOMB, 10.0)]
    assert [m.identifier for m in members_of(ranked, WITHOUT, {"coulomb-friction", "quadratic-drag"})] == [
        "coulomb-friction"
    ]
    _coulomb, asymmetric = members_of(ranked, WITHOUT, {"coulomb-friction", "input-bias"})
    assert asymmetric.identifier == "asymmetric-friction"
    # One effect in the place of two: the odds are even.
    assert (asymmetric.gap, asymmetric.left, asymmetric.odds) == (0.0, 0.0, 1.0)


def test_friction_that_holds_nothing_at_rest_is_no_sum_with_a_bias():
    ranked = [hypothesis(GRADUAL, 10.0)]
    members = members_of(ranked, WITHOUT, {"coulomb-friction"}, constant=True)
    assert [m.identifier for m in members] == ["coulomb-friction"]
    # Bristles hold it, in the catalogue's asymmetric law as well as with a bias.
    members = members_of([hypothesis(DAHL, 10.0)], WITHOUT, {"coulomb-friction"}, constant=True)
    assert [m.identifier for m in members] == ["coulomb-friction", "asymmetric-friction"]


def test_a_law_that_falls_is_more_general_than_gradual_friction():
    falling = GradualStribeckFriction(coulomb=0.9, breakaway=1.0, velocity=3.0, transition=0.1)
    _lead, general = members_of([hypothesis(GRADUAL, 10.0), hypothesis(falling, 12.0)], WITHOUT)
    assert general.general
    # Where it leads, with detail of its own, plainer friction is a rival as any.
    _lead, gradual = members_of([hypothesis(falling, 10.0), hypothesis(GRADUAL, 12.0)], WITHOUT)
    assert not gradual.special


def test_a_constant_that_is_estimated_stands_for_a_bias():
    ranked = [hypothesis(COULOMB, 10.0)]
    for named, constant in (({"coulomb-friction"}, True), ({"coulomb-friction", "sensor-offset"}, False)):
        found = [m.identifier for m in members_of(ranked, WITHOUT, named, constant=constant)]
        assert found == ["coulomb-friction", "asymmetric-friction"]
    (_, estimated) = members_of(ranked, WITHOUT, {"coulomb-friction"}, constant=True)
    assert (estimated.gap, estimated.odds) == (0.0, GENERAL_ODDS)
    assert len(members_of([hypothesis(DRAG, 10.0)], WITHOUT, {"quadratic-drag"}, constant=True)) == 1


def test_bristles_are_no_other_name():
    """Friction with bristles is friction: what has that for its special case is more general than it."""
    lead, hysteresis = members_of([hypothesis(DAHL, 10.0), hypothesis(HYSTERESIS, 12.0)], WITHOUT)
    assert (lead.identifier, lead.special, lead.general, lead.sibling) == ("coulomb-friction", False, False, False)
    assert (hysteresis.general, hysteresis.sibling) == (True, False)
    lead, dahl = members_of([hypothesis(LUGRE, 10.0), hypothesis(DAHL, 12.0)], WITHOUT)
    assert lead.identifier == "stribeck-friction"
    assert dahl.special
    lead, dahl = members_of([hypothesis(HYSTERESIS, 10.0), hypothesis(DAHL, 12.0)], WITHOUT)
    assert (dahl.special, dahl.left) == (False, pytest.approx(0.02))  # what it leaves is not for want of bristles


@pytest.mark.parametrize(
    ("effect", "depth"), [(COULOMB, 0), (STRIBECK, 1), (HYSTERESIS, 1), (DAHL, 1), (LUGRE, 2)], ids=str
)
def test_each_step_to_a_more_general_law_has_the_same_prior_odds(effect, depth):
    problem = SimpleNamespace(output=[0.0])
    assert prior_penalty(problem, effect) == pytest.approx(depth * general_law_penalty())
