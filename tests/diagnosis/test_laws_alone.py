"""A law without a name in the place of a name that leaves structure."""

import pytest

import camid
from camid.proof.unlisted.campaign import error_of
from camid.proof.unlisted.rigs import draw, generator, law_of

# Stops on both sides: a name resembles them, leaves structure, and hides them from a curve beside it.
SEED, NUMBER = 7701, 25


@pytest.mark.slow
def test_a_name_that_hides_a_law_is_not_simulated():
    rng = generator(SEED, NUMBER, True)
    case = draw(rng, law_of(NUMBER))
    simulation = case.simulation(rng)
    diagnosis = camid.diagnose(case.first, simulation, time_limit=None)
    assert [(f.identifier, f.simulated) for f in diagnosis.findings] == [("cubic-stiffness", False)]
    (part,) = diagnosis.learned
    assert part.formula.expression == "f(y) = a·dead_zone(y, c)"
    assert "in the place of cubic stiffness" in diagnosis.explanation
    assert [e.identifier for e in diagnosis.improved.effects] == ["learned-force"]
    refitted = camid.identify(case.first, simulation, method="output-error").simulation
    errors = [error_of(camid.simulate(case.second, each), case.clean) for each in (diagnosis.improved, refitted)]
    assert errors[0] < 0.05 * errors[1]
