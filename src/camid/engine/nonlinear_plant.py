"""A plant of nonlinear equations with the values of its constants, ready for the engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from camid.effects.base import LimitedState
from camid.engine.plant_equations import PlantEquations
from camid.physical.equations import Equations, Linearisation, PlantFunction, linearised, plant_function

Array = NDArray[np.float64]

# A level over its edge flows off with this many times the rate of its storage, and its edge is rounded over this share
# of its height: were it sharp, a fit would see jumps where it varies the height.
STEEPNESS = 30.0
EDGE_WIDTH = 0.03
# A level, in any unit, whose square is still a number.
NO_LEVEL = 1e-150


@dataclass(frozen=True)
class NonlinearPlant:
    """Equations with values.

    Attributes
    ----------
    equations : Equations
    values : ndarray, shape (p,)
        Of the constants.
    seen : int, optional
        Number of the reading that the sensor sees in place of the output.

    Raises
    ------
    ValueError
        If the equations have no slope at their start.
    """

    equations: Equations
    values: Array
    seen: int | None = None

    @property
    def start(self) -> Array:
        """State before the recording, shape (n,)."""
        return np.array(self.equations.start, dtype=float)

    @property
    def function(self) -> PlantFunction:
        """The equations as machine code."""
        return plant_function(self.equations)

    @cached_property
    def about_start(self) -> Linearisation:
        """The equations linearised at their start."""
        return linearised(self.function, self.start, self.values)

    def block(self) -> tuple[Array, Array, Array, Array]:
        """Matrix, where the input enters, output row and direct part of states, output y and its rate, linearised.

        Without forces y grows with its rate, and that with the acceleration.
        """
        about, order = self.about_start, self.function.order
        size = order + 2 if self.seen is None else order + 4
        matrix, enters = np.zeros((size, size)), np.zeros(size)
        matrix[:order, :order] = about.state_matrix
        matrix[order, order + 1] = 1.0
        matrix[order + 1, :order] = about.rate_row @ about.state_matrix
        enters[: order + 2] = [*about.input_vector, about.rate_input, about.rate_row @ about.input_vector]
        if self.seen is not None:  # a reading grows with its rate, which follows from the states
            matrix[order + 2, order + 3] = 1.0
        return matrix, enters, np.eye(size)[size - 2], np.zeros(1)

    def limits(self, limited: Sequence[LimitedState]) -> Array:
        """Limited states as compiled code takes them, shape (l, 6); see :class:`PlantEquations`.

        Raises
        ------
        ValueError
            If the equations have no such state.
        """
        names, matrix, rows = self.equations.state_names, self.about_start.state_matrix, []
        for one in limited:
            if one.state not in names:
                raise ValueError(f"the plant's equations have no state '{one.state}', but {', '.join(names)}")
            index = names.index(one.state)
            fed = [i for i in range(len(names)) if i != index and matrix[i, index] > 0.0]
            width = EDGE_WIDTH * abs(one.edge) + NO_LEVEL
            rate = STEEPNESS * abs(float(matrix[index, index]))
            rows.append([index, one.edge - 0.5 * width, rate, width, one.share, fed[0] if fed else -1])
        return np.array(rows, dtype=float).reshape(-1, 6)

    def compiled(
        self,
        line: tuple[int, Array, float],
        probe: float,
        limited: Sequence[LimitedState],
        *,
        forced: bool,
        dry: bool,
    ) -> PlantEquations:
        """As compiled code takes them; see :class:`PlantEquations`.

        ``line`` says where the states begin and what enters the plant; ``forced`` whether a force depends on the motion
        of it, and ``dry`` whether one is dry friction.
        """
        first, driving, driving_input = line
        code = plant_function(self.equations, self.seen)
        order, (function, data) = code.order, code.compiled.addresses()
        given = np.concatenate([np.zeros(order + 1), self.values])
        found = np.zeros(code.compiled.count)
        extremes = np.array([np.full(order, np.inf), np.full(order, -np.inf), np.zeros(order)])
        return PlantEquations(
            function,
            data,
            first,
            order,
            driving,
            driving_input,
            given,
            found,
            (found.ctypes.data, given.ctypes.data),
            self.about_start.rate_input,
            probe,
            forced,
            dry,
            extremes,
            self.limits(limited),
            self.seen is not None,
        )
