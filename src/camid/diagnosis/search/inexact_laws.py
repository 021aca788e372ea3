"""Whether what effects leave says rather that their laws are not exact than that another effect is there.

What a law of the catalogue has inexactly is a smooth function of what it depends on, and so has a likelihood of its
own: that of a discrepancy without a name (Kennedy & O'Hagan 2001, J. R. Stat. Soc. B 63, 425–464). Where the evidence
for the likeliest such function clearly exceeds the likelihood that any effect of the catalogue may have, another name
would stand for a part of it, and so would the next.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camid.diagnosis.search.screening import ScreenedEffect
from camid.fitting.fit import Fitted
from camid.fitting.learned_law import judged_to_first_order
from camid.fitting.possible_laws import blank_laws
from camid.fitting.problem import Problem

# Natural logarithm of the evidence for a law against none from which it is learned: a thousand and more to one, beyond
# the choice among seven.
LEAST_EVIDENCE = 10.0
# How many times as much it has to be as what the likeliest effect may have: to first order, about a motion that is bent
# by what is missing, an effect may look weaker than it is when it is fitted.
MORE_THAN_A_NAME = 1.6


def laws_are_inexact(problem: Problem, fitted: Fitted, screened: Sequence[ScreenedEffect]) -> bool:
    """Whether a law without a name has clearly more evidence beside a model than any effect, both to first order.

    Parameters
    ----------
    problem : Problem
    fitted : Fitted
        With the effects that were found.
    screened : sequence of ScreenedEffect
        The catalogue beside it, the likeliest first. An effect counts with its likelihood, without a penalty for its
        parameters, in the metric of the noise that favours it.
    """
    count = len(fitted.residual)
    largest = 0.5 * count * float(np.log1p(screened[0].gain / count)) if screened else 0.0
    if largest < LEAST_EVIDENCE:  # the search would find nothing
        return False
    gains = judged_to_first_order(problem, fitted, blank_laws(problem, fitted))
    return max(gains.values(), default=0.0) > MORE_THAN_A_NAME * largest
