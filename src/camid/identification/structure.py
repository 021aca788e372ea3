"""Which plant is looked for: its orders, and which of its coefficients are free."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Structure:
    """Which plant is looked for: degrees of B and A, and what is free in them.

    Attributes
    ----------
    numerator, denominator : ndarray, shapes (m + 1,) and (n + 1,)
        Descending powers of s, monic denominator. Values of the coefficients that are not free.
    free_numerator, free_denominator : ndarray of bool, same shapes
        What is estimated; the leading denominator coefficient never is.
    """

    numerator: Array
    denominator: Array
    free_numerator: NDArray[np.bool_]
    free_denominator: NDArray[np.bool_]

    @classmethod
    def of_order(cls, poles: int, zeros: int) -> Structure:
        """All coefficients free, no values known."""
        monic = np.eye(poles + 1)[0]
        return cls(np.zeros(zeros + 1), monic, np.ones(zeros + 1, bool), monic == 0.0)

    @classmethod
    def fixed(cls, plant: TransferFunction) -> Structure:
        """Structure of a plant of which nothing is to be estimated."""
        monic = plant.monic
        numerator, denominator = np.array(monic.numerator), np.array(monic.denominator)
        return cls(numerator, denominator, np.zeros(len(numerator), bool), np.zeros(len(denominator), bool))

    def all_fixed(self) -> Structure:
        """The same with nothing to be estimated."""
        return Structure(
            self.numerator, self.denominator, np.zeros(len(self.numerator), bool), np.zeros(len(self.denominator), bool)
        )

    @property
    def names(self) -> list[str]:
        """Of the coefficients, by powers of s, as tables have them: b1, b0, a2, a1, a0."""
        zeros, poles = self.degree, self.order
        return [f"b{zeros - i}" for i in range(zeros + 1)] + [f"a{poles - 1 - i}" for i in range(poles)]

    @property
    def order(self) -> int:
        """Number of poles n."""
        return len(self.denominator) - 1

    @property
    def degree(self) -> int:
        """Degree of the numerator m."""
        return len(self.numerator) - 1

    @property
    def free(self) -> NDArray[np.bool_]:
        """Which of [b_0 … b_m, a_1 … a_n] are estimated, shape (m + 1 + n,)."""
        return np.concatenate([self.free_numerator, self.free_denominator[1:]])

    def coefficients(self) -> Array:
        """[b_0 … b_m, a_1 … a_n]."""
        return np.concatenate([self.numerator, self.denominator[1:]])

    def plant(self, coefficients: Array) -> TransferFunction:
        """Transfer function of [b_0 … b_m, a_1 … a_n]."""
        split = self.degree + 1
        return TransferFunction(tuple(coefficients[:split]), (1.0, *coefficients[split:]))

    def full_covariance(self, covariance: Array) -> Array:
        """Covariance of all coefficients, zero for those that are not free, from that of the free ones."""
        free = np.flatnonzero(self.free)
        result = np.zeros((len(self.free), len(self.free)))
        result[np.ix_(free, free)] = covariance
        return result
