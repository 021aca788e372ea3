"""The numbers of an effect: its values by name and as a vector, their bounds, and which of them say nothing."""

from __future__ import annotations

from copy import copy
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.effects.parameter import Parameter, checked

Array = NDArray[np.float64]


class EffectValues:
    """Values of the parameters of an effect.

    Raises
    ------
    ValueError
        If a parameter is missing, unknown, not finite or out of its bounds.
    """

    identifier: ClassVar[str]
    parameters: ClassVar[tuple[Parameter, ...]]
    strength: ClassVar[str | None] = None

    def __init__(self, **values: Any) -> None:
        known = [p.name for p in self.parameters]
        for name in values:
            if name not in known:
                raise ValueError(f"{self.identifier} has no parameter '{name}' (known: {', '.join(known) or 'none'})")
        self.values: dict[str, Any] = {}
        self._neutral: tuple[float, ...] | None = None
        self.leads = False
        for parameter in self.parameters:
            if parameter.name not in values and parameter.default is None:
                raise ValueError(f"{self.identifier} needs the parameter '{parameter.name}'")
            value = values.get(parameter.name, parameter.default)
            self.values[parameter.name] = checked(self.identifier, parameter, value)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self.values.items())})"

    @classmethod
    def numeric(cls) -> tuple[Parameter, ...]:
        """Parameters that are numbers, in order."""
        return tuple(p for p in cls.parameters if p.is_number)

    def stated(self) -> dict[str, Any]:
        """Values by name, without names that say nothing: that of a state, of a plant without equations."""
        silent = {p.name for p in self.parameters if p.is_name and self.values[p.name] == p.default}
        return {name: value for name, value in self.values.items() if name not in silent}

    @property
    def vector(self) -> Array:
        """Values of the parameters that are numbers, in order."""
        return np.array([self.values[p.name] for p in self.numeric()], dtype=float)

    def with_vector(self, vector: Array) -> Self:
        """The same effect with other numbers, moved to the nearest allowed value."""
        changed = {p.name: float(min(max(v, p.lower), p.upper)) for p, v in zip(self.numeric(), vector, strict=True)}
        moved = type(self)(**{**self.values, **changed})
        moved._neutral = self._neutral
        moved.leads = self.leads
        return moved

    def bounds(self, acquisition: Acquisition) -> list[tuple[float, float]]:
        """Least and largest value of each number in :attr:`vector` with this acquisition."""
        return [(p.lower, p.upper) for p in self.numeric()]

    def within(self, acquisition: Acquisition) -> Self:
        """The same effect, its numbers moved to the nearest that are allowed with this acquisition."""
        lower, upper = np.array(self.bounds(acquisition)).reshape(-1, 2).T
        return self.with_vector(np.clip(self.vector, lower, upper))

    def measured_from(self, *neutral: float) -> Self:
        """The same effect, given the values of its parameters this recording shows nothing of it."""
        self._neutral = neutral
        return self

    def leading(self, leads: bool = True) -> Self:
        """The same effect, acting on the input before those that stand ahead of it in a model; or where it stands."""
        moved = copy(self)
        moved.leads = leads
        return moved

    @property
    def branch(self) -> tuple[Any, ...]:
        """What no fit changes in a guess: choices, and parameters whose value leaves the recording as it is."""
        words = tuple(v for v in self.values.values() if isinstance(v, str)) + ("leading",) * self.leads
        return words if self._neutral is None else (*words, *(self.vector == np.asarray(self._neutral)).tolist())

    @property
    def idle(self) -> frozenset[str]:
        """Numbers that have the value of which this recording shows nothing."""
        if self._neutral is None:
            return frozenset()
        numbers = zip(self.numeric(), self.vector, self._neutral, strict=True)
        return frozenset(parameter.name for parameter, value, neutral in numbers if value == neutral)

    def scaled(self, factor: float) -> Self:
        """The same effect, changing the output by about ``factor`` ≥ 0 times as much; the same where it has no size."""
        if self.strength is not None:
            vector = self.vector
            vector[[p.name for p in self.numeric()].index(self.strength)] *= factor
            return self.with_vector(vector)
        if self._neutral is not None:
            neutral = np.asarray(self._neutral)
            return self.with_vector(neutral + max(factor, 0.0) * (self.vector - neutral))
        return self
