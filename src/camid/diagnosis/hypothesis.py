"""An effect as a hypothesis beside its rivals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from camid.diagnosis.screening import trials
from camid.diagnosis.weights import GENERAL_LAW, Member
from camid.effects.base import Effect
from camid.fitting.fit import Fitted
from camid.fitting.problem import Problem


@dataclass(frozen=True)
class Hypothesis:
    """An effect beside a base model, fitted.

    Attributes
    ----------
    identifier : str
    fitted : Fitted
        Its model holds the effect.
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
    odds = (1.0 - GENERAL_LAW) / GENERAL_LAW if general else 1.0
    return 2.0 * float(np.log(trials(type(effect), problem) * odds))


def in_order(hypotheses: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The likeliest first."""
    if not hypotheses:
        return []
    closest = min(hypotheses, key=lambda h: h.fitted.cost)
    return sorted(hypotheses, key=lambda h: h.beyond(closest))


def members_of(ranked: Sequence[Hypothesis], without: Fitted) -> tuple[Member, ...]:
    """The names of a class, for :func:`camid.diagnosis.weights.weights`.

    Parameters
    ----------
    ranked : sequence of Hypothesis
        In the place of one effect, the likeliest first.
    without : Fitted
        The model without that effect.
    """
    lead = ranked[0]
    mismatch = max(without.cost - lead.fitted.cost, 1e-300)
    special = _special_case(lead)
    return tuple(
        Member(
            hypothesis.identifier,
            float(hypothesis.beyond(lead)),
            (hypothesis.fitted.cost - lead.fitted.cost) / mismatch,
            hypothesis.identifier == special,
            _special_case(hypothesis) == lead.identifier,
        )
        for hypothesis in ranked
    )


def _special_case(hypothesis: Hypothesis) -> str | None:
    """Name of the special case of a hypothesis's effect."""
    effect = next((e for e in hypothesis.fitted.model.effects if e.identifier == hypothesis.identifier), None)
    special = None if effect is None else effect.simplified()
    return None if special is None else special.identifier
