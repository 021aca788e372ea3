"""A parameter of an effect: its meaning, unit and bounds."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Parameter:
    """A parameter of an effect.

    Attributes
    ----------
    name, meaning : str
    unit : str
        In u, y and s, for instance ``u/y^3``; empty for a pure number.
    lower, upper : float
        Bounds, in that unit.
    choices : tuple of str
        Values of a parameter that is not a number.
    sequence : bool
        Whether the value is a list of numbers.
    scale : str
        What a small change of it is measured by: the ``value`` itself, the sampling ``period``, ``one``, or the
        ``slip`` of a clock by a period over the recording, or the ``resolution`` in frequency that the length of the
        recording allows.
    is_name : bool
        Whether it is a name and not a number: that of a state of the plant's equations.
    default : str or float or None
        Its value where nothing is said; None where it has to be.
    size : float
        What it is measured by where its value is zero; 0 where nothing is known.
    stated : bool
        Whether it is a number that is stated and not estimated, as one that the others are counted by.
    """

    name: str
    unit: str
    meaning: str
    lower: float = -inf
    upper: float = inf
    choices: tuple[str, ...] = ()
    sequence: bool = False
    scale: str = "value"
    is_name: bool = False
    default: str | float | None = None
    size: float = 0.0
    stated: bool = False

    @property
    def is_number(self) -> bool:
        """Whether its value is one number that may be estimated."""
        return not (self.choices or self.sequence or self.is_name or self.stated)


def checked(identifier: str, parameter: Parameter, value: Any) -> Any:
    """Value of a parameter of the effect with this identifier; ValueError where it must not have it."""
    if parameter.is_name:
        if not isinstance(value, str):
            raise ValueError(f"{identifier}, {parameter.name}: {value!r} is not a name")
        return str(value)
    if parameter.choices:
        if value not in parameter.choices:
            raise ValueError(f"{identifier}, {parameter.name}: '{value}' is not one of {', '.join(parameter.choices)}")
        return str(value)
    if parameter.sequence:
        numbers = np.asarray(value, dtype=float)
        if numbers.ndim != 1 or not np.all(np.isfinite(numbers)):
            raise ValueError(f"{identifier}, {parameter.name}: {value!r} is not a list of finite numbers")
        return numbers.tolist()
    if isinstance(value, str | bool) or not isfinite(float(value)):
        raise ValueError(f"{identifier}, {parameter.name}: {value!r} is not a finite number")
    number = float(value)
    if not parameter.lower <= number <= parameter.upper:
        raise ValueError(
            f"{identifier}, {parameter.name} = {number:g}: it must lie between {parameter.lower:g} and "
            f"{parameter.upper:g}"
        )
    return number
