"""Laws of the catalogue that hold a name as their special case: whatever is played, they fit as well as it does.

A diagnosis that leaves the name and not them has seen no reason to fit them yet. Of one that names it alone it does, so
that a weight which is predicted without them promises too much.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from camid.diagnosis.search.hypothesis import prior_penalty
from camid.effects import known_effects
from camid.effects.base import Effect
from camid.effects.special_cases import special_case
from camid.experiment_design.hypothesis import Hypothesis


@dataclass(frozen=True)
class GeneralLaw:
    """A law that is more general than a name.

    Attributes
    ----------
    identifier, special : str
        Its name, and that of its special case.
    more : int
        How many parameters it has in addition.
    penalty : float
        Twice the logarithm of the prior odds against it.
    """

    identifier: str
    special: str
    more: int
    penalty: float


def general_laws(hypotheses: Sequence[Hypothesis]) -> list[GeneralLaw]:
    """Those of all names that stand for effects."""
    found = []
    for hypothesis in hypotheses:
        special = hypothesis.effect
        if special is None or hypothesis.variant:
            continue
        problem = hypothesis.problem
        for guess in _guesses(hypothesis):
            simple = special_case(guess)
            if simple is not None and simple.identifier == special.identifier != guess.identifier:
                penalty = prior_penalty(problem, guess) - prior_penalty(problem, special)
                more = len(guess.numeric()) - len(special.numeric())
                found.append(GeneralLaw(guess.identifier, special.identifier, more, penalty))
    return found


def _guesses(hypothesis: Hypothesis) -> list[Effect]:
    """A first guess of each effect of the catalogue at the place of a name."""
    effect = hypothesis.effect
    views = hypothesis.problem.situations(hypothesis.model)
    guesses = []
    for kind in known_effects().values():
        if effect is None or kind.place != effect.place or kind.noise_like or not kind.listed:
            continue
        if hypothesis.problem.kind.unseen(kind) is not None:
            continue
        try:
            guesses.append(next(iter(kind.candidates(views.of(kind)))))
        except (StopIteration, ValueError, ArithmeticError):  # it has no guess for such a plant
            continue
    return guesses
