"""What the first rows say of the numbers of a model, to first order: beside a fit that need not simulate them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.fitting.first_rows import FirstRows
from camid.fitting.output_error import sensitivities
from camid.fitting.packing import Packing
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Beginning:
    """Errors of the first rows about a model by what they count for, and their derivatives; see :class:`FirstRows`.

    Attributes
    ----------
    begin : ndarray, shape (p,)
        Packed numbers of the model.
    errors : ndarray, shape (e,)
        Recorded minus simulated output; none where the fitted rows say how the motion began.
    table : ndarray, shape (e, p)
        Derivatives of the simulated output.
    """

    begin: Array
    errors: Array
    table: Array

    @classmethod
    def about(cls, problem: Problem, packing: Packing, model: Model, residual: Array) -> Beginning:
        """Beside fitted rows that leave such a residual, shape (M,)."""
        begin, first = packing.pack(model), FirstRows.of(problem, model)
        if first is None:
            return cls(begin, np.zeros(0), np.zeros((0, len(begin))))
        weight, simulated = first.weight(residual), first.alone.simulate_fitted(model)
        table = sensitivities(first.alone, packing, begin, simulated)
        return cls(begin, weight * (first.alone.output - simulated), weight * table)

    def error(self, vector: Array) -> Array:
        """Of the first rows at packed numbers, shape (p,), to first order: shape (e,)."""
        return self.errors - self.table @ (vector - self.begin)
