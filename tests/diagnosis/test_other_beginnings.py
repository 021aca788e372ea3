"""When a search is begun again with another first effect."""

from types import SimpleNamespace

import numpy as np
import pytest

from camid.diagnosis.search.decision import Decision, Searches
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
