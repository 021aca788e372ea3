"""From what rivals would leave to weights: what a diagnosis of all recordings would then state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot, inf, log, sqrt

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.weights import (
    Comparison,
    Member,
    calibrated,
    penalty_of_generality,
    relative_weight,
    weight_outside,
    weights,
)
from camid.effects.special_cases import special_case
from camid.experiment_design.general_laws import GeneralLaw
from camid.experiment_design.hypothesis import GIVEN, Hypothesis
from camid.experiment_design.prediction import FITTED_SHARE, NoiseModel, Response

Array = NDArray[np.float64]

# Weight of one name from which it is the answer.
DECIDED = 0.95
# Odds of all else together, physics outside the catalogue included, at which it is just the answer.
LEFT_TO_OTHERS = (1.0 - DECIDED) / DECIDED
# What more odds count than that, at most, and half of it at so many natural units, those of the rivals alone and those
# of all else together: a search climbs it from where nothing is decided, and afterwards prefers what has more in
# reserve.
RESERVE, HALFWAY = 0.5, 10.0
LARGEST_ODDS = 1e25
# A name that is not listed may come back: it is behind by so much evidence now, and leaves such a share of the mismatch
# that an experiment shows.
UNLISTED_GAP, UNLISTED_SHARE = 6.0, 0.1
# Noise of the next recording, in standard deviations, with its probabilities (Gauss and Hermite).
NOISE, PROBABILITIES = np.polynomial.hermite_e.hermegauss(7)
PROBABILITIES = PROBABILITIES / PROBABILITIES.sum()


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
    """All pairs of names for the same effect; of a rival whose other values are there, too, what the best leave."""
    whitened = [noise.whitened(r.output) for r in found]
    result = []
    for i, one in enumerate(found):
        if not one.hypothesis.is_name:
            continue
        without = next((k for k, r in enumerate(found) if _is_without(r.hypothesis, one.hypothesis)), None)
        mismatch = 0.0 if without is None else found[without].left_of(whitened[i] - whitened[without])
        for j, other in enumerate(found):
            if j != i and not other.hypothesis.variant and excludes(one.hypothesis, other.hypothesis):
                left = min(found[k].left_of(whitened[i] - whitened[k]) for k in values_of(found, other.hypothesis))
                result.append(Pair(i, j, min(left, most_left(one.hypothesis, other.hypothesis)), mismatch))
    return result


def values_of(found: Sequence[Response], name: Hypothesis) -> list[int]:
    """Places of the responses of a name: as it was fitted, and with other values."""
    every = ((k, r.hypothesis) for k, r in enumerate(found))
    return [k for k, h in every if (h.identifier, h.question) == (name.identifier, name.question)]


def most_left(true: Hypothesis, rival: Hypothesis) -> float:
    """What a rival leaves at most: a law of which the true one is a special case fits all that this one does."""
    return max(true.misfit - rival.misfit, 0.0) if _special_case(rival) == true.identifier else np.inf


def _special_case(hypothesis: Hypothesis) -> str | None:
    """Name of the special case of a hypothesis's effect."""
    simple = None if hypothesis.effect is None else special_case(hypothesis.effect)
    return None if simple is None else simple.identifier


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
    general : sequence of GeneralLaw
        Laws of the catalogue that are no hypotheses, and have one of these for a special case.
    sums : sequence of GeneralLaw
        Laws that are one of these beside a constant that is estimated anyway.
    """

    hypotheses: Sequence[Hypothesis]
    rows_before: int
    experiments: int = 2
    general: Sequence[GeneralLaw] = ()
    sums: Sequence[GeneralLaw] = ()

    def evidence(self, pair: Pair, rows: int) -> float:
        """Expected difference of the criterion that the experiment adds."""
        more = self.hypotheses[pair.rival].count - self.hypotheses[pair.true].count
        fitted = FITTED_SHARE * rows
        growth = log1p(fitted / self.rows_before) if self.rows_before else log(max(fitted, 1.0))
        return weight_of_evidence(pair.left, self.rows_before, fitted) + more * growth

    def _members(self, true: int, pairs: Sequence[Pair], rows: int) -> list[tuple[Member, float]]:
        """The rivals of a name after the experiment, each with the standard deviation of its gap over the noise."""
        found = [self._member(p, rows) for p in pairs if p.true == true]
        name = self.hypotheses[true].identifier
        present = {m.identifier for m, _ in found}
        total = max(self.rows_before + FITTED_SHARE * rows, 1.0)
        for law in self.general:
            if law.special == name and law.identifier not in present:
                member = Member(law.identifier, law.more * log(total) + law.penalty, 0.0, general=True, more=law.more)
                # What its additional numbers fit of the noise varies as χ² of their number does.
                found.append((member, sqrt(2.0 * law.more)))
        comparison = self._comparison(true, gain=self._gain(true, pairs), rows=round(total))
        # Once and for all: what compares members later knows nothing of the rows.
        return [(replace(m, gap=m.gap + penalty_of_generality(m, comparison), more=0), spread) for m, spread in found]

    def _member(self, pair: Pair, rows: int) -> tuple[Member, float]:
        true, rival = self.hypotheses[pair.true], self.hypotheses[pair.rival]
        gap = rival.criterion - true.criterion + self.evidence(pair, rows)
        mismatch = pair.mismatch + (self._mismatch(pair.true) or 0.0)
        left = pair.left + max(rival.misfit - true.misfit, 0.0)
        share = left / mismatch if mismatch > 0.0 else 1.0
        simple, of_rival = _special_case(true), _special_case(rival)
        member = Member(
            rival.identifier,
            gap,
            min(share, 1.0),
            simple is not None and simple == rival.identifier,
            of_rival is not None and of_rival == true.identifier,
            simple is not None and simple == of_rival,
            rival.count - true.count,
        )
        return member, self._spread(pair.true, pair.left, rows)

    def _gain(self, true: int, pairs: Sequence[Pair]) -> float:
        """What a name removes of all recordings, in variances of the noise; infinite where nobody knows.

        That is so without a simulation without the effect.
        """
        return max(p.mismatch for p in pairs if p.true == true) + (self._mismatch(true) or 0.0) or inf

    def _comparison(self, true: int, members: tuple[Member, ...] = (), gain: float = inf, rows: int = 1) -> Comparison:
        """What a name that is right and leaves nothing is compared with."""
        effect = self.hypotheses[true].effect
        linear = effect is not None and effect.imitates_linear_dynamics
        return Comparison(
            members, share=1.0, left=0.0, gain=gain, linear=linear, experiments=self.experiments, rows=rows
        )

    def weight(self, true: int, pairs: Sequence[Pair], rows: int) -> float:
        """Weight that the diagnosis is expected to state for a name, if it is right and leaves nothing.

        It is the mean over the noise of the next recording: evidence of ten may as well come as two or eighteen.
        """
        name, rivals = self.hypotheses[true].identifier, self._members(true, pairs, rows)
        # Nothing that is played takes these away, so that a search has nothing to do with them.
        rivals += [(Member(law.identifier, law.penalty, 0.0), 0.0) for law in self.sums if law.special == name]
        gain, mean = self._gain(true, pairs), 0.0
        for noise, probability in zip(NOISE, PROBABILITIES, strict=True):
            names, outside = weights(self._comparison(true, _recorded(name, rivals, float(noise)), gain))
            own = dict(names).get(name, 0.0)
            # One of the simulations that are held against each other is right.
            mean += float(probability) * (own / (1.0 - outside) if self.hypotheses[true].question == GIVEN else own)
        return mean

    def separation(self, true: int, pairs: Sequence[Pair], rows: int) -> float:
        """What a search climbs for a name that is right: about the probability that its stated weight reaches 95 %.

        That weight leaves a share to physics outside the catalogue, which falls with what the effect removes: an
        experiment has to show the effect, and not only that it is none of its rivals.
        """
        name, rivals = self.hypotheses[true].identifier, self._members(true, pairs, rows)
        comparison = self._comparison(true, gain=self._gain(true, pairs))
        outside = 0.0
        if self.hypotheses[true].question != GIVEN:
            outside = weight_outside(comparison, calibrated())
            rivals.append(self._not_listed(next(p for p in pairs if p.true == true), rows))
        mean = 0.0
        for noise, probability in zip(NOISE, PROBABILITIES, strict=True):
            own, *others = (relative_weight(m, comparison.chances) for m in _recorded(name, rivals, float(noise)))
            odds = max(sum(others), 1.0 / LARGEST_ODDS) / max(own, 1.0 / LARGEST_ODDS)
            of_all = (odds + outside) / (1.0 - outside)
            decided = LEFT_TO_OTHERS / (LEFT_TO_OTHERS + of_all)
            mean += float(probability) * (decided + 0.5 * (_reserve(odds) + _reserve(of_all)))
        return mean

    def _not_listed(self, pair: Pair, rows: int) -> tuple[Member, float]:
        """What stands for the names that a diagnosis has left out."""
        left = UNLISTED_SHARE * pair.mismatch
        gap = UNLISTED_GAP + weight_of_evidence(left, self.rows_before, FITTED_SHARE * rows)
        return Member("", gap, UNLISTED_SHARE), self._spread(pair.true, left, rows)

    def _spread(self, true: int, left: float, rows: int) -> float:
        """Standard deviation of what is evidence of D: twice the log ratio of two laws varies by 2 √D over the noise.

        D itself goes with the square of the effect, of which the earlier recordings tell the size with an uncertainty.
        """
        without = self._mismatch(true)
        size = 0.0 if without is None else 2.0 * left / sqrt(max(without, 1.0))
        return hypot(2.0 * sqrt(left), size) / (1.0 + left / max(self.rows_before + rows, 1))

    def _mismatch(self, true: int) -> float | None:
        """What a name removes of the earlier recordings, in variances of the noise; None where that is not known."""
        name = self.hypotheses[true]
        without = next((h for h in self.hypotheses if _is_without(h, name)), None)
        return None if without is None else max(without.misfit - name.misfit, 0.0)

    def score(self, pairs: Sequence[Pair], rows: int) -> float:
        """What a search maximises: the mean of the separation over the names, by their weights."""
        names = sorted({p.true for p in pairs})
        total = sum(self.hypotheses[i].weight for i in names)
        parts = [self.hypotheses[i].weight * self.separation(i, pairs, rows) for i in names]
        return sum(parts) / total if total > 0.0 else 0.0


def _reserve(odds: float) -> float:
    """What odds against a name count beside the probability that it is the answer."""
    return RESERVE * -log(odds) / (HALFWAY + abs(log(odds)))


def _recorded(name: str, rivals: Sequence[tuple[Member, float]], noise: float) -> tuple[Member, ...]:
    """A name and its rivals after a recording with such noise, measured by the likeliest of them."""
    gaps = [member.gap + spread * noise for member, spread in rivals]
    least = min([0.0, *gaps])
    others = (replace(m, gap=gap - least) for (m, _), gap in zip(rivals, gaps, strict=True))
    return Member(name, -least, 0.0), *others
