"""A plant of nonlinear equations, as compiled code takes it: rates by a function that is called by its address."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from camid.compiled import kernel

Array = NDArray[np.float64]


class PlantEquations(NamedTuple):
    """ẋ = f(x, v), y = h(x), with the force and what enters the plant as its input v.

    In the state of a chain the plant's states x are followed by y and by the rate of y without input.

    Attributes
    ----------
    function, data : int
        Address of (double* found, double* given, void* data) and its data; 0 for a linear plant.
    first, order : int
        Where the plant's states begin, and how many they are.
    driving : ndarray, shape (q,)
    driving_input : float
        What enters the plant: this row of the chain's state, and this much of the input.
    given : ndarray, shape (n + 1 + p,)
        Room for the states and the input, and the constants.
    found : ndarray, shape (n + 2,) or (n + 4,)
        Room for the rates, the output and its rate, a reading and its rate.
    addresses : tuple of (int, int)
        Where ``found`` and ``given`` lie in memory.
    rate_input : float
        What a unit of v adds to the rate of y at once.
    probe : float
        Seconds over which the acceleration is a difference of velocities.
    forced : bool
        Whether a force depends on the motion, so that output and rate have to be known before the rates.
    follows_acceleration : bool
        Whether dry friction asks for it.
    extremes : ndarray, shape (3, n)
        Least and largest value of each state, and the largest doubt about its change over a step.
    limits : ndarray, shape (l, 6)
        States that run over an edge: index, level at which that begins, rate of the outflow in 1/s, width over which it
        sets in, share that reaches another state, and the index of that (-1: none).
    reads : bool
        Whether a reading and its rate follow output and rate, in the state and in ``found``.
    """

    function: int
    data: int
    first: int
    order: int
    driving: Array
    driving_input: float
    given: Array
    found: Array
    addresses: tuple[int, int]
    rate_input: float
    probe: float
    forced: bool
    follows_acceleration: bool
    extremes: Array
    limits: Array
    reads: bool


def no_equations() -> PlantEquations:
    """What stands for a linear plant."""
    empty, extremes, limits = np.zeros(0), np.zeros((3, 0)), np.zeros((0, 6))
    nothing = (empty, empty, (0, 0), 0.0, 0.0, False, False, extremes, limits, False)
    return PlantEquations(0, 0, 0, 0, empty, 0.0, *nothing)


def _call_by_address(typing_context: Any, address: Any, found: Any, given: Any, data: Any) -> Any:
    """Call (double*, const double*, void*) by its address."""
    signature = types.void(types.int64, types.int64, types.int64, types.int64)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        double, anything = ir.DoubleType().as_pointer(), ir.IntType(8).as_pointer()
        function = ir.FunctionType(ir.VoidType(), [double, double, anything])
        pointer = builder.inttoptr(arguments[0], function.as_pointer())
        kinds = (double, double, anything)
        builder.call(pointer, [builder.inttoptr(a, kind) for a, kind in zip(arguments[1:], kinds, strict=True)])
        return context.get_dummy_value()

    return signature, generate


_call: Any = intrinsic(_call_by_address)


@kernel(forceinline=True)
def _evaluate(e: PlantEquations, state: Array, signal: float) -> None:
    """Fill ``found`` for a state of the chain and a signal at the plant's input."""
    for i in range(e.order):
        e.given[i] = state[e.first + i]
    e.given[e.order] = signal
    _call(e.function, e.addresses[0], e.addresses[1], e.data)


@kernel(forceinline=True)
def project(e: PlantEquations, state: Array) -> None:
    """Set output and rate in a state of the chain to those of the plant's states."""
    _evaluate(e, state, 0.0)
    state[e.first + e.order] = e.found[e.order]
    state[e.first + e.order + 1] = e.found[e.order + 1]
    if e.reads:
        state[e.first + e.order + 2] = e.found[e.order + 2]
        state[e.first + e.order + 3] = e.found[e.order + 3]


@kernel(forceinline=True)
def entering(e: PlantEquations, state: Array, signal: float, force: float) -> float:
    """What enters the plant: what a block before it makes of the input, and the force."""
    total = e.driving_input * signal + force
    for i in range(len(e.driving)):
        total += e.driving[i] * state[i]
    return total


@kernel(forceinline=True)
def plant_rates(e: PlantEquations, state: Array, signal: float, result: Array) -> None:
    """Fill the plant's part of the chain's rates, with the acceleration where friction asks for it.

    ``state`` is left as it is; ``signal`` is what enters the plant.
    """
    _evaluate(e, state, signal)
    first, count = e.first, e.order
    for i in range(count):
        result[first + i] = e.found[i]
    for limit in e.limits:
        over = state[first + int(limit[0])] - limit[1]
        if over > 0.0:
            spilt = limit[2] * (over - 0.5 * limit[3] if over > limit[3] else 0.5 * over * over / limit[3])
            result[first + int(limit[0])] -= spilt
            if limit[5] >= 0.0:
                result[first + int(limit[5])] += limit[4] * spilt
    result[first + count] = e.found[count + 1]
    result[first + count + 1] = 0.0
    if e.reads:
        result[first + count + 2] = e.found[count + 3]
        result[first + count + 3] = 0.0
    if not e.follows_acceleration:
        return
    for i in range(count):
        e.given[i] = state[first + i] + e.probe * result[first + i]
    e.given[count] = 0.0
    _call(e.function, e.addresses[0], e.addresses[1], e.data)
    ahead = e.found[count + 1]
    for i in range(count):
        e.given[i] = state[first + i] - e.probe * result[first + i]
    _call(e.function, e.addresses[0], e.addresses[1], e.data)
    result[first + count + 1] = (ahead - e.found[count + 1]) / (2.0 * e.probe)


@kernel(forceinline=True)
def free_rates(e: PlantEquations, state: Array, signal: float, result: Array) -> None:
    """Fill the plant's part of the chain's rates where no force acts, and the output in the state."""
    plant_rates(e, state, signal, result)
    state[e.first + e.order] = e.found[e.order]
    if e.reads:
        state[e.first + e.order + 2] = e.found[e.order + 2]


@kernel
def held_rates(e: PlantEquations, state: Array, signal: float, result: Array) -> float:
    """The same with the force that keeps the velocity as it is; that force, along the input.

    The acceleration is taken to be a straight line in what enters the plant.
    """
    at = e.first + e.order + 1
    plant_rates(e, state, signal + 1.0, result)
    above = result[at]
    plant_rates(e, state, signal, result)
    gain = above - result[at]
    if gain == 0.0:
        return 0.0
    hold = result[at] / gain
    plant_rates(e, state, signal - hold, result)
    result[at - 1], result[at] = 0.0, 0.0
    return hold


@kernel(forceinline=True)
def remember_extremes(e: PlantEquations, state: Array, second: Array, third: Array, step: float) -> None:
    """Take a state and two estimates of its rate in the middle of a step into account."""
    for i in range(e.order):
        value = state[e.first + i]
        e.extremes[0, i] = min(e.extremes[0, i], value)
        e.extremes[1, i] = max(e.extremes[1, i], value)
        e.extremes[2, i] = max(e.extremes[2, i], step * abs(third[e.first + i] - second[e.first + i]))


@kernel
def doubt_of(e: PlantEquations) -> float:
    """Largest doubt about the change of a state over a step, as a share of the range that it covers."""
    doubt = 0.0
    for i in range(e.order):
        covered = e.extremes[1, i] - e.extremes[0, i]
        if covered > 0.0:
            doubt = max(doubt, e.extremes[2, i] / covered)
    return doubt
