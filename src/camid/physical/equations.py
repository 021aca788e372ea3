"""Nonlinear plants as equations: ẋ = f(x, u, constants), y = h(x)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction
from camid.physical.expressions import Compiled, parsed, symbols

Array = NDArray[np.float64]

# Step of the differences that replace derivatives, as a share of a state, and least size of one.
DIFFERENCE = 1e-5
LEAST_SIZE = 1e-3
# Share of the largest one below which a coefficient of the linearised plant is rounding.
ROUNDING = 1e-7
# Relative change of a constant whose effect on the coefficients is looked at.
CHANGE = 1e-4
# Functions with kinks, which an output must not have: its rate follows from its slope.
KINKED = ("abs", "sign", "min", "max")


@dataclass(frozen=True)
class Equations:
    """Expressions of a plant's states, its input and its constants.

    Attributes
    ----------
    names : tuple of str
        The constants.
    states : tuple of (str, str)
        Name of each state, and its derivative by the time in seconds.
    output : str
        An expression of states and constants.
    input : str
        What the input is called in them.
    start : tuple of float
        State at rest before the recording, or where a fit of the initial state starts; the plant is linearised there.
    readings : tuple of str
        What several columns of the sensor read, expressions of states and constants; else it reads the output.
    """

    names: tuple[str, ...]
    states: tuple[tuple[str, str], ...]
    output: str
    input: str = "u"
    start: tuple[float, ...] = ()
    readings: tuple[str, ...] = ()

    @property
    def state_names(self) -> tuple[str, ...]:
        """Of the states, in their order."""
        return tuple(name for name, _ in self.states)

    def to_mapping(self) -> dict[str, Any]:
        """Part of a simulation file."""
        content: dict[str, Any] = {"states": dict(self.states), "output": self.output, "input": self.input}
        if any(self.start):
            content["start"] = dict(zip(self.state_names, map(float, self.start), strict=True))
        return {"equations": content}


class PlantFunction:
    """Equations as machine code: rates of the states, the output and its rate, and those of a reading, if it has one.

    Attributes
    ----------
    compiled : Compiled
        Of the n states, the input and the p constants, shape (n + 1 + p,), to the n rates, the output and its rate, and
        the reading and its rate.
    order : int
        Number of states n.
    measured_state : int or None
        State that the output is, where it is one.
    compiled_slopes : Compiled or None
        Derivatives of rates, output and its rate by the n states and the input, row by row; None where a function with
        a kink has none.
    """

    def __init__(self, equations: Equations, seen: int | None = None) -> None:
        """Of equations; ``seen`` is the number of the reading that is compiled with them."""
        every = (*equations.state_names, equations.input, *equations.names)
        rates = [parsed(text, every) for _, text in equations.states]
        output, *readings = (self._smooth(equations, text) for text in (equations.output, *equations.readings))
        known = symbols(equations.state_names)
        followed = [output] if seen is None else [output, readings[seen]]
        self.order = len(rates)
        self.used = {str(symbol) for part in (*rates, output, *readings) for symbol in part.free_symbols}
        found = [*rates, *(part for one in followed for part in (one, _rate(one, known, rates)))]
        self.compiled = Compiled(symbols(every), found)
        moves = symbols((*equations.state_names, equations.input))
        self.compiled_slopes = _slopes(found[: self.order + 2], moves, every)
        self.measured_state = next((i for i, symbol in enumerate(known) if output == symbol), None)

    @staticmethod
    def _smooth(equations: Equations, text: str) -> Any:
        """An expression of states and constants, without kinks."""
        found = parsed(text, (*equations.state_names, *equations.names))
        for name in KINKED:
            if f"{name}(" in str(found):
                raise ValueError(f"the output '{text}' has a kink ({name}): write it without")
        return found

    def depends_on(self, constant: str) -> bool:
        """Whether a constant is in any of the equations."""
        return constant in self.used

    def __call__(self, state: Array, signal: float, constants: Array) -> Array:
        """Rates, output and its rate, shape (n + 2,)."""
        return self.compiled(np.concatenate([state, [signal], constants]))


def _slopes(found: Sequence[Any], by: Sequence[Any], every: Sequence[str]) -> Compiled | None:
    """Derivatives of expressions, compiled; None where they have none that can be written down."""
    derivatives = [expression.diff(symbol) for expression in found for symbol in by]
    if any(name in str(derivative) for derivative in derivatives for name in (*KINKED, "Derivative", "Subs")):
        return None
    return Compiled(symbols(every), derivatives)


def _rate(output: Any, states: Sequence[Any], rates: Sequence[Any]) -> Any:
    """Rate of an output of the states."""
    import symengine

    return sum((output.diff(x) * f for x, f in zip(states, rates, strict=True)), symengine.Integer(0))


@lru_cache(maxsize=64)
def plant_function(equations: Equations, seen: int | None = None) -> PlantFunction:
    """The machine code of equations, compiled once; ``seen`` is the number of the reading that it has.

    Raises
    ------
    ValueError
        If an expression is none.
    """
    return PlantFunction(equations, seen)


@dataclass(frozen=True)
class Linearisation:
    """ẋ = A x + B v, y = C x about a point, with the rate of the output.

    Attributes
    ----------
    state_matrix : ndarray, shape (n, n)
    input_vector : ndarray, shape (n,)
    output_row, rate_row : ndarray, shape (n,)
        Derivatives of the output and of its rate by the states.
    rate_input : float
        Derivative of the output's rate by the input.
    """

    state_matrix: Array
    input_vector: Array
    output_row: Array
    rate_row: Array
    rate_input: float

    def transfer_function(self) -> TransferFunction:
        """From the input to the output, by the method of Faddeev and Le Verrier; 1/A(s) where no input reaches it."""
        count = len(self.state_matrix)
        adjugate, numerator, denominator = np.eye(count), [], [1.0]
        scale = float(np.max(np.abs(self.state_matrix), initial=1e-300))
        for step in range(1, count + 1):
            numerator.append(float(self.output_row @ adjugate @ self.input_vector))
            adjugate = self.state_matrix @ adjugate
            coefficient = -float(np.trace(adjugate)) / step
            denominator.append(coefficient if abs(coefficient) > ROUNDING * scale**step else 0.0)
            adjugate = adjugate + coefficient * np.eye(count)
        # Coefficients of powers of the time scale, so that they can be compared.
        sizes = np.abs(numerator) / scale ** np.arange(count)
        kept = np.where(sizes > ROUNDING * float(np.max(sizes, initial=0.0)), numerator, 0.0)
        if not np.any(kept):  # as of a free decay, whose numerator says nothing
            kept = np.array([1.0])
        return TransferFunction(tuple(np.trim_zeros(kept, "f")), tuple(denominator))


def linearised(function: PlantFunction, state: Array, constants: Array) -> Linearisation:
    """Equations about a state, without input.

    Raises
    ------
    ValueError
        If they are not numbers there.
    """
    order = function.order
    if function.compiled_slopes is None:
        table = _differences(function, state, constants)
    else:
        point = np.concatenate([state, [0.0], constants])
        table = function.compiled_slopes(point).reshape(order + 2, order + 1)
    if not np.all(np.isfinite(table)):
        raise ValueError("the equations have no slope at the state of the start")
    return Linearisation(
        table[:order, :order],
        table[:order, order],
        table[order, :order],
        table[order + 1, :order],
        float(table[order + 1, order]),
    )


def _differences(function: PlantFunction, state: Array, constants: Array) -> Array:
    """Derivatives of rates, output and its rate by states and input, shape (n + 2, n + 1), by central differences."""
    order = function.order
    table = np.empty((order + 2, order + 1))
    for i in range(order + 1):
        here = float(state[i]) if i < order else 0.0
        step = DIFFERENCE * max(abs(here), LEAST_SIZE)
        ends = []
        for side in (step, -step):
            moved, signal = state.astype(float).copy(), 0.0
            if i < order:
                moved[i] += side
            else:
                signal = side
            ends.append(function(moved, signal, constants))
        table[:, i] = (ends[0] - ends[1]) / (2.0 * step)
    return table


def transfer_function_of(equations: Equations, values: Array) -> TransferFunction:
    """Monic plant of small motions about the start.

    Raises
    ------
    ValueError
        If there is none.
    """
    start = np.array(equations.start, dtype=float)
    return linearised(plant_function(equations), start, values).transfer_function()


def coefficients_at(equations: Equations, values: Array, count: int) -> Array:
    """[b_0 … b_m, a_1 … a_n] of that plant, shape (count,).

    Raises
    ------
    ValueError
        If there is none, or it has another number of coefficients.
    """
    plant = transfer_function_of(equations, values)
    found = np.array([*plant.numerator, *plant.denominator[1:]])
    if len(found) != count:
        raise ValueError("the plant about its start has another order with these constants")
    return found


def sensitive_to(equations: Equations, values: Array) -> Array:
    """Changes of those coefficients by relative changes of the constants, shape (m + 1 + n, p)."""
    plant = transfer_function_of(equations, values)
    centre = np.array([*plant.numerator, *plant.denominator[1:]])
    table = np.zeros((len(centre), len(values)))
    for i, value in enumerate(values):
        moved = values.copy()
        step = CHANGE * (abs(value) or 1.0)
        moved[i] += step
        change = coefficients_at(equations, moved, len(centre)) - centre
        table[:, i] = np.where(np.abs(change) > ROUNDING * np.abs(centre), change / CHANGE, 0.0)
    return table


def state_at_rest(equations: Equations, values: Array, output: float) -> dict[str, float] | None:
    """States by name where the plant rests, under whatever constant input, at an output; None if it does nowhere."""
    from scipy.optimize import root

    function, order = plant_function(equations), len(equations.states)

    def error(point: Array) -> Array:
        found = function(point[:order], float(point[order]), values)
        return np.nan_to_num(np.append(found[:order], found[order] - output), nan=1e6, posinf=1e6, neginf=-1e6)

    begin = np.append(np.array(equations.start, dtype=float), 0.0)
    if function.measured_state is not None:
        begin[function.measured_state] = output
    found = root(error, begin)
    if not found.success:
        return None
    return dict(zip(equations.state_names, map(float, found.x[:order]), strict=True))
