"""Places of the chain that are held against what a model leaves."""

import numpy as np

from camid.diagnosis.residual import mismatch_location
from camid.diagnosis.residual.mismatch_location import QUESTIONS, places
from camid.fitting.fit import evaluate
from camid.fitting.from_simulation import model_of, problem_of, structure_of
from camid.identification.from_recordings import experiments_of
from camid.simulation.file import load_simulation
from tests.support.mass_on_spring import effect, record, simulation


def test_of_what_is_beyond_all_numbers_nothing_is_asked(monkeypatch):
    """A model that runs away has motions whose squares are no numbers."""
    believed = load_simulation(simulation())
    recordings, experiments, _ = experiments_of([record(effect("coulomb-friction", force=0.1))], believed, None)
    problem = problem_of(believed, structure_of(believed), recordings, experiments)
    fitted = evaluate(problem, problem.with_initial_states(model_of(problem, [])))
    asked = places(problem, fitted)
    own = mismatch_location.regressors

    def running_away(*arguments):
        table = own(*arguments)
        return np.column_stack([table, np.full(len(table), 1e200)])

    monkeypatch.setattr(mismatch_location, "regressors", running_away)
    assert [test.p_value for test in places(problem, fitted)] == [test.p_value for test in asked]
    nothing = lambda *arguments: np.full((len(own(*arguments)), 2), 1e200)  # noqa: E731
    monkeypatch.setattr(mismatch_location, "regressors", nothing)
    assert [(test.place, test.p_value, test.share) for test in places(problem, fitted)] == [
        (place, 1.0, 0.0) for place in QUESTIONS
    ]
