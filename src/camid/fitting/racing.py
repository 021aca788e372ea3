"""Fits that are ended early because what they are held against is out of their reach.

A race (Maron & Moore 1994, *Hoeffding races*): where neither a fit nor what its derivatives promise comes near a rival,
what is left of it only says by how much it loses.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from camid.fitting.fit import Fitted

Array = NDArray[np.float64]

# Evaluations of the residual that any fit is given.
IN_ANY_CASE = 8
# Criterion beyond the rival's, with nothing counted for the rival's parameters, at which a fit has lost: odds of e^25.
LOST_BY = 50.0


class Race:
    """Whether a fit has lost against a rival of the same rows.

    Parameters
    ----------
    rival : Fitted
    """

    def __init__(self, rival: Fitted) -> None:
        self.rival, self.is_lost = rival, False
        # A model with fewer parameters is so much likelier at best.
        self.most_parsimony = len(rival.penalised_names) * float(np.log(len(rival.residual)))

    def judge(self, residual: Array, jacobian: Array, evaluations: int) -> bool:
        """Whether the fit has lost for good, from a residual, shape (M,), and its derivatives, shape (M, p).

        It has if the least that the derivatives promise is far behind the rival: the residual less its part in their
        span. Bounds are left out of account, with which less is possible.
        """
        if self.is_lost or evaluations < IN_ANY_CASE:
            return self.is_lost
        promised = residual - jacobian @ np.linalg.lstsq(jacobian, residual, rcond=None)[0]
        cost, rival = float(promised @ promised), self.rival
        if cost > rival.cost:
            behind = len(promised) * float(np.log(cost / max(rival.cost, 1e-300)))
            behind /= rival.inflation(rival.residual - promised)
            self.is_lost = behind - self.most_parsimony > LOST_BY
        return self.is_lost
