"""Rows that were not fitted judge the effects found."""

from types import SimpleNamespace

import numpy as np
import pytest

from camid.diagnosis.pruning.held_out import REFUTED, _fails, borne_out, held_out_evidence
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.search.hypothesis import Hypothesis
from camid.diagnosis.watch import Watch
from camid.fitting.fit import fit
from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.identification.from_recordings import experiments_of
from camid.simulation.file import load_simulation
from tests.support.mass_on_spring import COUNT, effect, record, simulation

FRICTION = effect("coulomb-friction", force=0.1)


def decided(*effects):
    """A decision for dry friction from a recording of a rig that has it; a second one, with these effects, judges."""
    believed = load_simulation(simulation(sensor={"column": "y", "kind": "camera", "offset": 0.0}))
    tables = [record(FRICTION), record(*effects, seed=2)]
    recordings, experiments, _ = experiments_of(tables, believed, None)
    whole = problem_of(believed, structure_of(believed), recordings, experiments)
    fitted, judging = [np.ones(COUNT, bool), np.zeros(COUNT, bool)], [np.zeros(COUNT, bool), np.ones(COUNT, bool)]
    problem = whole.with_used(fitted)
    base = problem.kind.refit(problem, problem.with_initial_states(model_of(problem, [])))
    found = fit(problem, base.model.plus(FRICTION))
    hypothesis = Hypothesis(FRICTION.identifier, found)
    return problem, Decision(base, found, [[hypothesis]], [base]), judging


@pytest.mark.parametrize("there", [True, False])
def test_an_effect_stays_only_if_other_rows_do_not_speak_against_it(there):
    problem, decision, judging = decided(*[FRICTION] * there)
    evidence = held_out_evidence(problem, decision.fitted, decision.without[0], judging)
    assert evidence > 50.0 if there else evidence < -REFUTED
    kept = borne_out(problem, decision, judging, 0, Watch())
    assert (kept is decision) == there
    assert bool(kept.rivals) == there
    assert kept.fitted is (decision.fitted if there else decision.base)


@pytest.mark.parametrize(("identifier", "fails"), [("coulomb-friction", False), ("sensor-drift", True)])
def test_what_goes_on_with_time_has_to_go_on(identifier, fails):
    """Twice the squared errors on other rows: of friction the law may be inexact, and of a drift nothing is left."""
    found = effect(identifier, **({"rate": 0.1} if identifier == "sensor-drift" else {"force": 0.1}))
    fitted, without = (
        SimpleNamespace(model=SimpleNamespace(effects=effects, error=error))
        for effects, error in (((found,), np.sqrt(2.0)), ((), 1.0))
    )
    problem = SimpleNamespace(errors=lambda model, judging: np.full(10, model.error))
    decision = Decision(without, fitted, [[Hypothesis(identifier, fitted)]], [without])
    assert _fails(problem, decision, 0, 0, []) == fails
