"""What residual and recorded values show of an effect that changes the noise."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, log
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from camid.effects.base import Effect

# Logarithm of the Bayes factor from which an effect is there, and not noise of another kind: twenty to one (Kass &
# Raftery 1995, J. Am. Stat. Assoc. 90, 773-795: strong).
LEAST_EVIDENCE = log(20.0)


@dataclass(frozen=True)
class Recognition:
    """An effect that changes the noise, as residual and recorded values show it.

    Attributes
    ----------
    effect : Effect
    standard_deviations : dict of str to float
        Of its parameters.
    p_value : float
        Probability that its absence shows as much.
    spoiled : ndarray of bool, shape (N,)
        Rows that say nothing of the motion.
    evidence : float
        Logarithm of the Bayes factor against noise of another kind that shows as much; it has to reach
        `LEAST_EVIDENCE` for the effect to be there, and not only rows that are better left out.
    stands_out : bool
        Whether it shows beside whatever structure the residual has.
    """

    effect: Effect
    standard_deviations: dict[str, float]
    p_value: float
    spoiled: NDArray[np.bool_]
    evidence: float = inf
    stands_out: bool = False

    @property
    def named(self) -> bool:
        """Whether the effect is there."""
        return self.evidence > LEAST_EVIDENCE

    @property
    def false_alarm_probability(self) -> float:
        """Probability that the effect is not there: as `p_value` has it, or the evidence at even odds beforehand."""
        from scipy.special import expit

        return max(self.p_value, float(expit(-self.evidence)))
