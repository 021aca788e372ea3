"""From what rivals would leave to weights: what a diagnosis of all recordings would then state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, log

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.weights import Comparison, Member, calibrated, relative_weight, weight_outside
from camid.experiment_design.hypothesis import GIVEN, Hypothesis
from camid.experiment_design.prediction import FITTED_SHARE, NoiseModel, Response

Array = NDArray[np.float64]

# Weight of one name from which it is the answer.
DECIDED = 0.95
# Evidence beyond this many natural units says nothing more.
ENOUGH = 60.0


@dataclass(frozen=True)
class Pair:
    """What an experiment says between two names if the first is right.

    Attributes
    ----------
    true, rival : int
        Places of the hypotheses.
    left : float
        D of the rival, in variances of the noise.
    mismatch : float
        The same of the simulation without the effect.
    """

    true: int
    rival: int
    left: float
    mismatch: float


def pairs_of(found: Sequence[Response], noise: NoiseModel) -> list[Pair]:
    """All pairs of names for the same effect."""
    whitened = [noise.whitened(r.output) for r in found]
    result = []
    for i, one in enumerate(found):
        if not one.hypothesis.identifier:
            continue
        without = next((k for k, r in enumerate(found) if _is_without(r.hypothesis, one.hypothesis)), None)
        mismatch = 0.0 if without is None else found[without].left_of(whitened[i] - whitened[without])
        for j, other in enumerate(found):
            if j != i and excludes(one.hypothesis, other.hypothesis):
                result.append(Pair(i, j, other.left_of(whitened[i] - whitened[j]), mismatch))
    return result


def excludes(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether two hypotheses are names for the same effect."""
    return one.question == other.question and bool(one.identifier) and bool(other.identifier)


def _is_without(one: Hypothesis, other: Hypothesis) -> bool:
    return one.question == other.question and not one.identifier


def weight_of_evidence(left: float, rows_before: int, rows: float) -> float:
    """Expected difference of Bayes's criterion (twice the logarithm of the Bayes factor), as a diagnosis states it."""
    count = rows_before + rows
    return count * log1p(left / count)


def log1p(x: float) -> float:
    """Logarithm of one and a number that is not negative."""
    return float(np.log1p(max(x, 0.0)))


@dataclass(frozen=True)
class Judge:
    """What turns pairs into weights.

    Attributes
    ----------
    hypotheses : sequence of Hypothesis
    rows_before : int
        Rows that were fitted before.
    experiments : int
        Experiments with different inputs, the next one included.
    """

    hypotheses: Sequence[Hypothesis]
    rows_before: int
    experiments: int = 2

    def evidence(self, pair: Pair, rows: int) -> float:
        """Expected difference of the criterion that the experiment adds."""
        more = self.hypotheses[pair.rival].count - self.hypotheses[pair.true].count
        fitted = FITTED_SHARE * rows
        growth = log1p(fitted / self.rows_before) if self.rows_before else log(max(fitted, 1.0))
        return weight_of_evidence(pair.left, self.rows_before, fitted) + more * growth

    def _member(self, pair: Pair, rows: int) -> Member:
        """The rival beside the true one after the experiment."""
        true, rival = self.hypotheses[pair.true], self.hypotheses[pair.rival]
        gap = rival.criterion - true.criterion + self.evidence(pair, rows)
        without = next((h for h in self.hypotheses if _is_without(h, true)), None)
        mismatch = pair.mismatch + (0.0 if without is None else max(without.misfit - true.misfit, 0.0))
        left = pair.left + max(rival.misfit - true.misfit, 0.0)
        share = left / mismatch if mismatch > 0.0 else 1.0
        simple = None if true.effect is None else true.effect.simplified()
        rivals = None if rival.effect is None else rival.effect.simplified()
        special = simple is not None and simple.identifier == rival.identifier
        general = rivals is not None and rivals.identifier == true.identifier
        sibling = simple is not None and rivals is not None and simple.identifier == rivals.identifier
        return Member(rival.identifier, gap, min(share, 1.0), special, general, sibling)

    def separation(self, pair: Pair, rows: int) -> float:
        """Natural logarithm of the odds against a rival that does not saturate: what a search climbs."""
        member = self._member(pair, rows)
        if member.special or member.general:
            return min(0.5 * member.gap, ENOUGH)
        weight = relative_weight(member, self._experiments(pair.true))
        return min(-log(max(weight, exp(-ENOUGH))), ENOUGH)

    def _experiments(self, true: int) -> int:
        """How many experiments count of a name; see :class:`camid.diagnosis.weights.Comparison`."""
        effect = self.hypotheses[true].effect
        return 1 if effect is not None and effect.linear_dynamics else self.experiments

    def weight(self, true: int, pairs: Sequence[Pair], rows: int) -> float:
        """Weight that the diagnosis would state for a name, if it is right and leaves nothing."""
        experiments = self._experiments(true)
        rivals = [self._member(p, rows) for p in pairs if p.true == true]
        among = 1.0 / (1.0 + sum(relative_weight(m, experiments) for m in rivals))
        if self.hypotheses[true].question == GIVEN:  # one of them is right
            return among
        outside = weight_outside(Comparison((), share=1.0, left=0.0, experiments=experiments), calibrated())
        return among * (1.0 - outside)

    def score(self, pairs: Sequence[Pair], rows: int) -> float:
        """What a search maximises: the mean over the names, by their weights, of the evidence against the nearest."""
        total, weights = 0.0, 0.0
        for i, hypothesis in enumerate(self.hypotheses):
            own = [self.separation(p, rows) for p in pairs if p.true == i]
            if own:
                # A rival that is still near counts most, and the others a little, too.
                total += hypothesis.weight * (min(own) + 0.25 * float(np.mean(own)))
                weights += hypothesis.weight
        return total / weights if weights > 0.0 else 0.0
