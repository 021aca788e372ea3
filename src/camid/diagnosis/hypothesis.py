"""An effect as a hypothesis: its weight beside its rivals, and whether rows that were not fitted refute it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.screening import trials
from camid.effects.base import Effect
from camid.fitting.fit import Fitted
from camid.fitting.problem import Problem

Array = NDArray[np.float64]

# Prior probability that a law is another one of the same name, and the share of the mismatch that it then leaves.
OTHER_LAW = 0.3
LAW_ERROR = 0.04
# The same where the hypothesis is a special case of the likeliest law.
SPECIAL_CASE_ERROR = 0.3
# Standard errors by which errors on validation rows may grow before an effect is refused.
WORSE_STANDARD_ERRORS = 2.0
# Factor by which they may grow even if few rows make most of it, and the least share of the gain on fitted rows that
# has to show there, if the difference is beyond this many standard errors.
LARGEST_ERROR_RATIO = 1.5
LEAST_GAIN_SHARE = 0.15
MISSING_STANDARD_ERRORS = 4.0
NOISE_LEVEL_RATIO = 1.5
# Weight from which an alternative is worth naming, and how many effects a class may hold.
LEAST_WEIGHT = 0.01
LARGEST_CLASS = 4


@dataclass(frozen=True)
class Hypothesis:
    """An effect beside a base model, fitted.

    Attributes
    ----------
    identifier : str
    fitted : Fitted
        Its effect is the last of the model.
    penalty : float
        See :func:`prior_penalty`.
    """

    identifier: str
    fitted: Fitted
    penalty: float = 0.0

    def beyond(self, other: Hypothesis) -> float:
        """By how much its criterion exceeds that of another hypothesis."""
        return self.fitted.criterion_beyond(other.fitted) + self.penalty - other.penalty


def prior_penalty(problem: Problem, effect: Effect) -> float:
    """Twice the logarithm of how many different effects a search for one amounts to, and of a general law's prior odds.

    Rigs have dry friction more often than they have one of the laws of which it is the special case.
    """
    general = effect.simplified() is not None
    odds = (1.0 - OTHER_LAW) / OTHER_LAW if general else 1.0
    return 2.0 * float(np.log(trials(type(effect), problem) * odds))


def in_order(hypotheses: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The likeliest first."""
    if not hypotheses:
        return []
    closest = min(hypotheses, key=lambda h: h.fitted.cost)
    return sorted(hypotheses, key=lambda h: h.beyond(closest))


def weights(ranked: Sequence[Hypothesis], without: Fitted) -> list[tuple[str, float]]:
    """Posterior weights of a class, the likeliest first: at most four effects that the data do not rule out.

    Bayes's criterion takes every law as exact, and no rig's friction is. A name covers laws like the catalogue's,
    so a hypothesis that leaves a small share of the mismatch is not ruled out by many samples: with the prior
    probability ``OTHER_LAW`` the law is another one of the same name, which leaves a share of the order of
    ``LAW_ERROR``.

    Parameters
    ----------
    ranked : sequence of Hypothesis
        In the place of one effect.
    without : Fitted
        The model without that effect.
    """
    if not ranked:
        return []
    lead = ranked[0]
    mismatch = max(without.cost - lead.fitted.cost, 1e-300)
    raw = []
    general = [h for h in ranked if _generalises(h, lead)]
    special_case = lead.fitted.model.effects[-1].simplified() if lead.fitted.model.effects else None
    for hypothesis in ranked:
        # Dahl's friction is friction, and fits Bouc and Wen's hysteresis best.
        is_special_case = special_case is not None and hypothesis.identifier == special_case.identifier
        error = SPECIAL_CASE_ERROR if is_special_case else LAW_ERROR
        prior, best = 1.0, lead
        if _generalises(hypothesis, lead):  # it ranks after its special case because it says no more
            prior, best = OTHER_LAW, in_order(general)[0]
        left = max(hypothesis.fitted.cost - best.fitted.cost, 0.0) / mismatch
        exact = float(np.exp(-0.5 * max(hypothesis.beyond(best), 0.0)))
        weight = (1.0 - OTHER_LAW) * exact + OTHER_LAW * float(np.exp(-left / error))
        raw.append((hypothesis.identifier, prior * weight))
    total = sum(w for _, w in raw)
    raw.sort(key=lambda item: -item[1])
    kept = [(name, w / total) for name, w in raw if w / total >= LEAST_WEIGHT][:LARGEST_CLASS]
    total = sum(w for _, w in kept)
    return [(name, w / total) for name, w in kept]


def _generalises(hypothesis: Hypothesis, lead: Hypothesis) -> bool:
    """Whether a hypothesis that fits better has the lead for its special case."""
    if hypothesis is lead or hypothesis.beyond(lead) >= 0.0 or not hypothesis.fitted.model.effects:
        return False
    special = [e.simplified() for e in hypothesis.fitted.model.effects if e.identifier == hypothesis.identifier]
    return any(s is not None and s.identifier == lead.identifier for s in special)


def refuted(expected: float, noise: float, before: Sequence[Array], after: Sequence[Array], one_off: bool) -> bool:
    """Whether errors on rows that were not fitted contradict an effect.

    Parameters
    ----------
    expected : float
        Fall of the mean square error on the fitted rows.
    noise : float
        Mean square error that is left there.
    before, after : sequence of ndarray
        Errors without and with the effect.
    one_off : bool
        Whether the effect may leave those rows alone.
    """
    first, second = (np.concatenate(e) ** 2 for e in (before, after))
    if len(first) < 2:
        return False
    gain = first - second
    mean, spread = float(np.mean(gain)), float(np.std(gain)) / float(np.sqrt(len(gain)))
    if float(np.mean(second)) > LARGEST_ERROR_RATIO * float(np.mean(first)):
        return True
    if mean < -WORSE_STANDARD_ERRORS * spread and mean < -0.5 * expected:
        return True
    # Where the errors are at the noise already there is nothing to gain.
    idle = one_off or float(np.mean(first)) < NOISE_LEVEL_RATIO * noise
    return not idle and mean < LEAST_GAIN_SHARE * expected and expected - mean > MISSING_STANDARD_ERRORS * spread
