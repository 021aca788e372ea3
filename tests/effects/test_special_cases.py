"""Special cases of another name, in the detail of the law that they are cases of."""

from camid.effects import known_effects
from camid.effects.bristle_friction import CoulombBristleFriction, StribeckBristleFriction
from camid.effects.friction import AsymmetricFriction, CoulombFriction, StribeckFriction
from camid.effects.gradual_friction import GradualAsymmetricFriction, GradualCoulombFriction, GradualStribeckFriction
from camid.effects.special_cases import detail_of, in_the_same_detail, special_case

STRIBECK = {"coulomb": 0.4, "breakaway": 0.7, "velocity": 2.0}


def test_a_special_case_keeps_the_detail_that_it_has_a_law_for():
    gradual = special_case(GradualStribeckFriction(**STRIBECK, transition=0.1))
    assert type(gradual) is GradualCoulombFriction
    assert gradual.values == {"force": 0.7, "transition": 0.1}
    bristles = special_case(StribeckBristleFriction(**STRIBECK, presliding=0.01))
    assert type(bristles) is CoulombBristleFriction
    assert bristles.values["presliding"] == 0.01


def test_a_plain_law_has_a_plain_special_case():
    assert type(special_case(StribeckFriction(**STRIBECK))) is CoulombFriction
    assert special_case(CoulombFriction(force=1.0)) is None


def test_a_finer_law_of_the_same_name_is_no_other_name():
    assert special_case(GradualCoulombFriction(force=1.0, transition=0.1)) is None


def test_detail_is_what_the_plain_law_of_the_name_lacks():
    gradual = GradualCoulombFriction(force=1.0, transition=0.1)
    assert detail_of(gradual) == ["transition"]
    assert in_the_same_detail(AsymmetricFriction, gradual) is GradualAsymmetricFriction
    bristles = CoulombBristleFriction(force=1.0, presliding=0.1)
    assert in_the_same_detail(AsymmetricFriction, bristles) is AsymmetricFriction


def test_every_special_case_can_be_made():
    for kind in known_effects().values():
        for law in (kind, *kind.finer_laws):
            values = {p.name: p.choices[0] if p.choices else max(p.lower, min(1.0, p.upper)) for p in law.parameters}
            if not any(p.sequence or p.is_name for p in law.parameters):
                special = special_case(law(**values))
                assert special is None or special.identifier != kind.identifier
