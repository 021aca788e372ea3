"""When a search is begun again with another first effect."""

from types import SimpleNamespace

import numpy as np
import pytest

from camid.diagnosis.search.decision import Decision, Searches
from camid.diagnosis.search.other_beginnings import with_other_beginnings
from camid.diagnosis.watch import Watch


@pytest.mark.parametrize(
    ("left", "interrupted", "asked"), [(0.03, True, False), (0.2, True, True), (0.03, False, True)]
)
def test_what_leaves_more_than_an_inexact_law_is_no_inexact_law(left, interrupted, asked):
    """A search that ended where a law seemed to be inexact is begun otherwise if a fifth of the mismatch is left."""
    base, fitted = (SimpleNamespace(cost=cost, model=SimpleNamespace(effects=())) for cost in (1.0, left))
    decision = Decision(base, fitted, rivals=[[]], interrupted=interrupted)
    problem = SimpleNamespace(kind=SimpleNamespace(phases_add_up=False), recorded=np.ones(3))
    seen = []

    def leaves_structure(found):
        seen.append(found)
        return False

    assert with_other_beginnings(problem, decision, Searches(), Watch(), leaves_structure) is decision
    assert bool(seen) == asked
