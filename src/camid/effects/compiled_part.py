"""Functions of an effect that the integrator calls by their address."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from ctypes import CFUNCTYPE, POINTER, c_double
from typing import Any

from numba import types

from camid.compiled import callback

ARGUMENTS = ("time", "position", "velocity", "signal", "memory", "values")
# Zeros behind the values that a single call gets: what reads beyond them reads no foreign memory.
MARGIN = 64
SIGNATURE = types.float64(*[types.float64] * 5, types.CPointer(types.float64))


class Compiled:
    """A function (time, position, velocity, input, memory, values) → float that the integrator calls by its address.

    It is compiled when it is first needed and kept on disk. ``values`` is indexed like an array. Time in seconds,
    velocity in units of y per second.
    """

    def __init__(self, function: Callable[..., float]) -> None:
        self.function = function
        self._callback: Any = None

    @property
    def address(self) -> int:
        """Where the compiled function lies in memory."""
        if self._callback is None:
            self._callback = callback(SIGNATURE, self.function)
        return int(self._callback.address)

    def at(self, *arguments: float, values: Sequence[float]) -> float:
        """What the compiled function returns for time, position, velocity, input and memory."""
        numbers = (c_double * (len(values) + MARGIN))(*values)
        return float(CFUNCTYPE(c_double, *[c_double] * 5, POINTER(c_double))(self.address)(*arguments, numbers))

    def along(self, *arguments: Iterable[float], values: Sequence[float]) -> list[float]:
        """What it returns for rows of time, position, velocity, input and memory."""
        numbers = (c_double * (len(values) + MARGIN))(*values)
        function = CFUNCTYPE(c_double, *[c_double] * 5, POINTER(c_double))(self.address)
        return [function(*row, numbers) for row in zip(*arguments, strict=True)]


def compiled(function: Callable[..., float]) -> Compiled:
    """Mark a function of an effect's class body as compiled code, see :class:`Compiled`."""
    return Compiled(function)
