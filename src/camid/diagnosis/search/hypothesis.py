"""An effect as a hypothesis beside its rivals."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass

import numpy as np

from camid.diagnosis.search.screening import trials
from camid.diagnosis.weights import GENERAL_ODDS, Member
from camid.effects.base import Effect
from camid.effects.special_cases import is_constant, special_case, sums_with
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

    @property
    def effect(self) -> Effect | None:
        """The effect itself, fitted; None of a hypothesis that names none of its model."""
        return next((e for e in self.fitted.model.effects if e.identifier == self.identifier), None)

    def beyond(self, other: Hypothesis) -> float:
        """By how much its criterion exceeds that of another hypothesis."""
        return self.fitted.criterion_beyond(other.fitted) + self.penalty - other.penalty


def prior_penalty(problem: Problem, effect: Effect) -> float:
    """Twice the logarithm of how many different effects a search for one amounts to, and of the prior odds against it.

    Rigs have dry friction more often than they have one of the laws of which it is the special case; what makes a law
    of these more general still has the same odds again.
    """
    penalty = 2.0 * float(np.log(trials(type(effect), problem) / effect.prior_odds))
    special = effect.simplified()
    while special is not None:
        penalty += general_law_penalty()
        special = special.simplified()
    return penalty


def general_law_penalty() -> float:
    """Twice the logarithm of the prior odds against a law of which dry friction is the special case."""
    return -2.0 * float(np.log(GENERAL_ODDS))


def in_order(hypotheses: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The likeliest first."""
    if not hypotheses:
        return []
    closest = min(hypotheses, key=lambda h: h.fitted.cost)
    return sorted(hypotheses, key=lambda h: h.beyond(closest))


def members_of(
    ranked: Sequence[Hypothesis],
    without: Fitted,
    named: Set[str] = frozenset(),
    *,
    constant: bool = False,
    same: Sequence[str] = (),
) -> tuple[Member, ...]:
    """The names of a class, for :func:`camid.diagnosis.weights.weights`.

    Parameters
    ----------
    ranked : sequence of Hypothesis
        In the place of one effect, the likeliest first.
    without : Fitted
        The model without that effect.
    named : set of str, optional
        All effects of the model, this one among them: some together may have another name.
    constant : bool
        Whether the model holds a constant at input or sensor that is estimated, which stands for the other.
    same : sequence of str
        Laws of which the likeliest is the special case, and which are exactly that in these recordings.
    """
    lead = ranked[0]
    mismatch = max(without.cost - lead.fitted.cost, 1e-300)
    # A law with detail of its own is not held to be a plainer one of another name.
    special = _plainer_name(lead)
    simplest = next((h.fitted.cost for h in ranked if h.identifier == special), None)
    # Other laws of the same special case: the one among them that leaves least is the likeliest of them.
    siblings = [h.fitted.cost for h in ranked[1:] if special is not None and special_case_of(h) == special]
    least = None if simplest is None else min([simplest, *siblings])

    def member(hypothesis: Hypothesis) -> Member:
        of = special_case_of(hypothesis)
        sibling = hypothesis is not lead and least is not None and of == special
        return Member(
            hypothesis.identifier,
            float(hypothesis.beyond(lead)),
            (hypothesis.fitted.cost - (least if sibling and least is not None else lead.fitted.cost)) / mismatch,
            # There is one law of a constant only.
            hypothesis.identifier == special and not _is_finer(hypothesis, lead) and not is_constant(special),
            of == lead.identifier,
            sibling,
            len(hypothesis.fitted.penalised_names) - len(lead.fitted.penalised_names),
        )

    # One effect that is exactly two which are found is as likely as these two: nothing tells them apart.
    found_apart = any(is_constant(name) for name in named)
    constant = constant or found_apart

    laws = sums_with(lead.identifier, named, lead.fitted.model.effects, constant=constant)
    sums = [law.identifier for law in laws]
    odds = 1.0 if found_apart else GENERAL_ODDS
    ranked = [h for h in ranked if h.identifier not in sums]
    others = [Member(identifier, 0.0, 0.0, odds=odds) for identifier in sums]
    others += [Member(identifier, 0.0, 0.0, odds=GENERAL_ODDS) for identifier in same]
    return (*(member(h) for h in ranked), *others)


def special_case_of(hypothesis: Hypothesis) -> str | None:
    """Name of the special case of a hypothesis's effect."""
    effect = hypothesis.effect
    special = None if effect is None else special_case(effect)
    return None if special is None else special.identifier


def _plainer_name(hypothesis: Hypothesis) -> str | None:
    """Name of the next plainer law than a hypothesis's, where that is another one."""
    effect = hypothesis.effect
    plainer = None if effect is None else effect.simplified()
    return None if plainer is None or plainer.identifier == hypothesis.identifier else plainer.identifier


def _is_finer(hypothesis: Hypothesis, lead: Hypothesis) -> bool:
    """Whether a hypothesis is a finer law than the special case of the likeliest, and no special case itself."""
    effect, general = hypothesis.effect, lead.effect
    special = None if general is None else special_case(general)
    return special is not None and type(effect) in type(special).finer_laws
