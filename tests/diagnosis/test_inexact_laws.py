"""Where a law is not exact, no other names are looked for in what it leaves; where it is, they are."""

import pytest

import camid
from camid.diagnosis.search import forward_selection
from tests.diagnosis.test_learned_laws import believed, bump, rig
from tests.support import pendulum_and_drive as rigs
from tests.support.mass_on_spring import effect, record, simulation


@pytest.fixture
def answers(monkeypatch):
    """For each look at what effects leave, their names and whether their laws are taken for inexact."""
    found = []
    asked = forward_selection.laws_are_inexact

    def watched(problem, fitted, screened):
        found.append(([e.identifier for e in fitted.model.effects], asked(problem, fitted, screened)))
        return found[-1][1]

    monkeypatch.setattr(forward_selection, "laws_are_inexact", watched)
    return found


@pytest.fixture
def searches(monkeypatch):
    """Names beside which the catalogue is fitted."""
    found = []
    search = forward_selection.hypotheses

    def watched(problem, base, *arguments, **keywords):
        found.append([e.identifier for e in base.model.effects])
        return search(problem, base, *arguments, **keywords)

    monkeypatch.setattr(forward_selection, "hypotheses", watched)
    return found


@pytest.mark.slow
def test_what_an_inexact_law_leaves_is_learned_and_given_no_further_name(answers, searches):
    """A cubic spring with a magnet beside its way."""
    recording = rig(lambda y, v: 0.3 * y**3 + bump(y, v), 1).drop(columns="clean")
    diagnosis = camid.diagnose(recording, believed())
    assert [f.identifier for f in diagnosis.findings] == ["cubic-stiffness"]
    assert abs(diagnosis.findings[0].parameters["coefficient"].value - 0.3) < 0.01
    assert [part.variables for part in diagnosis.learned] == ["position"]
    assert answers[0] == (["cubic-stiffness"], True)
    assert [] in searches
    assert ["cubic-stiffness"] not in searches


@pytest.mark.slow
def test_names_are_looked_for_where_no_law_can_be_learned(answers, searches):
    """Dry friction that changes along the screw is no curve over anything."""
    recording = rigs.drive(mass=12.0, viscous=30.0, friction=6.0, ripple=0.25, noise=0.05)
    diagnosis = camid.diagnose(recording, rigs.drive_simulation(10.0, 50.0))
    assert [f.identifier for f in diagnosis.findings] == ["coulomb-friction"]
    assert not diagnosis.learned
    assert answers[0] == (["coulomb-friction"], True)
    assert searches[0] == []
    assert ["coulomb-friction"] in searches


@pytest.mark.slow
def test_a_second_effect_of_the_catalogue_is_looked_for(answers):
    recording = record(effect("coulomb-friction", force=0.15), effect("cubic-stiffness", coefficient=0.2))
    diagnosis = camid.diagnose(recording, simulation())
    assert {f.identifier for f in diagnosis.findings} == {"coulomb-friction", "cubic-stiffness"}
    assert not any(inexact for _, inexact in answers)
    assert max(len(names) for names, _ in answers) == 2
