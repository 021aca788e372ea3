"""Probabilities with which chance does what an effect is found for, anywhere in a search through the catalogue."""

from __future__ import annotations

import numpy as np

from camid.diagnosis.search.screening import trials
from camid.effects import known_effects
from camid.fitting.fit import Fitted
from camid.fitting.problem import Problem

# Probability of naming an effect where nothing is missing, for the whole catalogue together.
FALSE_ALARM = 0.002
# The same for an effect beside others, whose law may not be exact.
FALSE_ALARM_BESIDE_OTHERS = 1e-4
# Bayes's criterion, prior odds included, over the model without an effect from which its evidence is strong (Kass &
# Raftery 1995, Journal of the American Statistical Association 90, 773-795): a resonance that may lie anywhere fits
# chance better than the number of its parameters says.
STRONG_EVIDENCE = 6.0


def p_value(problem: Problem, before: Fitted, after: Fitted, identifier: str) -> float:
    """Bound on the probability that an effect improves the likelihood as much where it is not."""
    added = len(after.penalised_names) - len(before.penalised_names)
    ratio = before.criterion_beyond(after) + added * float(np.log(len(after.residual)))
    return chance(problem, identifier, ratio, added)


def chance(problem: Problem, identifier: str, ratio: float, added: int = 0) -> float:
    """Bound on the probability of twice a logarithm of a likelihood ratio anywhere in a search without the effect.

    It has the freedom of the effect's parameters, or that of all numbers that were ``added``, the states of a mode
    among them.
    """
    from scipy.special import chdtrc

    freedom = max(len(known_effects()[identifier].numeric()), added, 1)
    return min(float(chdtrc(freedom, max(ratio, 0.0))) * searched(problem, identifier), 1.0)


def searched(problem: Problem, identifier: str) -> float:
    """How many hypotheses a search through the catalogue amounts to, from the view of one effect."""
    count = sum(not e.noise_like for e in known_effects().values())
    return trials(known_effects()[identifier], problem) * count
