"""Laws under the name that has the fewest numbers, and at the least of their minima."""

import numpy as np

from camid.diagnosis.pruning.settled_effects import with_settled_laws
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.search.hypothesis import Hypothesis
from camid.diagnosis.search.settled_laws import under_their_names
from camid.effects.drift import ParameterDrift
from camid.effects.friction import StribeckFriction
from camid.fitting.fit import fit
from tests.diagnosis.test_noise_of_uneven_rows import fitted_to
from tests.support.mass_on_spring import effect, record


def found_as_stribeck_friction():
    """A rig with Coulomb friction, and friction that falls at speeds which the motion hardly has."""
    problem, base = fitted_to(record(effect("coulomb-friction", force=0.15), noise=0.005))
    falls = StribeckFriction(coulomb=0.14, breakaway=0.25, velocity=0.01 * float(np.std(base.residual)) + 0.02)
    return problem, base, fit(problem, base.model.plus(falls), steps=40)


def test_friction_that_hardly_falls_is_coulomb_friction():
    problem, _, stribeck = found_as_stribeck_friction()
    found = under_their_names(problem, stribeck, 0)
    (friction,) = found.model.effects
    assert friction.identifier == "coulomb-friction"
    assert abs(friction.values["force"] - 0.15) < 0.01
    assert found.cost < 1.02 * stribeck.cost


def test_what_it_was_found_as_is_a_rival_of_the_name_with_fewer_numbers():
    problem, base, stribeck = found_as_stribeck_friction()
    drift = fit(problem, base.model.plus(ParameterDrift(coefficient="damping", rate=0.01)))
    ranked = [Hypothesis("stribeck-friction", stribeck), Hypothesis("parameter-drift", drift)]
    found = with_settled_laws(problem, Decision(base, stribeck, [ranked]), 0, detailed=False)
    assert [h.identifier for h in found.rivals[0]] == ["coulomb-friction", "stribeck-friction", "parameter-drift"]
    assert found.fitted.model.effects[0].identifier == "coulomb-friction"


def test_friction_that_falls_keeps_its_name():
    falls = StribeckFriction(coulomb=0.1, breakaway=0.25, velocity=0.5)
    problem, base = fitted_to(record(falls, noise=0.001))
    found = fit(problem, base.model.plus(falls), steps=40)
    assert under_their_names(problem, found, 0) is found
