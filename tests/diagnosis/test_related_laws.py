"""Laws with more detail: where the search for them ends."""

from types import SimpleNamespace

import numpy as np

from camid.diagnosis.search import related_laws
from camid.fitting.fit import evaluate
from camid.fitting.from_simulation import model_of
from tests.diagnosis.test_noise_of_uneven_rows import fitted_to
from tests.support.mass_on_spring import effect, record

ROWS = 500


class _Hypothesis:
    identifier = "step-disturbance"

    def __init__(self, cost):
        model = SimpleNamespace(effects=(effect("step-disturbance", size=1.0, time=2.0),))
        self.fitted = SimpleNamespace(cost=cost, residual=np.zeros(ROWS), model=model)


def test_a_law_that_gains_ever_less_is_no_law_with_more_detail(monkeypatch):
    """A step that is begun at another time again and again creeps along a curve for ever."""
    fitted = []

    def creeping(problem, starts):
        gains = 0.02 * 0.5 ** np.arange(200)
        fitted.append(_Hypothesis(100.0 * float(np.prod(1.0 - gains[: len(fitted) + 1]))))
        return [fitted[-1]]

    start = SimpleNamespace(effects=(SimpleNamespace(identifier="step-disturbance"),))
    monkeypatch.setattr(related_laws, "_finer_starts", lambda *_: [start])
    monkeypatch.setattr(related_laws, "worth_a_fit", lambda problem, base, starts: starts)
    monkeypatch.setattr(related_laws, "special_case_of", lambda _: "")
    monkeypatch.setattr(related_laws, "_until_white", creeping)
    problem = SimpleNamespace(kind=SimpleNamespace(phases_add_up=False))
    found = related_laws.finer_laws(problem, [_Hypothesis(100.0)])
    # A fall by two in 500 noise variances is less than four parts in a thousand.
    assert len(found) == 4


def test_a_part_of_a_recording_that_rests_on_one_step_of_its_lattice_keeps_the_coefficients():
    """Where nothing moves nothing is re-estimated, and a search goes on with what is given."""
    table = record(effect("quantisation", step=0.4), noise=0.0)
    problem, _ = fitted_to(table)
    rests = int(np.argmax(np.abs(table["y"].to_numpy()) > 0.0))
    assert rests > 3
    part = problem.start_of(rests)
    given = part.with_initial_states(model_of(part, []))
    found = part.kind.refit(part, given)
    assert np.isfinite(found.cost)
    assert found.cost <= evaluate(part, given).cost
