"""A plant with effects, as numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from camid.effects.base import Effect

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Model:
    """A plant with effects.

    Attributes
    ----------
    coefficients : ndarray, shape (m + 1 + n,)
        [b_0 … b_m, a_1 … a_n] of the monic plant in SI units.
    effects : tuple of Effect
    initial : tuple of (ndarray or None)
        Companion state of the plant at the start of each recording; None at rest.
    constants : dict of str to float
        Constants of the plant beside its coefficients; its kind knows what they mean
        (:class:`camid.fitting.plants.kind.PlantKind`).
    """

    coefficients: Array
    effects: tuple[Effect, ...] = ()
    initial: tuple[Array | None, ...] = ()
    constants: Mapping[str, float] = field(default_factory=dict)

    def without(self, index: int) -> Model:
        """The same model without one of its effects."""
        return replace(self, effects=self.effects[:index] + self.effects[index + 1 :])

    def plus(self, effect: Effect) -> Model:
        """The same model with one effect more."""
        return replace(self, effects=(*self.effects, effect))
