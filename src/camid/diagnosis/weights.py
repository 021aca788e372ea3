"""Weights of what an effect may be: the names that a recording cannot tell apart, and physics outside the catalogue.

The weights are posterior probabilities in a mixture of two likelihoods. Either a law of the catalogue is exact: then
the marginal likelihoods of the laws count, by Bayes's criterion. Or the rig has another law of the same name, and the
catalogue's leaves a share of the mismatch whose density falls off exponentially. That nothing of the catalogue is right
has odds that grow with a power of the share that is left unexplained and, for an effect beside a stronger one, with its
weakness: a weak effect beside a strong one may only stand for what the strong one's law has inexactly. The constants of
these densities are estimated from recordings of rigs with concealed effects (``snakemake calibration``), which neither
the proof nor any test uses. It is a generalised Bayesian posterior (Bissiri, Holmes & Walker 2016, J. R. Stat. Soc. B
78, 1103–1130), derived in docs/diagnosis.md.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from math import exp, inf, log, log1p

UNLISTED = "unlisted"  # alternative of a finding that stands for physics outside the catalogue
# Weight from which an alternative is worth naming, and how many effects a class may hold.
LEAST_WEIGHT = 0.01
LARGEST_CLASS = 4
# Weight that a name needs to stand in the headline.
HEADLINE_WEIGHT = 0.5
# Prior probability of a law of which dry friction is the special case: rigs have dry friction more often.
GENERAL_LAW = 0.3
GENERAL_ODDS = GENERAL_LAW / (1.0 - GENERAL_LAW)
# Shares below this are zero.
LEAST_SHARE = 1e-9


@dataclass(frozen=True)
class Constants:
    """Constants of the densities.

    Attributes
    ----------
    other_law : float
        Prior probability that a law is another one of its name.
    law_error : float
        Mean share of the mismatch that the catalogue's law then leaves.
    unseen : float
        Variances of the noise that physics outside the catalogue may leave without a test seeing it.
    outside, outside_left : float
        Log odds of physics outside the catalogue where nothing is left, per unit of the logarithm of the share left.
    beside_share : float
        Log odds that an effect beside a stronger one has in addition, per unit of the logarithm of the share that it
        removes.
    linear : float
        Log odds that linear dynamics have in addition: what is linear and outside the catalogue is imitated by them
        with every input, and by two of them to any accuracy.
    noise, noise_beside : float
        Log odds that an effect on the noise is the shadow of something else, and in addition where another effect is
        named.
    """

    other_law: float
    law_error: float
    unseen: float
    outside: float
    outside_left: float
    beside_share: float
    linear: float
    noise: float
    noise_beside: float


@dataclass(frozen=True)
class Member:
    """A name that an effect may have.

    Attributes
    ----------
    identifier : str
    gap : float
        By how much Bayes's criterion exceeds that of the likeliest.
    left : float
        Share of the mismatch without the effect that it leaves beyond what the likeliest one leaves.
    special, general : bool
        Whether it is a special case of the likeliest, or has that for its special case.
    sibling : bool
        Whether it and the likeliest are different laws of the same special case. A law of the rig may then have what
        makes either of them general, and ``left`` is what this one leaves beyond the best of these other laws, their
        special case included.
    more : int
        Parameters that it has beyond those of the likeliest.
    odds : float
        Prior odds against the likeliest of what is exactly that in these recordings.
    """

    identifier: str
    gap: float
    left: float
    special: bool = False
    general: bool = False
    sibling: bool = False
    more: int = 0
    odds: float = 1.0


@dataclass(frozen=True)
class Comparison:
    """What one effect of a diagnosis was compared with.

    Attributes
    ----------
    members : tuple of Member
        The likeliest first.
    share : float
        Of the refitted sum of squares that the effect removes.
    left : float
        Of the mismatch that all effects together leave, where that is more than noise.
    gain : float
        Mismatch that the effect removes, in variances of the noise: how finely the recording shows its law.
    strongest : bool
        Whether no other effect removes more; of an effect on the noise, whether no other is named.
    linear : bool
        Whether it is linear dynamics with numbers that a fit can bend; of an effect on the noise, whether such are
        named beside it.
    noise : bool
        Whether it is an effect on the noise.
    experiments : int
        How many experiments with different inputs are explained.
    rows : int
        That are fitted.
    """

    members: tuple[Member, ...]
    share: float
    left: float
    gain: float = inf
    strongest: bool = True
    linear: bool = False
    noise: bool = False
    experiments: int = 1
    rows: int = 1

    @property
    def chances(self) -> int:
        """How many experiments had a chance to show that it is another law.

        What is linear, and imitates linear dynamics, does so with every input; and a weaker effect that stands for what
        the law of a stronger one has inexactly stands for it in every experiment.
        """
        return 1 if self.linear or not self.strongest else self.experiments

    def unexplained(self, unseen: float) -> float:
        """Share of what the effect removes that is left, or that may be without a test seeing it; at most one.

        ``unseen`` are variances of the noise.
        """
        left = self.left / self.share if self.share > 0.0 else 0.0
        return min(left + unseen / max(self.gain, unseen), 1.0)


@cache
def calibrated() -> Constants:
    """The constants that ``snakemake calibration`` found."""
    content = json.loads(files("camid").joinpath("diagnosis/weights.json").read_text(encoding="utf-8"))
    return Constants(**content["constants"])


def weights(comparison: Comparison, constants: Constants | None = None) -> tuple[list[tuple[str, float]], float]:
    """Weights of the names, the likeliest first, and of physics outside the catalogue; together they are one.

    Parameters
    ----------
    comparison : Comparison
    constants : Constants, optional
        Those of :func:`calibrated` by default.

    Returns
    -------
    list of (str, float), float
        At most `LARGEST_CLASS` names; those whose weight is below `LEAST_WEIGHT` are left out.
    """
    constants = constants or calibrated()
    unlisted = weight_outside(comparison, constants)
    members = [replace(m, gap=m.gap + penalty_of_generality(m, comparison)) for m in comparison.members]
    # An effect may be a rival of its own and, as the sum of two that are found, one more: its name is there once.
    of_name: dict[str, float] = {}
    for member in members:
        weight = relative_weight(member, comparison.chances, constants)
        of_name[member.identifier] = of_name.get(member.identifier, 0.0) + weight
    total = sum(of_name.values())
    raw = sorted(((name, value / total) for name, value in of_name.items()), key=lambda item: -item[1])
    kept = [item for item in raw if item[1] >= LEAST_WEIGHT][:LARGEST_CLASS]
    total = sum(value for _, value in kept)
    return [(name, value / total * (1.0 - unlisted)) for name, value in kept], unlisted


def penalty_of_generality(member: Member, comparison: Comparison) -> float:
    """What Bayes's criterion asks too little of a law that has the likeliest for its special case.

    The criterion takes what one row says of a parameter for all that is known of it beforehand (Kass & Wasserman 1995,
    J. Am. Stat. Assoc. 90, 928-934). What makes a law more general is beforehand about as large as the effect itself,
    which removes ``gain`` variances of the noise.
    """
    if not member.general or member.more <= 0 or not 0.0 < comparison.gain < inf:
        return 0.0
    return member.more * max(log1p(comparison.gain) - log(comparison.rows), 0.0)


def relative_weight(member: Member, chances: int = 1, constants: Constants | None = None) -> float:
    """Weight of a name relative to the likeliest, whose is one; see :attr:`Comparison.chances`.

    That the rig has another law than the catalogue's, which the likeliest happens to imitate, has to happen again in
    every experiment with another input. A name's prior odds hold whether its law is exact or not.
    """
    constants = constants or calibrated()
    other_law = constants.other_law**chances
    exact = exp(-0.5 * max(member.gap, 0.0))
    # What a special case leaves is what makes its general law general.
    other = 1.0 if member.special else exp(-max(member.left, 0.0) / constants.law_error)
    other *= GENERAL_ODDS if member.sibling or member.general else 1.0
    # What makes a law more general, and does nothing, is not there, whether the special case is exact or not.
    other *= exp(-0.5 * max(member.gap, 0.0)) if member.general else 1.0
    # A general law that fits better than its special case, and says no more, is ranked behind it for its prior.
    exact *= GENERAL_ODDS if member.general and member.gap < 0.0 else 1.0
    return member.odds * ((1.0 - other_law) * exact + other_law * other)


def weight_outside(comparison: Comparison, constants: Constants) -> float:
    """Weight of physics outside the catalogue."""
    if comparison.noise:
        odds = constants.noise + constants.noise_beside * (not comparison.strongest)
        # Linear dynamics that imitate others leave a colour.
        return _probability(odds + constants.linear * comparison.linear)
    odds = constants.outside + constants.outside_left * log(max(comparison.unexplained(constants.unseen), LEAST_SHARE))
    # Another input is another chance for a law outside the catalogue to leave something.
    odds *= comparison.chances
    odds += constants.linear * comparison.linear
    if not comparison.strongest:
        odds += constants.beside_share * log(max(comparison.share, LEAST_SHARE))
    return _probability(odds)


def _probability(odds: float) -> float:
    """Of a thing whose odds have this logarithm."""
    return 1.0 / (1.0 + exp(-odds))


def log_likelihood(comparisons: Sequence[tuple[Comparison, set[str]]], constants: Constants) -> float:
    """Mean logarithm of the weight that is given to the truth.

    Parameters
    ----------
    comparisons : sequence of (Comparison, set of str)
        With the identifiers of what is there.
    constants : Constants
    """
    total = 0.0
    for comparison, truth in comparisons:
        names, unlisted = weights(comparison, constants)
        named = sum(weight for name, weight in names if name in truth)
        total += log(max(named if named > 0.0 else unlisted, LEAST_WEIGHT))
    return total / max(len(comparisons), 1)
