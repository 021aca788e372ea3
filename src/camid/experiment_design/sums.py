"""Laws that are exactly two others together: whatever is played, nothing tells them from these.

Friction of another size in each direction is Coulomb friction beside a constant force. Where a constant is estimated
anyway, of the sensor or of the input, a diagnosis lists both names, and no experiment takes one of them away.
"""

from __future__ import annotations

from collections.abc import Sequence

from camid.diagnosis.report.summary import title_of
from camid.diagnosis.search.hypothesis import general_law_penalty
from camid.effects.base import Effect
from camid.effects.special_cases import sums_with
from camid.experiment_design.general_laws import GeneralLaw
from camid.experiment_design.hypothesis import Hypothesis


def laws_that_are_sums(hypotheses: Sequence[Hypothesis]) -> list[GeneralLaw]:
    """Those of all names, with the prior odds that a diagnosis gives them."""
    return [
        GeneralLaw(law.identifier, hypothesis.identifier, 0, 0.0 if _found_apart(hypothesis) else general_law_penalty())
        for hypothesis in hypotheses
        if hypothesis.is_name and hypothesis.effect is not None
        for law in sums_beside(hypothesis)
    ]


def sums_beside(hypothesis: Hypothesis) -> list[type[Effect]]:
    """Laws that are the effect in question together with what stands beside it."""
    effects = hypothesis.model.effects
    constant = hypothesis.problem.kind.constant_beside(hypothesis.problem) or _found_apart(hypothesis)
    return sums_with(hypothesis.identifier, {e.identifier for e in effects}, effects, constant=constant)


def without_sums(hypotheses: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The hypotheses but for laws that are another one of them beside a constant; the likelier stands for both."""
    sums = {(h.question, law.identifier) for h in hypotheses if h.is_name for law in sums_beside(h)}
    return [h for h in hypotheses if (h.question, h.identifier) not in sums]


def warnings_of(hypotheses: Sequence[Hypothesis]) -> list[str]:
    """Sentences that say which names stay possible whatever is played."""
    return [
        f"if it is {title_of(law.special)}, {title_of(law.identifier)} stays possible whatever is played: it is that "
        f"and a constant, and one is estimated; declare the sensor's offset and the input's bias if they are known"
        for law in laws_that_are_sums(hypotheses)
    ]


def _found_apart(hypothesis: Hypothesis) -> bool:
    """Whether a constant is one of the effects that were found."""
    return any(e.is_constant for e in hypothesis.model.effects)
