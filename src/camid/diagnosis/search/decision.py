"""What a search for effects has decided, and what it has found on its way."""

from __future__ import annotations

from dataclasses import dataclass, field

from camid.diagnosis.search.hypothesis import Hypothesis
from camid.diagnosis.search.screening import Signatures
from camid.fitting.fit import Fitted
from camid.fitting.learned_law import LearnedLaw

# Difference of the criterion within which two fits of the same effects are the same minimum.
SAME_MINIMUM = 1.0


@dataclass(frozen=True)
class Decision:
    """The effects that were added, each with the hypotheses that competed with it.

    Attributes
    ----------
    base, fitted : Fitted
        Without and with the effects.
    rivals : list of list of Hypothesis
        For each effect found: every hypothesis in its place, the best first, the effect itself among them.
    without : list of Fitted
        For each effect found: the model without it, fitted.
    laws : tuple of LearnedLaw
        Laws without a name behind them, for what they leave; each is fitted with those before it.
    certain : frozenset of str
        Effects that hold where everything is allowed for that the inexact laws of the others could do.
    interrupted : bool
        Whether the search for names ended where a law seemed to be inexact.
    """

    base: Fitted
    fitted: Fitted
    rivals: list[list[Hypothesis]] = field(default_factory=list)
    without: list[Fitted] = field(default_factory=list)
    laws: tuple[LearnedLaw, ...] = ()
    certain: frozenset[str] = frozenset()
    interrupted: bool = False

    @property
    def improved(self) -> Fitted:
        """What the improved simulation holds: the effects found come first."""
        return self.laws[-1].fitted if self.laws else self.fitted


class Searches:
    """What was found beside each set of effects, so that nothing is searched for twice."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, ...], tuple[Fitted, list[Hypothesis]]] = {}
        self.signatures = Signatures()

    def beside(self, base: Fitted) -> list[Hypothesis] | None:
        """What an earlier search beside the same effects found, if the coefficients were in the same minimum."""
        earlier, found = self._found.get(self._effects(base), (None, []))
        return found if earlier is not None and abs(earlier.criterion_beyond(base)) < SAME_MINIMUM else None

    def keep(self, base: Fitted, found: list[Hypothesis]) -> None:
        """Remember what a search found."""
        self._found[self._effects(base)] = (base, found)

    @staticmethod
    def _effects(base: Fitted) -> tuple[str, ...]:
        return tuple(sorted(e.identifier for e in base.model.effects))
