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
        Companion state of the plant at the start of each recording, behind it those of modes that effects have beside,
        after and before it (:meth:`modes`), and behind these what effects remember (:meth:`memories`); None at rest.
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

    def replaced(self, index: int, effect: Effect) -> Model:
        """The same model with another effect in the place of one, which acts where that one does."""
        effect = effect.leading(self.effects[index].leads)
        return replace(self, effects=(*self.effects[:index], effect, *self.effects[index + 1 :]))

    def in_order(self) -> tuple[Effect, ...]:
        """The effects in the order in which they act."""
        return tuple(sorted(self.effects, key=lambda effect: not effect.leads))

    def modes(self) -> list[int]:
        """For every state that effects have beside the plant, then for those after it and before it, the index."""
        beside = [(i, e.beside_plant()) for i, e in enumerate(self.effects)]
        after = [(i, e.after_plant()) for i, e in enumerate(self.effects)]
        before = [(i, e.before_plant()) for i, e in enumerate(self.effects)]
        return [i for i, part in (*beside, *after, *before) if part is not None for _ in range(part.order)]

    def memories(self) -> list[int]:
        """Index of every effect whose force remembers motion that may have gone before a recording."""
        return [i for i, e in enumerate(self.effects) if e.largest_memory is not None]

    def memory_in_order(self, run: int, order: int) -> Array | None:
        """What each effect remembers at the start of a recording, in the order in which they act, shape (f,).

        None where the recording begins at rest. The plant is of such an order.
        """
        state, memories = self.initial[run] if self.initial else None, self.memories()
        first = order + len(self.modes())
        if state is None or len(state) != first + len(memories) or not memories:
            return None
        begun = np.zeros(len(self.effects))
        # Where an effect has gone, what was another's state may stand in the place of a memory until a fit.
        largest = [float(self.effects[m].largest_memory or 0.0) for m in memories]
        begun[memories] = np.clip(state[first:], np.negative(largest), largest)
        return begun[np.argsort([not e.leads for e in self.effects], kind="stable")]

    def with_states_of_effects(self, order: int) -> Model:
        """The same model with initial states of a plant of an order and of its effects, those at rest that it lacks."""
        length = order + len(self.modes()) + len(self.memories())
        if all(state is None or len(state) == length for state in self.initial):
            return self
        rest = np.zeros(length)
        states = [None if s is None else np.concatenate([s[:length], rest[len(s) :]]) for s in self.initial]
        return replace(self, initial=tuple(states))

    def plus(self, effect: Effect) -> Model:
        """The same model with one effect more."""
        return replace(self, effects=(*self.effects, effect))
