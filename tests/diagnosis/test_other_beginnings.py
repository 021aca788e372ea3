"""When a search is begun again with another first effect."""

from types import SimpleNamespace

import numpy as np
import pytest

from camid.diagnosis.search import other_beginnings
from camid.diagnosis.search.decision import Decision, Searches
from camid.diagnosis.search.hypothesis import Hypothesis
from camid.diagnosis.search.other_beginnings import with_other_beginnings
from camid.diagnosis.watch import Watch


@pytest.mark.parametrize(
    ("left", "noise", "interrupted", "asked"),
    [(0.03, 0.0, True, False), (0.2, 0.0, True, True), (0.2, 0.19, True, False), (0.03, 0.0, False, True)],
)
def test_what_leaves_more_than_an_inexact_law_is_no_inexact_law(left, noise, interrupted, asked):
    """A search that ended where a law seemed to be inexact is begun otherwise if a fifth of the mismatch is left."""
    problem = SimpleNamespace(
        kind=SimpleNamespace(phases_add_up=False),
        recorded=np.ones(3),
        whitened=lambda residual, whitening: np.sqrt([noise]),
    )
    base, fitted = (
        SimpleNamespace(
            cost=cost,
            model=SimpleNamespace(effects=()),
            problem=problem,
            residual=np.sqrt([cost]),
            noise=SimpleNamespace(whitening=np.ones(1)),
        )
        for cost in (1.0, left)
    )
    decision = Decision(base, fitted, rivals=[[]], interrupted=interrupted)
    seen = []

    def leaves_structure(found):
        seen.append(found)
        return False

    assert with_other_beginnings(problem, decision, Searches(), Watch(), leaves_structure) is decision
    assert bool(seen) == asked


def test_a_search_begins_with_that_beside_which_a_second_effect_would_leave_least(monkeypatch):
    """The one that explains most alone may hide another, and the one that explains least may have it beside it."""
    costs = {"backlash": 0.2, "saturation": 0.5, "coulomb-friction": 0.6, "delay": 0.65}
    gains = {"backlash": 20.0, "saturation": 900.0, "coulomb-friction": 5000.0, "delay": 0.0}
    others = [Hypothesis(name, SimpleNamespace(cost=cost, residual=np.ones(100))) for name, cost in costs.items()]
    names = {id(h.fitted): h.identifier for h in others}
    monkeypatch.setattr(
        other_beginnings, "screen", lambda problem, fitted: [SimpleNamespace(gain=gains[names[id(fitted)]])]
    )
    begins = other_beginnings._promising(None, others, Watch())
    assert [hypothesis.identifier for hypothesis, _ in begins] == ["coulomb-friction", "saturation"]
    spent = Watch(effort=1.0)
    spent.count(SimpleNamespace(seconds=1e9), 1000)
    assert [h.identifier for h, _ in other_beginnings._promising(None, others, spent)] == ["saturation", "backlash"]
